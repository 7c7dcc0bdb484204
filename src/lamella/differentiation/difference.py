"""Differences of residuals between the models beside a parameter, of those parts alone that differ."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property

import numpy as np
from scipy import sparse

from lamella._jit import kernel
from lamella.assembly.equations import Equations
from lamella.assembly.forces import ForceSum
from lamella.assembly.holding import Holding
from lamella.assembly.mass import in_independent
from lamella.assembly.operator import VectorOperator
from lamella.assembly.point import Point, Weights
from lamella.assembly.product import Ahead
from lamella.differentiation.alike import alike
from lamella.differentiation.parts import ForceParts, Side, moved
from lamella.inertia import differenced
from lamella.roles import Floats, ForceChange, remembers
from lamella.state import State

Onto = Callable[[ForceSum, Floats], Floats]
"""Adds what a sum's buffer holds, in the coordinates that it chooses."""
LoadsAndForces = tuple[ForceParts, ForceParts]
LOST = 1e-8
"""What a difference of masses may lose, as a share of the masses on the diagonal."""


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
        follows: whether coordinates may follow the parameter as well: where all forces tell of both at once, and loads do not
            depend on them.
        moves: whether supports hold coordinates where the parameter says, so that these must follow.
        forces_differ: whether any block of the forces is another one in the models.
    """

    def __init__(self, base: Equations, sides: Sequence[Side]) -> None:
        self._base, self._sides, equations = base, sides, [side.equations for side in sides]
        self._forces = ForceParts(base.forces, sides, [there.forces for there in equations])
        self._loads = ForceParts(base.loads, sides, [there.loads for there in equations])
        held = sum(side.weight * (side.equations.held - base.held) for side in sides)
        self._held, self._still = np.zeros((2, base.model.n_q))
        self._held += held
        self.moves = bool(self._held.any())
        self._on_held: dict[Holding, _OnHeld] = {}
        self.follows = self._forces.complete and _of_forces(base)
        self.forces_differ = self._forces.differ

    def __call__(self, point: Point, dud: Floats | None, dudd: Floats | None) -> tuple[Floats, Floats]:
        """The derivatives, as :class:`WholeDifference` gives them."""
        return self._with_inertia(*self.apart(point, dud, dudd))

    def apart(self, point: Point, dud: Floats | None, dudd: Floats | None) -> tuple[Floats, Floats, Floats | None]:
        """The same without M a, and a: M a belongs to the first; None where there is none."""
        base = self._base
        dv = base.expand(dud) if dud is not None and base.depends_on_velocity else self._still if self.moves else None
        return self._apart(point, self._held if self.moves else None, dv, dudd)

    def along(
        self, point: Point, dud: Floats, dudd: Floats, du: Floats, weights: Weights, ahead: Ahead | None = None
    ) -> tuple[Floats, Floats]:
        """The same of unknowns that follow the parameter by ``du``, with velocities and accelerations that belong to it.

        Only where coordinates may follow. The product of the tangent with ``du`` is in it, for little more time; other products
        ``ahead`` at the point need not look at it then.
        """
        base, dv = self._base, self._still
        if base.depends_on_velocity:
            dv = base.expand(moved(dud, weights.alpha_v, du))
        return self._with_inertia(*self._apart(point, self._following(du), dv, moved(dudd, weights.alpha_a, du), ahead))

    def reaction(self, point: Point, state: State, change: State | None = None) -> Floats:
        """The derivative of the reaction M a + f + Phi_q^T lam, shape (n_q,), or of those of several states, (n, n_q).

        Args:
            point: where, or one of several points that differ by their states alone.
            state: there.
            change: how the state follows the unknowns, if these follow the parameter; only where coordinates may.
        """
        holding = self._holding.stack(len(state.q) if state.q.ndim > 1 else 1)
        assert holding is not None, "asked of stacks only where there are any"
        if holding not in self._on_held:
            self._on_held[holding] = _OnHeld(self._sides, holding, self.follows)
        on_held, near, damped = self._on_held[holding], holding.near, self._base.depends_on_velocity
        f, still = np.zeros((2, holding.n_near))
        dq, dv = (None, None) if change is None else (near(change.q), near(change.v) if damped else still)
        if self.moves:
            held = near(np.broadcast_to(self._held, state.q.shape))
            dq, dv = (held, still) if dq is None else (dq + held, dv)
        v = near(state.v) if damped else still
        self._add_forces(on_held.parts, point, near(state.q), v, dq, dv, f, ForceSum.onto_all)
        if not point.at_rest:
            mass, da = self._mass, None if change is None else near(change.a)
            if isinstance(mass, _MassDifference):
                holding.add_product(on_held.mass(mass.m), near(state.a), f)
            elif mass is not None:
                a = near(state.a)
                da = mass * a if da is None else moved(da, mass, a)
            if da is not None:
                holding.add_product(holding.mass, da, f)
        return holding.whole(f)

    @property
    def reactions_stack(self) -> bool:
        """Whether reactions of several states side by side are told, where they are in the models."""
        return self._holding is self._base.holding

    @cached_property
    def _holding(self) -> Holding:
        own = self._base.holding
        return own if all(own.is_like(side.equations.holding) for side in self._sides) else own.unparted

    @cached_property
    def _potentials(self) -> Sequence[ForceChange]:
        """What tells of the potential of all forces: where none changes, as by a load, the forces in the middle do."""
        if self.follows:
            return self._forces.changes
        changes = [block.force_change([block], [0.0]) for block, _ in self._base.forces.parts]
        found = [change for change in changes if isinstance(change, ForceChange)]
        return found if len(found) == len(changes) and not (self.forces_differ or self.moves) else []

    @property
    def tells_potential(self) -> bool:
        """Whether the potential of all forces, and how it follows, is told without differences."""
        return bool(self._potentials)

    def potential(self, t: float, state: State, change: State) -> tuple[float, float]:
        """The potential of all forces in a state, and its derivative along the change of the state that unknowns make and by the
        parameter.
        """
        dq = change.q + self._held if self.moves else change.q
        each = [force.energy(t, state.q, dq) for force in self._potentials]
        return sum(whole for whole, _ in each), sum(part for _, part in each)

    def _following(self, du: Floats) -> Floats:
        """How coordinates follow the parameter where unknowns do."""
        expand = self._base.expand
        return expand.onto(du, self._held.copy()) if self.moves else expand(du)

    def _apart(
        self, point: Point, dq: Floats | None, dv: Floats | None, dudd: Floats | None, ahead: Ahead | None = None
    ) -> tuple[Floats, Floats, Floats | None]:
        r, base = np.zeros(len(point.u)), self._base
        places = base.coordinates(point), base.force_velocities(point), dq, dv
        self._add_forces((self._loads, self._forces), point, *places, r, ForceSum.onto, ahead)
        if not point.at_rest:
            mass = self._mass
            if isinstance(mass, _MassDifference):
                mass.add_force(point, r)
            elif mass is not None:
                dudd = mass * point.udd if dudd is None else moved(dudd, mass, point.udd)
        return r, np.zeros(len(point.lam)), dudd

    def _add_forces(
        self,
        parts: LoadsAndForces,
        point: Point,
        q: Floats,
        v: Floats,
        dq: Floats | None,
        dv: Floats | None,
        f: Floats,
        onto: Onto,
        ahead: Ahead | None = None,
    ) -> None:
        """Add the derivatives of loads and forces to zeros, in the coordinates that ``onto`` sums in."""
        loads, forces = parts
        for part in loads.evaluate(point.t, q, v, dq, dv):
            onto(part, f)
        if point.factor != 1.0:
            f *= point.factor
        for part in forces.evaluate(point.t, q, v, dq, dv, ahead):
            onto(part, f)

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
        self._base, self.m, self._reduced = base, m, reduced

    @cached_property
    def in_all(self) -> VectorOperator:
        """dM/dp, for all coordinates (n_q,)."""
        return VectorOperator(self.m)

    def add_force(self, point: Point, r: Floats) -> None:
        """Add T^T dM/dp a to r, with all accelerations a = T udd and those of supports."""
        if self._reduced:
            self._reduced.onto(point.udd, r)
        else:
            self._base.gather.onto(self.in_all(self._base.accelerations(point)), r)


class _OnHeld:
    """The parts of what acts on held coordinates.

    Args:
        sides: the models beside the value of a parameter.
        holding: what acts in the model in the middle, for one state or several.
        follow: whether coordinates are to follow the parameter.
    """

    def __init__(self, sides: Sequence[Side], holding: Holding, follow: bool) -> None:
        of = [side.equations.holding for side in sides]
        if not all(map(holding.is_like, of)):
            of = [each.unparted for each in of]
        beside = [stack.acting for each in of if (stack := each.stack(holding.n_states))]
        loads = ForceParts(holding.acting.loads, sides, [there.loads for there in beside])
        self.parts = loads, ForceParts(holding.acting.forces, sides, [there.forces for there in beside], all_change=follow)
        self._rows_of = holding.rows_of
        self._mass: VectorOperator | None = None

    def mass(self, m: sparse.csr_array) -> VectorOperator:
        """The rows of a difference of masses that belong to held vectors; always of the same one."""
        if self._mass is None:
            self._mass = VectorOperator(self._rows_of(m))
        return self._mass


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


def may_follow(base: Equations) -> bool:
    """Whether coordinates may follow a parameter that changes nothing but tables of elements, and loads."""
    changes = (block.force_change([block], [0.0]) for block, _ in base.forces.parts)
    return _of_forces(base) and all(isinstance(change, ForceChange) for change in changes)


def _of_forces(base: Equations) -> bool:
    """Whether nothing but forces depends on coordinates: neither fields nor multipliers nor loads."""
    loads = [block for block, _ in base.loads.parts]
    alone = base.n_u == base.n_motion and not base.n_lam
    return alone and not any(block.depends_on_velocity or len(block.k_rows) for block in loads)


def _count(equations: Equations) -> tuple[int, int]:
    return len(equations.forces.parts), len(equations.loads.parts)


@kernel
def _add(weight: float, part: Floats, total: Floats) -> None:
    for i in range(len(total)):
        total[i] += weight * part[i]
