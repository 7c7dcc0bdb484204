"""Derivatives of forces and potentials by a parameter, from the elements of models beside its value, at the price of one or
two.
"""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from typing import TypeVar

import numpy as np

from lamella.element.block import Range
from lamella.element.plate48.layout import KernelArguments, Plate48Block, sections_of, seen
from lamella.element.plate48.matrix_free import ShellTangent
from lamella.element.plate48.reference_change import energy_change, reference_change, work_size
from lamella.element.plate48.surface_kernels import N_SECTION, N_STIFFNESS
from lamella.element.plate48.tangent_product import Time
from lamella.lane import WIDTH, aligned
from lamella.roles import Floats, Force, ForceChange, TangentOperator
from lamella.threads import Workspace

Block = TypeVar("Block", bound=Plate48Block)
NOTHING = np.zeros(0)
Place = tuple[Floats, Floats, Floats, Floats, bool]
"""Coordinates and velocities, how they follow the parameter, and whether they do."""
POINT = 60e-9
"""Seconds that a change of the reference takes for a Gauss point of an element."""


def force_change(
    block: Block, beside: Sequence[Block], weights: Sequence[float], time: Time, elastic: bool
) -> ForceChange | None:
    """What writes sum w_i f_i, the derivative of a force by a parameter.

    Forces that differ by the stiffness of their sections are linear in it: f(sum w_i C_i), while coordinates do not follow. Else
    scale and reference change too, and the derivatives of these tables give that of the force.

    Args:
        block: the block at the value of the parameter.
        beside: blocks of the same kind at the values beside it.
        weights: of these, whose sum is 0.
        time, elastic: retardation time [s] of the viscous force if there is one, and whether there is the elastic force.

    Returns:
        None where the blocks have other elements or other Gauss points.
    """
    if not all(comparable(block, other) for other in beside):
        return None
    for own, *others in zip(*(each.arguments for each in (block, *beside)), strict=True):
        if not all(np.array_equal(own[1], other[1]) and _same_reference(own, other) for other in others):
            return FollowedChange(block, beside, weights, time, elastic)
    found = copy(block)
    found.arguments = []
    for (index, scale, sections, *others), *its in zip(*(each.arguments for each in (block, *beside)), strict=True):
        change = _with_stiffness(sections, weighed(weights, [other[2] for other in its]))
        found.arguments.append((index, scale, change, *others))
    return StiffnessChange(found, block, beside, weights, time, elastic)


class ReferenceChange(Force):
    """The derivative of the elements' force by a parameter that changes their scale, reference and stiffness.

    Args:
        block, beside, weights, time, elastic: as for :func:`force_change`.
    """

    def __init__(
        self, block: Plate48Block, beside: Sequence[Plate48Block], weights: Sequence[float], time: Time, elastic: bool
    ) -> None:
        self.f_coords, self.f_scale = block.f_coords, block.f_scale
        self._over_blocks, self._how = block.over_blocks, (time, elastic)
        self._scaled = False
        self._parts: list[tuple[KernelArguments, Floats, Floats, Floats]] = []
        for own, *others in zip(*(each.arguments for each in (block, *beside)), strict=True):
            scale = weighed(weights, [other[1] for other in others])
            self._scaled |= any(not np.array_equal(own[1], other[1]) for other in others)
            self._parts.append((own, scale, scale / own[1], weighed(weights, [other[2] for other in others])))
        self.changes = [change for *_, change in self._parts]
        """Of the sections, for each part of them."""
        self._work = Workspace(max(work_size(own[4]) for own in block.arguments) * WIDTH)
        self._more = aligned(self.f_coords.size if len(self._parts) > 1 else 0)

    def force(self, t: float, q: Floats, v: Floats, f: Floats) -> None:
        """Write it to the force buffer ``f`` (n_f,)."""
        self._write((q, v, q, v, False), [NOTHING] * len(self._parts), f)

    def _write(self, at: Place, kept: Sequence[Floats], f: Floats) -> None:
        for k, (part, points) in enumerate(zip(self._parts, kept, strict=True)):
            self._write_part(*part, at, points, self._more if k else f)
            if k:
                f += self._more

    def _write_part(
        self, arguments: KernelArguments, scale: Floats, share: Floats, change: Floats, at: Place, points: Floats, f: Floats
    ) -> None:
        scaled = self._scaled or not at[4]

        def call(blocks: Range) -> None:
            tables = blocks.of(scale), blocks.of(share), sections_of(change, arguments[4], blocks)
            reference_change(
                *at, *self._how, scaled, *tables, *seen(arguments, blocks), self._work.array, blocks.of(points), blocks.of(f)
            )

        self._over_blocks(POINT * arguments[4] ** 2, call)


class FollowedChange(ReferenceChange, ForceChange):
    """The same where coordinates and velocities may follow the parameter.

    Args:
        block, beside, weights, time, elastic: as for :func:`force_change`.
    """

    def __init__(
        self, block: Plate48Block, beside: Sequence[Plate48Block], weights: Sequence[float], time: Time, elastic: bool
    ) -> None:
        super().__init__(block, beside, weights, time, elastic)
        self._elastic, self._n_element = elastic, block.n_element
        self._energies, self._changes = aligned(block.n_block * WIDTH), aligned(block.n_block * WIDTH)

    def along(
        self, t: float, q: Floats, v: Floats, dq: Floats, dv: Floats, f: Floats, looking: TangentOperator | None = None
    ) -> bool:
        """As the role says."""
        looks = isinstance(looking, ShellTangent)
        self._write((q, v, dq, dv, True), looking.points if looks else [NOTHING] * len(self._parts), f)
        return looks

    def energy(self, t: float, q: Floats, dq: Floats) -> tuple[float, float]:
        """As the role says: of the strain energy, of which a viscous force has none."""
        total, of_change = 0.0, 0.0
        for arguments, scale, _, change in self._parts if self._elastic else ():
            out = self._energies, self._changes
            energy_change(q, dq, self._scaled, scale, change, *arguments, self._work.array, *out)
            total += float(self._energies[: self._n_element].sum())
            of_change += float(self._changes[: self._n_element].sum())
        return total, of_change


class StiffnessChange(FollowedChange):
    """The same by a parameter that changes the stiffness of sections alone.

    Args:
        alone: the elements with the derivative of the stiffness in its place, whose force it is while coordinates do not follow.
        block, beside, weights, time, elastic: as for :func:`force_change`.
    """

    def __init__(
        self, alone: Block, block: Block, beside: Sequence[Block], weights: Sequence[float], time: Time, elastic: bool
    ) -> None:
        super().__init__(block, beside, weights, time, elastic)
        self._alone = alone

    def force(self, t: float, q: Floats, v: Floats, f: Floats) -> None:
        """Write it to the force buffer ``f`` (n_f,)."""
        self._alone.force(t, q, v, f)


def comparable(block: Plate48Block, other: Plate48Block) -> bool:
    """Whether the elements have the same coordinates, and their sections the same points, apart or together."""
    if type(other) is not type(block) or len(other.arguments) != len(block.arguments):
        return False
    return all(
        np.array_equal(own[0], its[0]) and len(own[2]) == len(its[2]) and own[4:] == its[4:]
        for own, its in zip(block.arguments, other.arguments, strict=True)
    )


def _constants(sections: Floats) -> Floats:
    """Those of the reference, shape (n_point, 6, WIDTH)."""
    return sections.reshape(-1, N_SECTION, WIDTH)[:, N_STIFFNESS:]


def _same_reference(own: KernelArguments, other: KernelArguments) -> bool:
    return np.array_equal(_constants(own[2]), _constants(other[2]))


def _with_stiffness(sections: Floats, stiffness: Floats) -> Floats:
    """The constants of a reference with the stiffness of other sections."""
    total = aligned(sections.size)
    total[:] = stiffness
    _constants(total)[:] = _constants(sections)
    return total


def weighed(weights: Sequence[float], tables: Sequence[Floats]) -> Floats:
    """The weighed sum of tables."""
    total = aligned(tables[0].size)
    for weight, table in zip(weights, tables, strict=True):
        total += weight * table
    return total
