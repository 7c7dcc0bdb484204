"""A symmetric positive definite matrix with few multipliers, by the Schur complement."""

from __future__ import annotations

import numpy as np
from scipy.linalg import get_lapack_funcs

from lamella.errors import SingularSystemError
from lamella.roles import Floats
from lamella.solve.base import PIVOT_TOLERANCE, DefiniteFactor, LinearSolver, not_finite, singular

_potrf, _potrs = get_lapack_funcs(("potrf", "potrs"), dtype=np.float64)


class SchurSolver(LinearSolver):
    """Solver on a Cholesky factor of K:

        S y = J K^-1 r - s,      x = K^-1 (r - J^T y),      S = J K^-1 J^T

    S is formed densely, with one solution for each multiplier. Without multipliers this is a Cholesky solver.

    Args:
        factor: factorisation of K.

    Source: M. Benzi, G. H. Golub, J. Liesen, Acta Numerica 14 (2005) 1-137, section 5.
    """

    def __init__(self, factor: DefiniteFactor) -> None:
        self.pattern, self._factor = factor.pattern, factor
        self._usable = False

    @property
    def negative_pivots(self) -> int | None:
        """0: a matrix with Cholesky factors has no negative eigenvalue."""
        return 0 if self._usable else None

    def factorise(self, k: Floats, j: Floats) -> None:
        """Factorise; an error also when the matrix is regular but not positive definite."""
        free = self.try_factorise(k, j)
        if free >= 0:
            raise not_finite(self.pattern, k, j) or self._not_definite(free)

    def _not_definite(self, index: int) -> SingularSystemError:
        if index >= self.pattern.n:
            return singular(self.pattern, index)
        where = f"at independent coordinate {index} of {self.pattern.n}"
        cause = "either it is not held, or the state is unstable and needs the linear solver 'auto' or 'superlu'"
        return SingularSystemError(f"the system matrix is not positive definite {where}; {cause}", index)

    def try_factorise(self, k: Floats, j: Floats) -> int:
        """Factorise; -1, or the coordinate or multiplier whose pivot is not positive."""
        free = self._factor.try_factorise(k)
        if free < 0 and self.pattern.n_lam:
            free = self._complement(j)
        self._usable = free < 0
        return free

    def _complement(self, j: Floats) -> int:
        self._j = self.pattern.jacobian(j.copy())
        self._k_inv_jt = self._factor.solve(np.asfortranarray(self._j.toarray().T))
        schur = np.asfortranarray(self._j @ self._k_inv_jt)
        diagonal = schur.diagonal().copy()
        self._s, info = _potrf(schur, lower=1, overwrite_a=1)
        if info > 0:
            return self.pattern.n + info - 1
        small = ~(self._s.diagonal() ** 2 > PIVOT_TOLERANCE * diagonal)
        return self.pattern.n + int(np.argmax(small)) if small.any() else -1

    def solve(self, r: Floats, s: Floats) -> tuple[Floats, Floats]:
        """Solve. The error of y shows in J x = s alone and is corrected once."""
        if not self._usable:
            raise SingularSystemError("there is no factorisation to solve with; factorise a regular matrix first")
        x = self._factor.solve(r)
        if not self.pattern.n_lam:
            return x, np.zeros(0)
        y = np.zeros(self.pattern.n_lam)
        for _ in range(2):
            dy, _ = _potrs(self._s, self._j @ x - s, lower=1)
            y += dy
            x -= self._k_inv_jt @ dy
        return x, y
