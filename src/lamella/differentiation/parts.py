"""Forces of the models beside a parameter, of those blocks alone that differ."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import chain, compress, islice

import numpy as np
from scipy import sparse

from lamella._jit import njit
from lamella.assembly.equations import Equations
from lamella.assembly.forces import ForceSum
from lamella.assembly.product import Ahead
from lamella.differentiation.alike import alike
from lamella.roles import Floats, Force, ForceBlock, ForceChange, remembers


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


class ForceParts:
    """The blocks of a sum that differ between models, or depend on velocities.

    Args:
        of_base: the sum at the value of the parameter.
        sides, sums: the models beside it, with their sums.
        all_change: whether blocks that are equal in all models count as changed as well.

    Attributes:
        changes: of the blocks that have one.
        complete: whether all have.
        differ: whether any block is another one in the models.
    """

    def __init__(self, of_base: ForceSum, sides: Sequence[Side], sums: Sequence[ForceSum], all_change: bool = False) -> None:
        blocks = [*zip(*([block for block, _ in each.parts] for each in sums), strict=True)]
        changed = [
            all_change or remembers(first) or not all(alike(first, other) for other in others) for first, *others in blocks
        ]
        self.differ = any(changed)
        of_values = [block for block, _ in of_base.parts]
        wholes = [
            _whole(value, beside, sides) if one else None for one, value, beside in zip(changed, of_values, blocks, strict=True)
        ]
        changed = [one and whole is None for one, whole in zip(changed, wholes, strict=True)]
        linear = [not one and block.linear_in_velocity for one, (block, *_) in zip(changed, blocks, strict=True)]
        others = [one or block.depends_on_velocity for one, (block, *_) in zip(changed, blocks, strict=True)]
        moving = [one and not other for one, other in zip(others, linear, strict=True)]
        of_all = of_base.onto_what
        self._wholes = ForceSum([whole for whole in wholes if whole], *of_all, like=of_base)
        self._of_wholes = [block for block, whole in zip(of_values, wholes, strict=True) if whole]
        self._linear = ForceSum([block for block, _ in compress(of_base.parts, linear)], *of_all)
        self._seeing = any(block.depends_on_velocity for block, _ in of_base.parts)
        self.changes = [whole for whole in wholes if isinstance(whole, ForceChange)]
        self.complete = len(self.changes) == len(blocks)
        self._changed, self._moving = (_Weighed(sides, sums, chosen, *of_all) for chosen in (changed, moving))
        self._empty = not (any(others) or self._wholes.parts)

    def evaluate(
        self, t: float, q: Floats, v: Floats, dq: Floats | None, dv: Floats | None, ahead: Ahead | None = None
    ) -> list[ForceSum]:
        """Sums whose buffers hold the derivative of their forces together, with coordinates and velocities that follow the
        parameter if these are given; coordinates only where all blocks that depend on them have a change.
        """
        filled: list[ForceSum] = []
        if self._empty:
            return filled
        if self._wholes.parts:
            ahead = ahead or Ahead(None, None)
            for (change, part), block in zip(self._wholes.parts, self._of_wholes, strict=True):
                if dq is not None and dv is not None and isinstance(change, ForceChange):
                    ahead.along(change, block, t, q, v, dq, dv, part)
                else:
                    change.force(t, q, v, part)
            filled.append(self._wholes)
        if dv is None or dq is not None:  # those that depend on velocities have been asked already
            return filled + self._changed.evaluate(t, q, v, None)
        for block, part in self._linear.parts:
            block.damping_force(t, q, dv, part)
        return [*filled, self._linear, *self._moving.evaluate(t, q, v, dv if self._seeing else None)]


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
        self, sides: Sequence[Side], sums: Sequence[ForceSum], chosen: Sequence[bool], n_q: int, T: sparse.csr_array | None
    ) -> None:
        blocks = [[block for block, _ in compress(each.parts, chosen)] for each in sums]
        weights = [side.weight for side, own in zip(sides, blocks, strict=True) for _ in own]
        self._sum = ForceSum([*chain.from_iterable(blocks)], n_q, T, weights=weights)
        parts = iter(self._sum.parts)
        self._of_sides = [(side.distance, [*islice(parts, len(own))]) for side, own in zip(sides, blocks, strict=True)]

    def evaluate(self, t: float, q: Floats, v: Floats, dv: Floats | None) -> list[ForceSum]:
        """The sum whose buffer holds the forces, if there are any; velocities of each side are along ``dv`` if it is given."""
        for distance, parts in self._of_sides:
            there = v if dv is None else moved(v, distance, dv)
            for block, part in parts:
                block.force(t, q, there, part)
        return [self._sum] if self._sum.parts else []


@njit
def moved(x: Floats, distance: float, along: Floats) -> Floats:
    """x + distance along."""
    there = np.empty_like(x)
    for i in range(len(x)):
        there[i] = x[i] + distance * along[i]
    return there
