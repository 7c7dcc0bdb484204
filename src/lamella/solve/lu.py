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
        self._lower, self._upper = np.flatnonzero(~layout.above), np.flatnonzero(layout.above)
        self._slots = layout.slots[self._lower], layout.slots[self._upper]
        self._padded_at = layout.pivots[layout.padded]
        self._a, self._c = np.zeros(layout.size), np.zeros(layout.size)
        self._u, self._v = np.zeros(layout.update_size), np.zeros(layout.update_size)
        self._signs, self._ones = np.ones(len(layout.coordinate)), np.ones(BLOCK)
        self._b, self._y = np.zeros(BLOCK * layout.longest), np.zeros(layout.longest)

    def factorise(self, k: Floats) -> int:
        """Factorise; -1, or the coordinate whose pivot is rounding error."""
        at = self._layout
        failed = lu_kernels.factorise(
            k, self._lower, self._slots[0], self._upper, self._slots[1], self._padded_at, at.fronts, at.runs,
            at.limits(k, PIVOT_TOLERANCE), self._a, self._c, self._u, self._v, self._ones, self._b,
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
