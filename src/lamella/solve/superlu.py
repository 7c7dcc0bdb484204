"""SuperLU for indefinite, unsymmetric and saddle-point matrices, with equilibration, residual check and named singularities."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.sparse.linalg import SuperLU, splu

from lamella.assembly.pattern import Pattern
from lamella.errors import SingularSystemError
from lamella.roles import Floats
from lamella.solve.base import BACKWARD_ERROR_LIMIT, CONDITION_LIMIT, LinearSolver, not_finite, singular
from lamella.solve.saddle import SaddleMatrix, probe

REFINE_ABOVE = 1e-12
"""Residual relative to the right-hand side above which one step of iterative refinement is made."""


class SuperLUSolver(LinearSolver):
    """LU factorisation of the equilibrated saddle-point matrix by SuperLU.

    The matrix is ordered by minimum degree on A + A^T and takes its pivots on the diagonal where these are not much smaller than
    the rest of their column; that order is kept. When the result is poor, rows are exchanged freely and columns ordered by
    COLAMD.

    Source: X. S. Li, ACM Trans. Math. Softw. 31 (2005) 302-325.
    """

    def __init__(self, pattern: Pattern) -> None:
        self.pattern = pattern
        self._a = SaddleMatrix(pattern)
        self._probe = probe(self._a.size)
        self._ordered = False
        self._lu: SuperLU | None = None

    @property
    def negative_pivots(self) -> int | None:
        """By Sylvester's law from the signs of the pivots, when all stand on the diagonal of a symmetric matrix."""
        if self._lu is None or not self.pattern.symmetric or not np.array_equal(self._lu.perm_r, self._lu.perm_c):
            return None
        return int(np.count_nonzero(self._lu.U.diagonal() < 0)) - self.pattern.n_lam

    def factorise(self, k: Floats, j: Floats) -> None:
        """Equilibrate, factorise, and check by one solution, which shows a singular matrix."""
        self._lu = None
        error = not_finite(self.pattern, k, j)
        if error is not None:
            raise error
        self._a.fill(k, j)
        if not self._pivot_on_diagonal(k, j) and not self._pivot_freely():
            self._lu = None
            raise singular(self.pattern, self._a.free_index())

    def solve(self, r: Floats, s: Floats) -> tuple[Floats, Floats]:
        """Solve, with one step of iterative refinement when the residual is not small."""
        if self._lu is None:
            raise SingularSystemError("there is no factorisation to solve with; factorise a regular matrix first")
        b = self._a.scaled(r, s)
        z = self._lu.solve(b)
        residual = b - self._a.matrix @ z
        if np.abs(residual).max(initial=0.0) > REFINE_ABOVE * np.abs(b).max(initial=0.0):
            z += self._lu.solve(residual)
        return self._a.unscaled(z)

    def _pivot_on_diagonal(self, k: Floats, j: Floats) -> bool:
        method = "NATURAL" if self._ordered else "MMD_AT_PLUS_A"
        usable = self._attempt(permc_spec=method, diag_pivot_thresh=0.01, options={"SymmetricMode": True})
        if usable and not self._ordered and self._lu is not None:
            self._a, self._ordered = SaddleMatrix(self.pattern, np.argsort(self._lu.perm_c)), True
            self._a.fill(k, j)
            return self._pivot_on_diagonal(k, j)
        return usable

    def _pivot_freely(self) -> bool:
        return self._attempt(permc_spec="COLAMD", diag_pivot_thresh=1.0)

    def _attempt(self, **options: Any) -> bool:
        """Factorise; whether the factors are accurate and the matrix is regular."""
        try:
            self._lu = lu = splu(self._a.matrix, **options)
        except RuntimeError:  # SuperLU's only report of an exactly zero pivot
            return False
        z = lu.solve(self._probe)
        norm = np.abs(z).max(initial=0.0)
        if not norm < CONDITION_LIMIT:
            return False
        error = np.abs(self._a.matrix @ z - self._probe).max(initial=0.0)
        return bool(error <= BACKWARD_ERROR_LIMIT * (norm + 1.0))
