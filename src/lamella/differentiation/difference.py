"""Differences of residuals between the models beside a parameter, of those parts alone that differ."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import compress

import numpy as np

from lamella._jit import kernel, njit
from lamella.assembly.equations import Equations
from lamella.assembly.forces import ForceSum
from lamella.assembly.point import Point
from lamella.differentiation.alike import alike
from lamella.roles import ConstraintBlock, Floats, ForceBlock


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
                ud = _moved(point.ud, side.distance, dud) if equations.depends_on_velocity else point.ud
                there = Point(point.t, point.u, ud, _moved(point.udd, side.distance, dudd), point.lam, point.factor)
            of_forces, of_constraints = equations.residual(there)
            _add(side.weight, of_forces, r)
            if len(phi):
                phi += side.weight * of_constraints
        return r, phi


class PartDifference:
    """The same from those blocks alone that the parameter changes or that depend on velocities: what is equal in all models
    cancels, and equal masses leave M dudd.

    Args:
        base: the equations at the value of the parameter.
        sides: the models beside it, with the same constraints and the same map from unknowns to coordinates.
    """

    def __init__(self, base: Equations, sides: Sequence[Side]) -> None:
        self._base, self._sides = base, sides
        equations = [side.equations for side in sides]
        self._same_mass = all(alike(there.model.inertias, base.model.inertias) or there.mass.as_like for there in equations)
        self._forces = _Parts(base.forces, sides, [there.forces for there in equations])
        self._loads = _Parts(base.loads, sides, [there.loads for there in equations])

    def __call__(self, point: Point, dud: Floats | None, dudd: Floats | None) -> tuple[Floats, Floats]:
        """The derivatives, as :class:`WholeDifference` gives them."""
        base, r = self._base, np.zeros_like(point.u)
        q, v, dv = base.coordinates(point), base.force_velocities(point), None
        if dud is not None and base.depends_on_velocity:
            dv = base.expand(dud)
        self._forces.add(1.0, point.t, q, v, dv, r)
        self._loads.add(point.factor, point.t, q, v, dv, r)
        if dudd is not None and self._same_mass:
            _add(1.0, base.inertia_force(dudd), r)
        elif not point.at_rest and not self._same_mass:
            for side in self._sides:
                udd = point.udd if dudd is None else _moved(point.udd, side.distance, dudd)
                _add(side.weight, side.equations.inertia_force(udd), r)
        return r, np.zeros_like(point.lam)


class _Parts:
    """The blocks of a sum that differ between models, or depend on velocities.

    Args:
        base: the sum at the value of the parameter.
        sides, sums: the models beside it, with their sums.
    """

    def __init__(self, base: ForceSum, sides: Sequence[Side], sums: Sequence[ForceSum]) -> None:
        blocks = [*zip(*([block for block, _ in each.parts] for each in sums), strict=True)]
        changed = [remembers(first) or not all(alike(first, other) for other in others) for first, *others in blocks]
        linear = [not one and block.linear_in_velocity for one, (block, *_) in zip(changed, blocks, strict=True)]
        others = [one or block.depends_on_velocity for one, (block, *_) in zip(changed, blocks, strict=True)]
        moving = [one and not other for one, other in zip(others, linear, strict=True)]
        self._base, self._linear = base, [*compress(base.parts, linear)]
        self._seeing = any(block.depends_on_velocity for block, _ in base.parts)
        self._changed, self._moving = _chosen(sides, sums, changed), _chosen(sides, sums, moving)

    def add(self, factor: float, t: float, q: Floats, v: Floats, dv: Floats | None, r: Floats) -> None:
        """Add their weighed forces to r, with velocities that follow the parameter if ``dv`` is given."""
        if dv is not None and self._linear:
            self._base.buffer[:] = 0.0  # of the other blocks
            for block, part in self._linear:
                block.damping_force(t, q, dv, part)
            self._base.written()
            _add(factor, self._base.reduced(), r)
        for side, whole, parts in self._changed if dv is None else self._moving:
            if not parts:
                return
            there = v if dv is None or not self._seeing else _moved(v, side.distance, dv)
            whole.buffer[:] = 0.0
            for block, part in parts:
                block.force(t, q, there, part)
            whole.written()
            _add(side.weight * factor, whole.reduced(), r)


def _chosen(
    sides: Sequence[Side], sums: Sequence[ForceSum], chosen: Sequence[bool]
) -> list[tuple[Side, ForceSum, list[tuple[ForceBlock, Floats]]]]:
    """The blocks that are chosen, with their parts of the buffer, of each side."""
    return [(side, each, [*compress(each.parts, chosen)]) for side, each in zip(sides, sums, strict=True)]


def difference_of(base: Equations, sides: Sequence[Side]) -> WholeDifference | PartDifference:
    """The difference of residuals between models."""
    constraints = [side.equations.model.constraints for side in sides]
    same = all(side.equations.same_coordinates(base) and _count(side.equations) == _count(base) for side in sides)
    if same and not any(map(remembers, constraints[0])) and all(alike(constraints[0], other) for other in constraints[1:]):
        return PartDifference(base, sides)
    return WholeDifference(sides)


def _count(equations: Equations) -> tuple[int, int]:
    return len(equations.forces.parts), len(equations.loads.parts)


def remembers(block: ForceBlock | ConstraintBlock) -> bool:
    """Whether a block has a discrete state."""
    return type(block).settle not in (ForceBlock.settle, ConstraintBlock.settle)


@njit
def _moved(x: Floats, distance: float, along: Floats) -> Floats:
    """x + distance along."""
    moved = np.empty_like(x)
    for i in range(len(x)):
        moved[i] = x[i] + distance * along[i]
    return moved


@kernel
def _add(weight: float, part: Floats, total: Floats) -> None:
    for i in range(len(total)):
        total[i] += weight * part[i]
