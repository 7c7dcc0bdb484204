"""Where the numbers of a multifrontal factorisation lie: fronts, positions of coordinates, and slots of the matrix's entries."""

from __future__ import annotations

from functools import cached_property
from weakref import WeakKeyDictionary

import numpy as np

from lamella.assembly.pattern import Pattern
from lamella.lane import WIDTH
from lamella.roles import Bools, Floats, Indices, Ints
from lamella.solve.fronts import Fronts, fronts_of, nodes_of
from lamella.solve.lists import Lists
from lamella.solve.symbolic_kernels import count_entries, find_runs, list_entries


def _up(n: Ints, multiple: int) -> Ints:
    return -(-n // multiple) * multiple


class Space:
    """Places in a workspace, used again after they were given back (first fit)."""

    def __init__(self) -> None:
        self.size = 0
        self._free: list[tuple[int, int]] = []

    def take(self, n: int) -> int:
        """Start of n entries."""
        for i, (start, length) in enumerate(self._free):
            if length >= n:
                self._free[i] = (start + n, length - n)
                return start
        self.size += n
        return self.size - n

    def give(self, start: int, n: int) -> None:
        """Give back n entries."""
        merged: list[tuple[int, int]] = []
        for at, length in sorted([*self._free, (start, n)]):
            if merged and sum(merged[-1]) == at:
                merged[-1] = (merged[-1][0], merged[-1][1] + length)
            elif length:
                merged.append((at, length))
        self._free = merged


class FrontLayout:
    """The symbolic part of a multifrontal factorisation.

    Args:
        pattern: pattern of the matrix, whose multipliers are ignored; the pivots are those of the symmetric pattern of A + A^T.

    Attributes:
        fronts: see :func:`lamella.solve.front_kernels.factorise`.
        runs: where the remaining rows of a child stand in its parent, in the order of ``fronts``.
        rows: position of each remaining row, front after front.
        position: position of each coordinate in the order of elimination, shape (n,).
        coordinate: coordinate at each position, -1 at padded pivots.
        padded: positions of the padded pivots.
        entries: numbers of the entries, -1 for padded pivots, front after front, their places in the panels, and where those of
            each front begin.
        diagonal: entries of the pattern on the diagonal.
        diagonal_position: their positions.
        size: entries of all panels, which hold the lower triangle of the factor.
        update_size: entries of the workspace of updates.
        longest: longest column of a panel.
        cost: multiplications, each with an addition, of a symmetric factorisation.
    """

    def __init__(self, pattern: Pattern) -> None:
        self.n = pattern.n
        nodes, graph = nodes_of(pattern)
        fronts = fronts_of(graph, np.diff(nodes.starts).astype(float))
        self.cost = fronts.cost
        self._number(nodes, fronts)
        self._lay_out(nodes, fronts)
        self._place_entries(pattern)

    def _number(self, nodes: Lists, fronts: Fronts) -> None:
        """Positions of the coordinates: front after front, each padded to a multiple of four pivots."""
        coords, starts = nodes.joined(fronts.pivots)
        count = np.diff(starts)
        self.fronts = np.full((len(count) + 1, 11), -1, dtype=np.int64)
        self._padded_count = _up(count, 4)
        first = np.cumsum(self._padded_count) - self._padded_count
        self._front_at = np.repeat(np.arange(len(count)), self._padded_count)
        self.position = np.empty(self.n, dtype=np.int64)
        self.position[coords] = np.arange(self.n) + np.repeat(first - starts[:-1], count)
        self.fronts[:-1, 0], self.fronts[:-1, 1] = first, self._padded_count
        self.coordinate = np.full(self._padded_count.sum(), -1)
        self.coordinate[self.position] = np.arange(self.n)
        self.padded = np.flatnonzero(self.coordinate < 0)

    def _lay_out(self, nodes: Lists, fronts: Fronts) -> None:
        """Remaining rows of each front, the runs by which they enter the parent, and where panels and updates lie."""
        table, n_front = self.fronts, len(self.fronts) - 1
        coords, starts = nodes.joined(fronts.rest)
        n = np.diff(starts)
        owner, self.rows = np.repeat(np.arange(n_front), n), self.position[coords]
        self.rows = np.sort(owner * len(self.coordinate) + self.rows) % len(self.coordinate)
        p, u_len = self._padded_count, _up(n, WIDTH)
        a_len = _up(p + u_len, WIDTH)
        table[:-1, 2], table[:-1, 3], table[:-1, 4], table[:-1, 5] = a_len, np.cumsum(a_len * p) - a_len * p, n, u_len
        table[:-1, 7] = starts[:-1]
        parents = np.full(n_front, -1)
        parents[n > 0] = self._front_at[self.rows[starts[:-1][n > 0]]]
        runs, firsts = np.empty((len(self.rows), 3), np.int64), np.empty(n_front + 1, np.int64)
        self.runs = runs[: find_runs(starts, self.rows, table, parents, runs, firsts)].copy()
        table[:, 8] = firsts
        self.size, self.longest = int((a_len * p).sum()), int(a_len.max())
        self.update_size = self._share_space(parents.tolist(), (u_len**2).tolist())

    def _share_space(self, parents: list[int], sizes: list[int]) -> int:
        """List the children of each front and give each update its place in the workspace; the size of that."""
        space = Space()
        children: list[list[int]] = [[] for _ in parents]
        places = [0] * len(parents)
        for f, (parent, size) in enumerate(zip(parents, sizes, strict=True)):
            places[f] = space.take(size)
            for child in children[f]:
                space.give(places[child], sizes[child])
            if parent >= 0:
                children[parent].insert(0, f)
        for f, own in enumerate(children):
            self.fronts[f, 9] = own[0] if own else -1
            for child, following in zip(own, [*own[1:], -1], strict=False):
                self.fronts[child, 10] = following
        self.fronts[:-1, 6] = places
        return space.size

    def _place_entries(self, pattern: Pattern) -> None:
        """The entries of each front, and where they stand in the panels."""
        starts, cols = (np.ascontiguousarray(part, np.int64) for part in (pattern.indptr, pattern.indices))
        walked = starts, cols, self.position, self._front_at, self.coordinate
        begins, n = np.zeros(len(self.fronts), np.int64), self.n
        diagonal, position = np.empty(n, np.int64), np.empty(n, np.int64)
        m = count_entries(*walked, begins, diagonal, position)
        self.diagonal, self.diagonal_position = diagonal[:m], position[:m]
        numbers, slots = np.empty(begins[-1], np.int32), np.empty(begins[-1], np.int32)
        work = begins[:-1].copy(), np.empty_like(self.coordinate), np.empty(begins[-1], np.int64)
        list_entries(*walked, begins, self.fronts, self.rows, *work, numbers, slots)
        self.entries: tuple[Indices, Indices, Ints] = numbers, slots, begins

    @cached_property
    def pivots(self) -> Ints:
        """Place of each pivot in the panels, by position."""
        first, a_len, a0 = (self.fronts[self._front_at, i] for i in (0, 2, 3))
        return a0 + (np.arange(len(first)) - first) * (a_len + 1)

    def by_entry(self, pattern: Pattern) -> tuple[Ints, Ints, Bools]:
        """Of each entry of the pattern the front in whose panel it stands, its place there as if mirrored where it lies above the
        diagonal in the order of elimination, and whether it does.
        """
        numbers, slots, begins = self.entries
        own, front = numbers >= 0, np.repeat(np.arange(len(begins) - 1), np.diff(begins))
        owner, place = np.empty(len(pattern.indices), np.int64), np.empty(len(pattern.indices), np.int64)
        owner[numbers[own]], place[numbers[own]] = front[own], slots[own]
        return owner, place, self.position[pattern.rows] < self.position[pattern.indices]

    def magnitude(self, k: Floats) -> Floats:
        """|K_ii| by position, 0 at padded ones."""
        magnitude = np.zeros(len(self.coordinate))
        magnitude[self.diagonal_position] = np.abs(k[self.diagonal])
        return magnitude


_LAYOUTS: WeakKeyDictionary[Pattern, FrontLayout] = WeakKeyDictionary()


def layout_of(pattern: Pattern) -> FrontLayout:
    """The layout for a pattern: solvers of the same equations share one, which takes the time of some ten factorisations."""
    if pattern not in _LAYOUTS:
        _LAYOUTS[pattern] = FrontLayout(pattern)
    return _LAYOUTS[pattern]
