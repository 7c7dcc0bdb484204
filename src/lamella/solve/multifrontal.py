"""Multifrontal factorisation K = L S L^T of symmetric matrices on the node blocks of a mesh."""

from __future__ import annotations

import numpy as np

from lamella.assembly.pattern import Pattern
from lamella.lane import WIDTH, aligned
from lamella.roles import Floats
from lamella.solve import front_kernels, front_solution
from lamella.solve.base import PIVOT_TOLERANCE, SymmetricFactor
from lamella.solve.layout import layout_of


class Multifrontal(SymmetricFactor):
    """L S L^T with S = diag(+-1) and pivots on the diagonal in a fixed order, in dense fronts.

    For a positive definite matrix this is Cholesky's factorisation. An indefinite one is factorised without exchange of rows:
    its accuracy must be checked, and the signs then give the number of negative eigenvalues.

    Args:
        pattern: a symmetric pattern; its multipliers are ignored.
    """

    def __init__(self, pattern: Pattern) -> None:
        self.pattern = pattern
        self._layout = layout = layout_of(pattern)
        self.cost, self.size = layout.cost, layout.size
        self._a, self._u = aligned(layout.size + WIDTH), aligned(layout.update_size)
        self._signs = np.ones(len(layout.coordinate))
        self._padded_at = layout.pivots[layout.padded]
        self._z = np.zeros(len(layout.coordinate))
        self._b, self._y = aligned(front_kernels.BLOCK * layout.longest + WIDTH), aligned(layout.longest)

    def factorise(self, k: Floats) -> int:
        """Factorise; -1, or the coordinate whose pivot is rounding error."""
        at = self._layout
        limits = at.limits(k, PIVOT_TOLERANCE)
        failed = front_kernels.factorise(
            k, at.slots, self._padded_at, at.fronts, at.runs, limits, self._a, self._u, self._signs, self._b
        )
        self.negative_pivots = int(np.count_nonzero(self._signs < 0))
        return int(at.coordinate[failed]) if failed >= 0 else -1

    def solve(self, r: Floats) -> Floats:
        """K^-1 r by forward and back substitution."""
        at, x = self._layout, np.empty_like(r)
        if r.ndim == 1:
            front_solution.solve_coordinates(
                at.fronts, at.rows, self._a, self._a, self._signs, at.position, r, self._z, self._y, x
            )
            return x
        columns, out = r.reshape(len(r), -1), x.reshape(len(r), -1)
        for i in range(columns.shape[1]):
            out[:, i] = self.solve(np.ascontiguousarray(columns[:, i]))
        return x
