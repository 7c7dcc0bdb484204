"""Differences of residuals between the models beside a parameter, of those parts alone that differ."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import chain, compress, islice

import numpy as np
from scipy import sparse

from lamella._jit import kernel, njit
from lamella.assembly.equations import Equations
from lamella.assembly.forces import ForceSum
from lamella.assembly.mass import in_independent
from lamella.assembly.operator import VectorOperator
from lamella.assembly.point import Point, Weights
from lamella.assembly.product import Ahead
from lamella.differentiation.alike import alike
from lamella.inertia import differenced
from lamella.roles import ConstraintBlock, Floats, Force, ForceBlock, ForceChange

LOST = 1e-8
"""What a difference of masses may lose, as a share of the masses on the diagonal."""


@dataclass(frozen=True)
class Side:
    """A model beside the value of a parameter.

    Args:
        distance: of the parameter from the value, in its unit.
        weight: of the side in a derivative [1 / unit].
        equations: of the model there.
    """

    distance: float
    weight: float
    equations: Equations


class WholeDifference:
    """Derivatives of r and Phi by a parameter, from whole residuals.

    Args:
        sides: the models beside its value.
    """

    def __init__(self, sides: Sequence[Side]) -> None:
        self._sides = sides

    def __call__(self, point: Point, dud: Floats | None, dudd: Floats | None) -> tuple[Floats, Floats]:
        """The derivatives with u and lam as they are, and velocities and accelerations that follow the parameter, if given."""
        r, phi = np.zeros_like(point.u), np.zeros_like(point.lam)
        for side in self._sides:
            there, equations = point, side.equations
            if dud is not None and dudd is not None:
                ud = moved(point.ud, side.distance, dud) if equations.depends_on_velocity else point.ud
                there = Point(point.t, point.u, ud, moved(point.udd, side.distance, dudd), point.lam, point.factor)
            of_forces, of_constraints = equations.residual(there)
            _add(side.weight, of_forces, r)
            if len(phi):
                phi += side.weight * of_constraints
        return r, phi


class PartDifference:
    """The same from those blocks alone that the parameter changes or that depend on velocities: what is equal in all models
    cancels, and of inertia M dudd + dM/dp udd is left.

    Args:
        base: the equations at the value of the parameter.
        sides: the models beside it, with the same constraints and the same map from changes of unknowns to those of coordinates.

    Attributes:
        follows: whether coordinates may follow the parameter as well: where all forces that depend on them tell of both at once.
        moves: whether supports hold coordinates where the parameter says, so that these must follow.
    """

    def __init__(self, base: Equations, sides: Sequence[Side]) -> None:
        self._base, self._sides, equations = base, sides, [side.equations for side in sides]
        self._forces = _Parts(base, base.forces, sides, [there.forces for there in equations])
        self._loads = _Parts(base, base.loads, sides, [there.loads for there in equations])
        held = sum(side.weight * (side.equations.held - base.held) for side in sides)
        self._held, self._still = np.zeros((2, base.model.n_q))
        self._held += held
        self.moves = bool(self._held.any())
        alone = base.n_u == base.n_motion and not base.n_lam
        self.follows = alone and self._forces.follows and self._loads.follows

    def __call__(self, point: Point, dud: Floats | None, dudd: Floats | None) -> tuple[Floats, Floats]:
        """The derivatives, as :class:`WholeDifference` gives them."""
        return self._with_inertia(*self.apart(point, dud, dudd))

    def apart(self, point: Point, dud: Floats | None, dudd: Floats | None) -> tuple[Floats, Floats, Floats | None]:
        """The same without M a, and a: M a belongs to the first; None where there is none."""
        base = self._base
        dv = base.expand(dud) if dud is not None and base.depends_on_velocity else None
        return self._apart(point, self._held if self.moves else None, dv, dudd)

    def along(
        self, point: Point, dud: Floats, dudd: Floats, du: Floats, weights: Weights, ahead: Ahead | None = None
    ) -> tuple[Floats, Floats]:
        """The same of unknowns that follow the parameter by ``du``, with velocities and accelerations that belong to it.

        Only where coordinates may follow. The product of the tangent with ``du`` is in it, for little more time; other products
        ``ahead`` at the point need not look at it then.
        """
        base = self._base
        dq = base.expand.onto(du, self._held.copy()) if self.moves else base.expand(du)
        dv = None
        if base.depends_on_velocity:
            dv = base.expand(moved(dud, weights.alpha_v, du))
        return self._with_inertia(*self._apart(point, dq, dv, moved(dudd, weights.alpha_a, du), ahead))

    def _apart(
        self, point: Point, dq: Floats | None, dv: Floats | None, dudd: Floats | None, ahead: Ahead | None = None
    ) -> tuple[Floats, Floats, Floats | None]:
        base, r = self._base, np.zeros(len(point.u))
        q, v = base.coordinates(point), base.force_velocities(point)
        if dq is not None and dv is None:
            dv = self._still
        self._loads.add(point.t, q, v, dq, dv, r)
        if point.factor != 1.0:
            r *= point.factor
        self._forces.add(point.t, q, v, dq, dv, r, ahead)
        if not point.at_rest:
            mass = self._mass
            if isinstance(mass, _MassDifference):
                mass.add_force(point, r)
            elif mass is not None:
                dudd = mass * point.udd if dudd is None else moved(dudd, mass, point.udd)
        return r, np.zeros(len(point.lam)), dudd

    def _with_inertia(self, r: Floats, phi: Floats, dudd: Floats | None) -> tuple[Floats, Floats]:
        return r if dudd is None else self._base.inertia_force(dudd, onto=r), phi

    @cached_property
    def _mass(self) -> _MassDifference | float | None:
        """The difference of the masses, or which share of the mass it is, if there is one; nothing at rest needs it, and it takes
        a good part of the time there.
        """
        first, *others = inertias = [side.equations.model.inertias for side in self._sides]
        if all(alike(first, other) for other in others):
            return None
        m = differenced(inertias, [side.weight for side in self._sides], self._base.model.n_motion // 3)
        if not m.data.any():
            return None
        share = None if self._base.elimination.moves else proportion(m, self._base.model.vector_mass)
        return _MassDifference(self._base, m) if share is None else share


def proportion(part: sparse.csr_array, whole: sparse.csr_array) -> float | None:
    """c, if the mass ``part`` is c ``whole`` up to what a difference loses, as that of a plate by its thickness or density."""
    if not (np.array_equal(part.indptr, whole.indptr) and np.array_equal(part.indices, whole.indices)):
        return None
    share = float(part.data @ whole.data / (whole.data @ whole.data))
    size = np.sqrt(abs(share) * whole.diagonal())
    rows = np.repeat(np.arange(len(size)), np.diff(whole.indptr))
    return share if np.all(abs(part.data - share * whole.data) <= LOST * size[rows] * size[whole.indices]) else None


class _MassDifference:
    """dM/dp = m x 1_3."""

    def __init__(self, base: Equations, m: sparse.csr_array) -> None:
        reduced = None if base.elimination.moves else in_independent(m, base.elimination.T)
        self._base, self._is_reduced, self._times = base, reduced is not None, reduced or VectorOperator(m)

    def add_force(self, point: Point, r: Floats) -> None:
        """Add T^T dM/dp a to r, with all accelerations a = T udd and those of supports."""
        if self._is_reduced:
            self._times.onto(point.udd, r)
        else:
            self._base.gather.onto(self._times(self._base.accelerations(point)), r)


class _Parts:
    """The blocks of a sum that differ between models, or depend on velocities.

    Args:
        base: the equations at the value of the parameter.
        of_base: the sum there.
        sides, sums: the models beside it, with their sums.
    """

    def __init__(self, base: Equations, of_base: ForceSum, sides: Sequence[Side], sums: Sequence[ForceSum]) -> None:
        blocks = [*zip(*([block for block, _ in each.parts] for each in sums), strict=True)]
        changed = [remembers(first) or not all(alike(first, other) for other in others) for first, *others in blocks]
        of_values = [block for block, _ in of_base.parts]
        wholes = [
            _whole(value, beside, sides) if one else None for one, value, beside in zip(changed, of_values, blocks, strict=True)
        ]
        changed = [one and whole is None for one, whole in zip(changed, wholes, strict=True)]
        linear = [not one and block.linear_in_velocity for one, (block, *_) in zip(changed, blocks, strict=True)]
        others = [one or block.depends_on_velocity for one, (block, *_) in zip(changed, blocks, strict=True)]
        moving = [one and not other for one, other in zip(others, linear, strict=True)]
        of_all = base.model.n_q, base.elimination.T
        self._wholes = ForceSum([whole for whole in wholes if whole], *of_all, like=of_base)
        self._of_wholes = [block for block, whole in zip(of_values, wholes, strict=True) if whole]
        self._linear = ForceSum([block for block, _ in compress(of_base.parts, linear)], *of_all)
        self._seeing = any(block.depends_on_velocity for block, _ in of_base.parts)
        self.follows = all(
            isinstance(whole, ForceChange) or not (block.depends_on_velocity or len(block.k_rows))
            for block, whole in zip(of_values, wholes, strict=True)
        )
        self._changed, self._moving = (_Weighed(sides, sums, chosen, *of_all) for chosen in (changed, moving))

    def add(
        self, t: float, q: Floats, v: Floats, dq: Floats | None, dv: Floats | None, r: Floats, ahead: Ahead | None = None
    ) -> None:
        """Add the derivative of their forces to r, with coordinates and velocities that follow the parameter if these are given;
        coordinates only where they may (``follows``).
        """
        if self._wholes.parts:
            ahead = ahead or Ahead(None, None)
            for (change, part), block in zip(self._wholes.parts, self._of_wholes, strict=True):
                if dq is not None and dv is not None and isinstance(change, ForceChange):
                    ahead.along(change, block, t, q, v, dq, dv, part)
                else:
                    change.force(t, q, v, part)
            self._wholes.onto(r)
        if dv is None or dq is not None:  # those that depend on velocities have been asked already
            self._changed.add(t, q, v, None, r)
            return
        for block, part in self._linear.parts:
            block.damping_force(t, q, dv, part)
        self._linear.onto(r)
        self._moving.add(t, q, v, dv if self._seeing else None, r)


def _whole(block: ForceBlock, beside: Sequence[ForceBlock], sides: Sequence[Side]) -> Force | None:
    """One force for the weighed sum of a block of all sides; None where there is none.

    Where the velocities follow the parameter by dv, sum w_i f_i(v + d_i dv) is sum w_i f_i(v) and the damping of dv by
    sum w_i d_i C_i, which is that of the base but for the error of the difference.
    """
    if remembers(block) or (block.depends_on_velocity and not block.linear_in_velocity):
        return None
    return block.force_change(beside, [side.weight for side in sides])


class _Weighed:
    """Chosen blocks of all sides, whose forces are summed at once with the weights of the sides."""

    def __init__(
        self, sides: Sequence[Side], sums: Sequence[ForceSum], chosen: Sequence[bool], n_q: int, T: sparse.csr_array
    ) -> None:
        blocks = [[block for block, _ in compress(each.parts, chosen)] for each in sums]
        weights = [side.weight for side, own in zip(sides, blocks, strict=True) for _ in own]
        self._sum = ForceSum([*chain.from_iterable(blocks)], n_q, T, weights=weights)
        parts = iter(self._sum.parts)
        self._of_sides = [(side.distance, [*islice(parts, len(own))]) for side, own in zip(sides, blocks, strict=True)]

    def add(self, t: float, q: Floats, v: Floats, dv: Floats | None, r: Floats) -> None:
        """Add the weighed forces to r, with the velocities of each side along ``dv`` if it is given."""
        if not self._sum.parts:
            return
        for distance, parts in self._of_sides:
            there = v if dv is None else moved(v, distance, dv)
            for block, part in parts:
                block.force(t, q, there, part)
        self._sum.onto(r)


def difference_of(base: Equations, sides: Sequence[Side]) -> WholeDifference | PartDifference:
    """The difference of residuals between models."""
    constraints = [side.equations.model.constraints for side in sides]
    same = all(
        side.equations.elimination.changes_like(base.elimination) and _count(side.equations) == _count(base) for side in sides
    )
    if same and not any(map(remembers, constraints[0])) and all(alike(constraints[0], other) for other in constraints[1:]):
        of_parts = PartDifference(base, sides)
        if of_parts.follows or not of_parts.moves:
            return of_parts
    return WholeDifference(sides)


def _count(equations: Equations) -> tuple[int, int]:
    return len(equations.forces.parts), len(equations.loads.parts)


def remembers(block: ForceBlock | ConstraintBlock) -> bool:
    """Whether a block has a discrete state."""
    return type(block).settle not in (ForceBlock.settle, ConstraintBlock.settle)


@njit
def moved(x: Floats, distance: float, along: Floats) -> Floats:
    """x + distance along."""
    there = np.empty_like(x)
    for i in range(len(x)):
        there[i] = x[i] + distance * along[i]
    return there


@kernel
def _add(weight: float, part: Floats, total: Floats) -> None:
    for i in range(len(total)):
        total[i] += weight * part[i]
