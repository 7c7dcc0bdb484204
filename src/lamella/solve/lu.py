"""Multifrontal factorisation A = L U of unsymmetric matrices on the node blocks of a mesh."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from lamella.assembly.pattern import Pattern
from lamella.assembly.pattern_kernels import sorted_by
from lamella.lane import WIDTH, aligned
from lamella.roles import Floats, Ints
from lamella.solve import front_solution, lu_kernels
from lamella.solve.base import PIVOT_TOLERANCE
from lamella.solve.front_kernels import BLOCK
from lamella.solve.layout import layout_of
from lamella.solve.panels import Panels


class MultifrontalLU:
    """L U with pivots on the diagonal in a fixed order, in dense fronts.

    No rows are exchanged, so the accuracy of a factorisation must be checked.

    Args:
        pattern: a pattern that holds all entries; its multipliers are ignored.
        sources: where the value of each entry is found, see :func:`lamella.solve.lu_kernels.value`.

    Attributes:
        n: number of positions in the order of elimination, some of which only fill up.
        position: position of each coordinate.
        magnitude: |A_ii| by position at the last factorisation, 0 where a position fills up.
    """

    def __init__(self, pattern: Pattern, sources: Ints) -> None:
        self.pattern = pattern
        self._layout = layout = layout_of(pattern)
        self.cost, self.size = 2.0 * layout.cost, 2 * layout.size
        self.n, self.position, self.magnitude = len(layout.coordinate), layout.position, np.zeros(len(layout.coordinate))
        # Entries front after front, each with its place in the panels of L, or behind them in those of U^T.
        owner, place, above = layout.by_entry(pattern)
        part = 2 * owner + (sources < 0)
        order, ends = sorted_by(part, 2 * len(layout.fronts) - 2)
        slots = np.where(above, place + layout.size, place)[order]
        numbers = np.where(sources < 0, -1 - sources, sources)[order]
        self._diagonal = sources[layout.diagonal].astype(np.int32)
        self._entries = lu_kernels.Entries(numbers.astype(np.int32), slots.astype(np.uint32), np.append(0, ends[:-1]))
        self._padded_at = layout.pivots[layout.padded]
        self._panels = Panels(2 * layout.size)
        self._a, self._c = self._panels.written[: layout.size], self._panels.written[layout.size :]
        self._u, self._v = aligned(layout.update_size), aligned(layout.update_size)
        self._signs, self._ones = np.ones(self.n), np.ones(BLOCK)
        self._b, self._y = aligned(BLOCK * layout.longest + WIDTH), aligned(layout.longest + WIDTH)
        self._order, self._rest = np.arange(len(layout.fronts) - 1), np.zeros(len(layout.rows))

    def factorise(self, k: Floats, more: Floats) -> int:
        """Factorise the matrix of values in both arrays; -1, or the coordinate whose pivot is rounding error."""
        at = self._layout
        self._panels.renew()
        lu_kernels.sizes(k, more, self._diagonal, at.diagonal_position, self.magnitude)
        limits = PIVOT_TOLERANCE * self.magnitude
        failed = lu_kernels.factorise(
            k, more, self._entries, self._padded_at, at.fronts, at.runs, limits,
            self._panels.written, self._a, self._c, self._u, self._v, self._ones, self._b,
        )  # fmt: skip
        return int(at.coordinate[failed]) if failed >= 0 else -1

    @property
    def negative_pivots(self) -> int:
        """Negative pivots, which are the negative eigenvalues of a symmetric matrix."""
        return int(np.count_nonzero(self._panels.read[self._layout.size :][self._layout.pivots] < 0))

    def coordinate_at(self, position: int) -> int:
        """The coordinate at a position."""
        return int(self._layout.coordinate[position])

    def shorten(self) -> None:
        """Read the factor in single precision from now on, where that is faster."""
        self._panels.shorten()

    def solve(self, z: Floats) -> None:
        """z <- A^-1 z by position, zero at those that fill up, for the last successful factorisation."""
        order, fronts, rows, runs, a, c, signs, rest, y = self.arrays
        front_solution.solve(order, fronts, rows, runs, a, c, signs, z, rest, y)

    @property
    def arrays(self) -> tuple[NDArray[Any], ...]:
        """The factorisation and two workspaces, as :func:`lamella.solve.front_solution.solve` takes them before and behind z."""
        at, read, size = self._layout, self._panels.read, self._layout.size
        return self._order, at.fronts, at.rows, at.runs, read[:size], read[size:], self._signs, self._rest, self._y
