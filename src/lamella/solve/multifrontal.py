"""Multifrontal factorisation K = L S L^T of symmetric matrices on the node blocks of a mesh."""

from __future__ import annotations

import numpy as np

from lamella.assembly.pattern import Pattern
from lamella.lane import WIDTH
from lamella.roles import Floats, Ints
from lamella.solve import front_kernels, front_solution
from lamella.solve.base import PIVOT_TOLERANCE, SymmetricFactor
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


class Multifrontal(SymmetricFactor):
    """L S L^T with S = diag(+-1) and pivots on the diagonal in a fixed order, in dense fronts.

    For a positive definite matrix this is Cholesky's factorisation. An indefinite one is factorised without exchange of rows:
    its accuracy must be checked, and the signs then give the number of negative eigenvalues.

    Args:
        pattern: a symmetric pattern; its multipliers are ignored.
    """

    def __init__(self, pattern: Pattern) -> None:
        self.pattern = pattern
        nodes, graph = nodes_of(pattern)
        fronts, self.cost = fronts_of(graph, np.array([len(node) for node in nodes], float))
        self._number(nodes, fronts)
        self._lay_out(nodes, fronts)
        self._place_entries()

    def _number(self, nodes: list[Ints], fronts: list[Front]) -> None:
        """Positions of the coordinates: front after front, each padded to a multiple of four pivots."""
        self._fronts = np.full((len(fronts) + 1, 11), -1, dtype=np.int64)
        self._position = np.zeros(self.pattern.n, dtype=np.int64)
        self._front_of = np.zeros(self.pattern.n, dtype=np.int64)
        first, padded = 0, []
        for f, front in enumerate(fronts):
            coords = np.concatenate([nodes[node] for node in front.pivots])
            self._position[coords] = first + np.arange(len(coords))
            self._front_of[coords] = f
            p = _up(len(coords), 4)
            padded.append(first + np.arange(len(coords), p))
            self._fronts[f, :2] = first, p
            first += p
        self._padded = np.concatenate(padded)
        self._coordinate = np.full(first, -1)
        self._coordinate[self._position] = np.arange(self.pattern.n)

    def _lay_out(self, nodes: list[Ints], fronts: list[Front]) -> None:
        """Remaining rows of each front, the runs by which they enter the parent, and where panels and updates lie."""
        table = self._fronts
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
                parent = int(self._front_of[self._coordinate[rows[0]]])
                table[f, 10], table[parent, 9] = table[parent, 9], f
                runs.append(_runs(self._local(parent, rows), table[parent, 1]))
                n_run += len(runs[-1])
        table[-1, 8] = n_run
        self._rows = np.concatenate(self._rest)
        self._runs = np.concatenate([np.zeros((0, 3), np.int64), *runs])
        self.size = int(a0)
        self._a, self._u = np.zeros(a0), np.zeros(space.size)
        self._signs, self._limits = np.ones(len(self._coordinate)), np.zeros(len(self._coordinate))
        longest = int(table[:, 2].max())
        self._b, self._y = np.zeros(front_kernels.BLOCK * longest), np.zeros(longest)

    def _positions(self, nodes: list[Ints], rest: set[int]) -> Ints:
        """Ascending positions of the coordinates of nodes."""
        return np.sort(np.concatenate([np.zeros(0, np.int64), *(self._position[nodes[node]] for node in rest)]))

    def _local(self, f: int, positions: Ints) -> Ints:
        """Row in front f of each position."""
        first, p = self._fronts[f, :2]
        return np.where(positions < first + p, positions - first, p + np.searchsorted(self._rest[f], positions))

    def _place_entries(self) -> None:
        """Slot of each entry of the pattern, and of the padded pivots, in the panels."""
        p, q = self._position[self.pattern.rows], self._position[self.pattern.indices]
        column, row = np.minimum(p, q), np.maximum(p, q)
        owner = self._front_of[self._coordinate[column]]
        self._slots = np.zeros(len(p), np.int64)
        by_owner = np.argsort(owner, kind="stable")
        bounds = np.searchsorted(owner[by_owner], np.arange(len(self._fronts)))
        for f in range(len(self._fronts) - 1):
            mine = by_owner[bounds[f] : bounds[f + 1]]
            first, _, a_len, a0 = self._fronts[f, :4]
            self._slots[mine] = a0 + (column[mine] - first) * a_len + self._local(f, row[mine])
        f = np.searchsorted(self._fronts[:-1, 0], self._padded, side="right") - 1
        first, a_len, a0 = self._fronts[f, 0], self._fronts[f, 2], self._fronts[f, 3]
        self._ones = a0 + (self._padded - first) * (a_len + 1)
        diagonal = np.flatnonzero(p == q)
        self._diagonal, self._diagonal_position = diagonal, p[diagonal]

    def factorise(self, k: Floats) -> int:
        """Factorise; -1, or the coordinate whose pivot is rounding error."""
        self._limits[self._diagonal_position] = PIVOT_TOLERANCE * np.abs(k[self._diagonal])
        failed = front_kernels.factorise(
            k, self._slots, self._ones, self._fronts, self._runs, self._limits, self._a, self._u, self._signs, self._b
        )
        self.negative_pivots = int(np.count_nonzero(self._signs < 0))
        return int(self._coordinate[failed]) if failed >= 0 else -1

    def solve(self, r: Floats) -> Floats:
        """K^-1 r by forward and back substitution."""
        if r.ndim == 1:
            z = np.zeros(len(self._coordinate))
            z[self._position] = r
            front_solution.solve(self._fronts, self._rows, self._a, self._signs, z, self._y)
            return z[self._position]
        x, columns = np.empty_like(r), r.reshape(len(r), -1)
        out = x.reshape(columns.shape)
        z = np.zeros(len(self._coordinate))
        for i in range(columns.shape[1]):
            z[self._padded] = 0.0
            z[self._position] = columns[:, i]
            front_solution.solve(self._fronts, self._rows, self._a, self._signs, z, self._y)
            out[:, i] = z[self._position]
        return x
