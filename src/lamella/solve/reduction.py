"""The map between a matrix with constraints and the smaller one of the motions that they allow."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np

from lamella.assembly.pattern import Pattern
from lamella.roles import Floats, Ints
from lamella.solve.constraint_group import Group
from lamella.solve.null_space_kernels import couple, reduce_core, reduce_panel, subtract

Lookup = Callable[[Ints, Ints], Ints]
"""Number of an entry by its row and column, -1 where there is none."""


def _lookup(rows: Ints, cols: Ints, numbers: Ints, n: int) -> Lookup:
    keys = rows * n + cols
    order = np.argsort(keys)
    keys, numbers = keys[order], numbers[order]

    def find(row: Ints, col: Ints) -> Ints:
        at = np.minimum(np.searchsorted(keys, row * n + col), len(keys) - 1)
        return np.where(keys[at] == row * n + col, numbers[at], -1)

    return find


class _Panel:
    """What stands in K between one group g and the coordinates f that no constraint touches: K_fg, or the transposed K_gf.

    Args:
        source: number of each value in K, shape (f, m).
        near: the coordinates f.
        slots: place of the first motion's entry for each f in the reduced matrix.
        stride: distance to that of the next motion.
    """

    def __init__(self, source: Ints, near: Ints, slots: Ints, stride: int) -> None:
        self.source, self.near, self.slots, self.stride = source.astype(np.int32), near, slots, stride
        self.kept = np.zeros(source.shape)


class Reduction:
    """N^T K N, with motions in the place of constrained coordinates.

    Args:
        pattern: pattern of K and J.
        groups: the constraints.

    Attributes:
        reduced: pattern of N^T K N, all entries.
    """

    def __init__(self, pattern: Pattern, groups: Sequence[Group]) -> None:
        self._groups = groups
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
        self.reduced = _reduced(rows, cols, number, width, self._n)
        slot = _lookup(self.reduced.rows, self.reduced.indices, np.arange(len(self.reduced.indices)), self._n)
        free = (owner[rows] < 0) & (owner[cols] < 0)
        self._plain = source[free].astype(np.int32), slot(number[rows[free]], number[cols[free]]).astype(np.int32)
        self._free, self._number_of_free = np.flatnonzero(owner < 0), number[owner < 0]
        entry = _lookup(rows, cols, source, pattern.n)
        self._right: list[_Panel] = []
        self._down: list[_Panel] = []
        for g, group in enumerate(groups):
            near = np.union1d(cols[owner[rows] == g], rows[owner[cols] == g])
            self._add_panels(group, near[owner[near] < 0], number, entry, slot)
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

    def _add_panels(self, group: Group, near: Ints, number: Ints, entry: Lookup, slot: Lookup) -> None:
        shape = (len(near), len(group.coords))
        f, g = (part.reshape(-1) for part in np.broadcast_arrays(near[:, None], group.coords))
        first = np.full(len(near), number[group.coords[0]])
        down = slot(first, number[near])
        stride = int((slot(first + 1, number[near]) - down)[0]) if len(near) and group.n_motion > 1 else 0
        self._right.append(_Panel(entry(f, g).reshape(shape), near, slot(number[near], first), 1))
        self._down.append(_Panel(entry(g, f).reshape(shape), near, down, stride))

    def _set_core(self, source: Ints, rows: Ints, cols: Ints, number: Ints, width: Ints, slot: Lookup) -> None:
        """Entries between constrained coordinates, and where the weights of these are."""
        at, size = np.zeros(len(width), np.int64), 0
        for group in self._groups:
            at[group.coords] = size + group.n_motion * np.arange(len(group.coords))
            size += group.n_motion * len(group.coords)
        self._weights = np.zeros(size)
        self._core, self._core_values = (source, rows, cols), np.zeros(len(source))
        moving = np.flatnonzero((width[rows] > 0) & (width[cols] > 0))
        rows, cols = rows[moving], cols[moving]
        stride = np.diff(self.reduced.indptr)[number[rows]]
        places = slot(number[rows], number[cols])
        self._mixed = np.column_stack([moving, places, stride, at[rows], width[rows], at[cols], width[cols]])

    def coordinate_of(self, motion: int) -> int:
        """A coordinate that moves in the motion of this number."""
        return int(np.flatnonzero(self._numbers <= motion)[-1])

    def reduce(self, k: Floats, out: Floats) -> None:
        """Values of N^T K N in the order of the pattern ``reduced``; what :meth:`forces_on_groups` needs of K is kept."""
        couple(k, *self._plain, out)
        for group, right, down in zip(self._groups, self._right, self._down, strict=True):
            reduce_panel(k, right.source, right.slots, right.stride, group.N, right.kept, out)
            reduce_panel(k, down.source, down.slots, down.stride, group.N, down.kept, out)
        if self._groups:
            np.take(k, self._core[0], out=self._core_values)
            np.concatenate([group.N.reshape(-1) for group in self._groups], out=self._weights)
            reduce_core(self._core_values, self._mixed, self._weights, out)

    def gathered(self, r: Floats) -> Floats:
        """N^T r."""
        out = np.zeros(self._n)
        out[self._number_of_free] = r[self._free]
        for group in self._groups:
            first = self._numbers[group.coords[0]]
            out[first : first + group.n_motion] = r[group.coords] @ group.N
        return out

    def spread(self, w: Floats, x: Floats) -> None:
        """x += N w."""
        x[self._free] += w[self._number_of_free]
        for group in self._groups:
            first = self._numbers[group.coords[0]]
            x[group.coords] += group.N @ w[first : first + group.n_motion]

    def without_constrained(self, r: Floats, x: Floats) -> Floats:
        """r - K x for an x that is zero but in groups."""
        out = r.copy()
        for group, right in zip(self._groups, self._right, strict=True):
            out[right.near] -= right.kept @ x[group.coords]
        self._subtract_core(x, out)
        return out

    def forces_on_groups(self, r: Floats, x: Floats) -> Iterator[tuple[Group, Floats]]:
        """(r - K x)_g of each group."""
        if not self._groups:
            return
        out = r.copy()
        self._subtract_core(x, out)
        for group, down in zip(self._groups, self._down, strict=True):
            yield group, out[group.coords] - x[down.near] @ down.kept

    def _subtract_core(self, x: Floats, out: Floats) -> None:
        _, rows, cols = self._core
        subtract(rows, cols, self._core_values, x, out)


def _reduced(rows: Ints, cols: Ints, number: Ints, width: Ints, n: int) -> Pattern:
    """Pattern of N^T K N: each entry of K gives a block, motions of its row by motions of its column."""
    wide, count = width[cols], width[rows] * width[cols]
    entry = np.repeat(np.arange(len(rows)), count)
    k = np.arange(len(entry)) - np.repeat(np.cumsum(count) - count, count)
    places = np.unique((number[rows[entry]] + k // wide[entry]) * n + number[cols[entry]] + k % wide[entry])
    none = np.zeros(0, np.int64)
    return Pattern(n, np.searchsorted(places, np.arange(n + 1) * n), places % n, False, 0, np.zeros(1, np.int64), none)
