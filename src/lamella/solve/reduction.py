"""The map between a matrix with constraints and the smaller one of the motions that they allow."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from lamella.assembly.pattern import Pattern
from lamella.roles import Floats, Indices, Ints
from lamella.solve.constraint_group import Group
from lamella.solve.null_space_kernels import Core, Motions, Panels, filled_up, reduce_core, reduce_panel

Lookup = Callable[[Ints, Ints], Ints]
"""Number of an entry by its row and column, -1 where there is none."""


def _lookup(rows: Ints, cols: Ints, numbers: Ints, n: int) -> Lookup:
    keys = rows * n + cols
    order = np.argsort(keys)
    keys, numbers = keys[order], numbers[order]

    def find(row: Ints, col: Ints) -> Ints:
        if not len(keys):
            return np.full(np.broadcast_shapes(row.shape, col.shape), -1)
        at = np.minimum(np.searchsorted(keys, row * n + col), len(keys) - 1)
        return np.where(keys[at] == row * n + col, numbers[at], -1)

    return find


class _Reduced:
    """The panels K_fg of all groups, or the transposed K_gf, and what they become.

    Args:
        parts: of each group the coordinates f, and number in K and shape (m, f) of the values, place of the first motion's entry
            for each f in the reduced matrix, and distance to that of the next motion.
    """

    def __init__(self, parts: Sequence[_Part]) -> None:
        self._parts = parts
        near, near_at = joined([part.near for part in parts])
        sizes = [part.source.size for part in parts]
        kept_at = np.cumsum([0, *sizes])
        room = np.zeros(max((part.source.shape[1] for part in parts), default=0))
        self.panels = Panels(near, near_at, np.zeros(kept_at[-1]), kept_at, room)
        self._views = [self.panels.kept[at : at + size] for at, size in zip(kept_at, sizes, strict=False)]

    def reduce(self, k: Floats, groups: Sequence[Group], out: Floats) -> None:
        """Keep the values, and write K_fg N."""
        for part, group, kept in zip(self._parts, groups, self._views, strict=True):
            reduce_panel(k, part.source.reshape(-1), part.slots, part.stride, group.N, kept, self.panels.room, out)


@dataclass(frozen=True)
class _Part:
    """The panel of one group; see :class:`_Reduced`."""

    near: Ints
    source: Indices
    slots: Ints
    stride: int


def joined(parts: Sequence[Ints]) -> tuple[Indices, Ints]:
    """Several lists in one, and where each begins."""
    none = np.zeros(0, np.int64)
    return np.concatenate([none, *parts]).astype(np.int32), np.cumsum([0, *(len(part) for part in parts)])


def _side_by_side(parts: Sequence[Floats]) -> tuple[Floats, Ints]:
    """Room for matrices, one after the other, and where each begins."""
    at = np.cumsum([0, *(part.size for part in parts)])
    return np.zeros(at[-1]), at


class Reduction:
    """N^T K N, with motions in the place of constrained coordinates.

    Args:
        pattern: pattern of K and J.
        groups: the constraints, whose N and P lie side by side from here on.

    Attributes:
        reduced: pattern of N^T K N, all entries.
        sources: number of the entry of K that an entry of N^T K N is, or -1 less its number among ``mixed``.
        mixed: entries of N^T K N in rows or columns of motions of groups.
        right, down, core: entries of K in rows or columns of groups, as the last call of :meth:`reduce` found them.
    """

    def __init__(self, pattern: Pattern, groups: Sequence[Group]) -> None:
        self._groups = groups
        self._N, self._N_at = _side_by_side([group.N for group in groups])
        self._P, self._P_at = _side_by_side([group.P for group in groups])
        for group, N_at, P_at in zip(groups, self._N_at, self._P_at, strict=False):
            group.N = self._N[N_at : N_at + group.N.size].reshape(group.N.shape)
            group.P = self._P[P_at : P_at + group.P.size].reshape(group.P.shape)
        number, owner = self._number(pattern.n)
        rows, cols = pattern.rows, np.asarray(pattern.indices, np.int64)
        source = np.arange(len(rows))
        if pattern.symmetric:
            mirrored = np.flatnonzero(rows != cols)
            rows, cols = np.concatenate([rows, cols[mirrored]]), np.concatenate([cols, rows[mirrored]])
            source = np.concatenate([source, mirrored])
        width = np.ones(pattern.n, np.int64)
        for group in groups:
            width[group.coords] = group.n_motion
        self._moves = width > 0
        self.reduced = _reduced(rows, cols, number, width, self._n)
        place = _lookup(self.reduced.rows, self.reduced.indices, np.arange(len(self.reduced.indices)), self._n)
        free = (owner[rows] < 0) & (owner[cols] < 0)
        mixed = np.ones(len(self.reduced.indices), bool)
        mixed[place(number[rows[free]], number[cols[free]])] = False
        self.sources = -np.cumsum(mixed)
        self.sources[place(number[rows[free]], number[cols[free]])] = source[free]
        slot = _lookup(self.reduced.rows[mixed], self.reduced.indices[mixed], np.arange(np.count_nonzero(mixed)), self._n)
        self.mixed = np.zeros(np.count_nonzero(mixed))
        self._free, self._number_of_free = np.flatnonzero(owner < 0), number[owner < 0]
        entry = _lookup(rows, cols, source, pattern.n)
        right, down = [], []
        for g, group in enumerate(groups):  # heat bends a plate that it need not feel: either panel may have rows of its own
            right.append(self._right_of(group, np.unique(rows[(owner[cols] == g) & (owner[rows] < 0)]), number, entry, slot))
            down.append(self._down_from(group, np.unique(cols[(owner[rows] == g) & (owner[cols] < 0)]), number, entry, slot))
        self._right, self._down = _Reduced(right), _Reduced(down)
        self.right, self.down = self._right.panels, self._down.panels
        core = np.flatnonzero((owner[rows] >= 0) & (owner[cols] >= 0))
        self._set_core(source[core], rows[core], cols[core], number, width, slot)

    def _number(self, n: int) -> tuple[Ints, Ints]:
        """Number of each coordinate in the reduced matrix, for one in a group of its first motion; and its group or -1."""
        number, owner = np.zeros(n, np.int64), np.full(n, -1)
        for g, group in enumerate(self._groups):
            owner[group.coords] = g
        new, seen = 0, set()
        for i in range(n):
            g = int(owner[i])
            if g < 0:
                number[i], new = new, new + 1
            elif g not in seen:
                seen.add(g)
                number[self._groups[g].coords] = new
                new += self._groups[g].n_motion
        self._n, self._numbers = new, number
        return number, owner

    def _right_of(self, group: Group, near: Ints, number: Ints, entry: Lookup, slot: Lookup) -> _Part:
        """K_fg of one group."""
        source = entry(near, group.coords[:, None])
        return _Part(near, _in_lanes(source), slot(number[near], np.full(len(near), number[group.coords[0]])), 1)

    def _down_from(self, group: Group, near: Ints, number: Ints, entry: Lookup, slot: Lookup) -> _Part:
        """K_gf of one group, transposed."""
        source, first = entry(group.coords[:, None], near), np.full(len(near), number[group.coords[0]])
        slots = slot(first, number[near])
        stride = int((slot(first + 1, number[near]) - slots)[0]) if len(near) and group.n_motion > 1 else 0
        return _Part(near, _in_lanes(source), slots, stride)

    def _set_core(self, source: Ints, rows: Ints, cols: Ints, number: Ints, width: Ints, slot: Lookup) -> None:
        """Entries between constrained coordinates, and where the weights of these are."""
        at, size = np.zeros(len(width), np.int64), 0
        for group in self._groups:
            at[group.coords] = size + group.n_motion * np.arange(len(group.coords))
            size += group.n_motion * len(group.coords)
        self._source, self.core = source, Core(rows, cols, np.zeros(len(source)))
        moving = np.flatnonzero((width[rows] > 0) & (width[cols] > 0))
        rows, cols = rows[moving], cols[moving]
        stride = np.diff(self.reduced.indptr)[number[rows]]
        places = slot(number[rows], number[cols])
        self._mixed = np.column_stack([moving, places, stride, at[rows], width[rows], at[cols], width[cols]])

    def motions(self, position: Ints) -> Motions:
        """What becomes of coordinates, with the position of each row of the reduced matrix in a factorisation."""
        first = [self._numbers[group.coords[0]] for group in self._groups]
        place = [position[at : at + group.n_motion] for at, group in zip(first, self._groups, strict=True)]
        coords, rows = joined([group.coords for group in self._groups]), joined([group.rows for group in self._groups])
        free = self._free.astype(np.int32), position[self._number_of_free].astype(np.int32)
        return Motions(*coords, *rows, self._N, self._N_at, self._P, self._P_at, *joined(place), *free)

    def coordinate_of(self, motion: int) -> int:
        """A coordinate that moves in the motion of this number: the first of a group, or the one that is the motion itself."""
        last = np.max(self._numbers[self._moves & (self._numbers <= motion)])
        return int(np.flatnonzero(self._moves & (self._numbers == last))[0])

    def reduce(self, k: Floats) -> None:
        """Set ``mixed``; entries of K with groups are kept."""
        out = self.mixed
        out[:] = 0.0
        self._right.reduce(k, self._groups, out)
        self._down.reduce(k, self._groups, out)
        if self._groups:
            np.take(k, self._source, out=self.core.values)
            reduce_core(self.core.values, self._mixed, self._N, out)


def _in_lanes(source: Ints) -> Indices:
    """A panel (g, f) with the f filled up to whole lanes, where there is nothing."""
    filler = filled_up(source.shape[1]) - source.shape[1]
    return np.pad(source, ((0, 0), (0, filler)), constant_values=-1).astype(np.int32)


def _reduced(rows: Ints, cols: Ints, number: Ints, width: Ints, n: int) -> Pattern:
    """Pattern of N^T K N: each entry of K gives a block, motions of its row by motions of its column."""
    wide, count = width[cols], width[rows] * width[cols]
    entry = np.repeat(np.arange(len(rows)), count)
    k = np.arange(len(entry)) - np.repeat(np.cumsum(count) - count, count)
    places = np.unique((number[rows[entry]] + k // wide[entry]) * n + number[cols[entry]] + k % wide[entry])
    none = np.zeros(0, np.int64)
    return Pattern(n, np.searchsorted(places, np.arange(n + 1) * n), places % n, False, 0, np.zeros(1, np.int64), none)
