"""Multifrontal factorisation A = L U of unsymmetric matrices on the node blocks of a mesh."""

from __future__ import annotations

import numpy as np

from lamella.assembly.pattern import Pattern
from lamella.roles import Floats
from lamella.solve import front_solution, lu_kernels
from lamella.solve.base import PIVOT_TOLERANCE
from lamella.solve.front_kernels import BLOCK
from lamella.solve.layout import FrontLayout


class MultifrontalLU:
    """L U with pivots on the diagonal in a fixed order, in dense fronts.

    No rows are exchanged, so the accuracy of a factorisation must be checked.

    Args:
        pattern: a pattern that holds all entries; its multipliers are ignored.
    """

    def __init__(self, pattern: Pattern) -> None:
        self.pattern = pattern
        self._layout = layout = FrontLayout(pattern)
        self.cost, self.size = 2.0 * layout.cost, 2 * layout.size
        # One number for each entry: its place in the panels of L, or behind them in those of U^T; short ones are read faster.
        self._slots = np.where(layout.above, layout.slots + layout.size, layout.slots).astype(np.int32)
        self._padded_at = layout.pivots[layout.padded]
        panels = np.zeros(2 * layout.size)
        self._panels, self._a, self._c = panels, panels[: layout.size], panels[layout.size :]
        self._u, self._v = np.zeros(layout.update_size), np.zeros(layout.update_size)
        self._signs, self._ones = np.ones(len(layout.coordinate)), np.ones(BLOCK)
        self._b, self._y = np.zeros(BLOCK * layout.longest), np.zeros(layout.longest)

    def factorise(self, k: Floats) -> int:
        """Factorise; -1, or the coordinate whose pivot is rounding error."""
        at = self._layout
        limits = at.limits(k, PIVOT_TOLERANCE)
        failed = lu_kernels.factorise(
            k, self._slots, self._padded_at, at.fronts, at.runs, limits,
            self._panels, self._a, self._c, self._u, self._v, self._ones, self._b,
        )  # fmt: skip
        return int(at.coordinate[failed]) if failed >= 0 else -1

    @property
    def negative_pivots(self) -> int:
        """Negative pivots, which are the negative eigenvalues of a symmetric matrix."""
        return int(np.count_nonzero(self._c[self._layout.pivots] < 0))

    def solve(self, r: Floats) -> Floats:
        """A^-1 r for the last successful factorisation, r (n,)."""
        at = self._layout
        z = np.zeros(len(at.coordinate))
        z[at.position] = r
        front_solution.solve(at.fronts, at.rows, self._a, self._c, self._signs, z, self._y)
        return z[at.position]
