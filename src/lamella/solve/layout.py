"""Where the numbers of a multifrontal factorisation lie: fronts, positions of coordinates, and slots of the matrix's entries."""

from __future__ import annotations

from functools import cached_property
from weakref import WeakKeyDictionary

import numpy as np

from lamella.assembly.pattern import Pattern
from lamella.lane import WIDTH
from lamella.roles import Floats, Indices, Ints
from lamella.solve.fronts import Front, fronts_of, nodes_of


def _up(n: int, multiple: int) -> int:
    return -(-n // multiple) * multiple


def _runs(place: Ints, p: int) -> Ints:
    """Runs of consecutive rows in ``place``, none of which crosses row p: first entry, first row, length; shape (n, 3)."""
    breaks = np.flatnonzero((np.diff(place) != 1) | (place[1:] == p)) + 1
    starts = np.concatenate([[0], breaks])
    return np.column_stack([starts, place[starts], np.diff(np.append(starts, len(place)))])


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
        slots: place of each entry of the pattern in the panels; those above the diagonal as if mirrored.
        owner: the front in whose panel each entry stands.
        above: which entries of the pattern lie above the diagonal in the order of elimination.
        pivots: place of each pivot in the panels, by position.
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
        fronts, self.cost = fronts_of(graph, np.array([len(node) for node in nodes], float))
        self._number(nodes, fronts)
        self._lay_out(nodes, fronts)
        self._place_entries(pattern)

    def _number(self, nodes: list[Ints], fronts: list[Front]) -> None:
        """Positions of the coordinates: front after front, each padded to a multiple of four pivots."""
        self.fronts = np.full((len(fronts) + 1, 11), -1, dtype=np.int64)
        self.position = np.zeros(self.n, dtype=np.int64)
        self._front_of = np.zeros(self.n, dtype=np.int64)
        first, padded = 0, []
        for f, front in enumerate(fronts):
            coords = np.concatenate([nodes[node] for node in front.pivots])
            self.position[coords] = first + np.arange(len(coords))
            self._front_of[coords] = f
            p = _up(len(coords), 4)
            padded.append(first + np.arange(len(coords), p))
            self.fronts[f, :2] = first, p
            first += p
        self.padded = np.concatenate(padded)
        self.coordinate = np.full(first, -1)
        self.coordinate[self.position] = np.arange(self.n)

    def _lay_out(self, nodes: list[Ints], fronts: list[Front]) -> None:
        """Remaining rows of each front, the runs by which they enter the parent, and where panels and updates lie."""
        table = self.fronts
        self._rest = [self._positions(nodes, front.rest) for front in fronts]
        runs: list[Ints] = []
        space = Space()
        a0 = start = n_run = 0
        for f, rows in enumerate(self._rest):
            p, n = table[f, 1], len(rows)
            u_len = _up(n, WIDTH)
            a_len = _up(p + u_len, WIDTH)
            table[f, 2:9] = a_len, a0, n, u_len, space.take(u_len**2), start, n_run
            a0, start = a0 + a_len * p, start + n
            child = table[f, 9]
            while child >= 0:
                space.give(table[child, 6], table[child, 5] ** 2)
                child = table[child, 10]
            if n:
                parent = int(self._front_of[self.coordinate[rows[0]]])
                table[f, 10], table[parent, 9] = table[parent, 9], f
                runs.append(_runs(self._local(parent, rows), table[parent, 1]))
                n_run += len(runs[-1])
        table[-1, 8] = n_run
        self.rows = np.concatenate(self._rest)
        self.runs = np.concatenate([np.zeros((0, 3), np.int64), *runs])
        self.size, self.update_size, self.longest = int(a0), space.size, int(table[:, 2].max())

    def _positions(self, nodes: list[Ints], rest: set[int]) -> Ints:
        """Ascending positions of the coordinates of nodes."""
        return np.sort(np.concatenate([np.zeros(0, np.int64), *(self.position[nodes[node]] for node in rest)]))

    def _local(self, f: int, positions: Ints) -> Ints:
        """Row in front f of each position."""
        first, p = self.fronts[f, :2]
        return np.where(positions < first + p, positions - first, p + np.searchsorted(self._rest[f], positions))

    def _place_entries(self, pattern: Pattern) -> None:
        """Slot of each entry of the pattern, and of the padded pivots, in the panels."""
        p, q = self.position[pattern.rows], self.position[pattern.indices]
        column, row = np.minimum(p, q), np.maximum(p, q)
        self.above = p < q
        self.owner = self._front_of[self.coordinate[column]]
        self.slots = np.zeros(len(p), np.int64)
        by_owner = np.argsort(self.owner, kind="stable")
        bounds = np.searchsorted(self.owner[by_owner], np.arange(len(self.fronts)))
        for f in range(len(self.fronts) - 1):
            mine = by_owner[bounds[f] : bounds[f + 1]]
            first, _, a_len, a0 = self.fronts[f, :4]
            self.slots[mine] = a0 + (column[mine] - first) * a_len + self._local(f, row[mine])
        f = np.repeat(np.arange(len(self.fronts) - 1), self.fronts[:-1, 1])
        first, a_len, a0 = self.fronts[f, 0], self.fronts[f, 2], self.fronts[f, 3]
        self.pivots = a0 + (np.arange(len(f)) - first) * (a_len + 1)
        self.diagonal = np.flatnonzero(p == q)
        self.diagonal_position = p[self.diagonal]

    @cached_property
    def entries(self) -> tuple[Indices, Indices, Ints]:
        """Numbers of the entries, -1 for padded pivots, front after front, their slots, and where those of each front begin."""
        of_padded = np.searchsorted(self.fronts[:-1, 0], self.padded, side="right") - 1
        owner = np.concatenate([self.owner, of_padded])
        order = np.argsort(owner, kind="stable")
        numbers = np.concatenate([np.arange(len(self.owner)), np.full(len(self.padded), -1)])
        slots = np.concatenate([self.slots, self.pivots[self.padded]])
        starts = np.searchsorted(owner[order], np.arange(len(self.fronts)))
        return numbers[order].astype(np.int32), slots[order].astype(np.int32), starts

    def limits(self, k: Floats, tolerance: float) -> Floats:
        """Magnitude that each pivot must exceed, by position: a fraction of its diagonal entry; 0 at padded ones."""
        limits = np.zeros(len(self.coordinate))
        limits[self.diagonal_position] = tolerance * np.abs(k[self.diagonal])
        return limits


_LAYOUTS: WeakKeyDictionary[Pattern, FrontLayout] = WeakKeyDictionary()


def layout_of(pattern: Pattern) -> FrontLayout:
    """The layout for a pattern: solvers of the same equations share one, which takes the time of some ten factorisations."""
    if pattern not in _LAYOUTS:
        _LAYOUTS[pattern] = FrontLayout(pattern)
    return _LAYOUTS[pattern]
