"""A symmetric matrix with few multipliers, by the Schur complement."""

from __future__ import annotations

import numpy as np
from scipy import sparse
from scipy.linalg import get_lapack_funcs

from lamella.errors import SingularSystemError
from lamella.roles import Floats
from lamella.solve.base import BACKWARD_ERROR_LIMIT, PIVOT_TOLERANCE, LinearSolver, SymmetricFactor, not_finite, singular
from lamella.solve.null_space_kernels import product
from lamella.solve.saddle import probe

_potrf, _potrs = get_lapack_funcs(("potrf", "potrs"), dtype=np.float64)


class SchurSolver(LinearSolver):
    """Solver on a symmetric factorisation of K:

        S y = J K^-1 r - s,      x = K^-1 (r - J^T y),      S = J K^-1 J^T

    S is formed densely, with one solution for each multiplier. Without multipliers only K is factorised. By Haynsworth's
    formula K has as many negative eigenvalues on the null space of J as K has, less those of S.

    Args:
        factor: factorisation of K.

    Source: M. Benzi, G. H. Golub, J. Liesen, Acta Numerica 14 (2005) 1-137, section 5.
    """

    def __init__(self, factor: SymmetricFactor) -> None:
        self.pattern, self._factor = factor.pattern, factor
        self._probe = probe(factor.pattern.n)
        self._negative: int | None = None
        self._j_indptr, self._j_indices = factor.pattern.j_indptr.astype(np.int64), factor.pattern.j_indices.astype(np.int32)

    @property
    def negative_pivots(self) -> int | None:
        """Of K on the null space of J."""
        return self._negative

    def factorise(self, k: Floats, j: Floats) -> None:
        """Factorise; an error also when the matrix is regular but the pivots on the diagonal cannot be used."""
        free = self.try_factorise(k, j)
        if free >= 0:
            raise not_finite(self.pattern, k, j) or self._unusable(free)

    def _unusable(self, index: int) -> SingularSystemError:
        if index >= self.pattern.n:
            return singular(self.pattern, index)
        where = f"independent coordinate {index} of {self.pattern.n}"
        cause = "either it is not held, or the state is unstable and needs the linear solver 'auto' or 'superlu'"
        return SingularSystemError(f"the system matrix has no usable pivot at {where}; {cause}", index)

    def try_factorise(self, k: Floats, j: Floats) -> int:
        """Factorise; -1, or the coordinate or multiplier without a usable pivot."""
        self._negative = None
        free = self._factor.factorise(k)
        if free < 0 and self._factor.negative_pivots:
            free = self._inaccurate(k)
        negative = self._factor.negative_pivots
        if free < 0 and self.pattern.n_lam:
            free, negative_complement = self._complement(j)
            negative -= negative_complement
        if free < 0:
            self._negative = negative
        return free

    def _inaccurate(self, k: Floats) -> int:
        """Solve for a known right-hand side; -1, or the coordinate with the largest residual when it is not small."""
        upper = sparse.csr_array((k, self.pattern.indices, self.pattern.indptr), shape=(self.pattern.n, self.pattern.n))
        diagonal = self.pattern.diagonal(k)
        scale = np.sqrt(np.maximum(np.abs(diagonal), np.finfo(float).tiny))
        b = self._probe * scale
        x = self._factor.solve(b)
        residual = np.abs(upper @ x + upper.T @ x - diagonal * x - b) / scale
        small = residual <= BACKWARD_ERROR_LIMIT * (np.abs(x * scale).max() + 1.0)
        return -1 if small.all() else int(np.argmax(np.where(np.isfinite(residual), residual, np.inf)))

    def _complement(self, j: Floats) -> tuple[int, int]:
        """Form and invert S; -1 or the multiplier (behind the coordinates) that is free, and its negative eigenvalues."""
        n = self.pattern.n
        self._j_values = j.copy()
        jacobian = self.pattern.jacobian(self._j_values)
        self._k_inv_jt = self._factor.solve(np.asfortranarray(jacobian.toarray().T))
        schur = np.asfortranarray(jacobian @ self._k_inv_jt)
        diagonal = np.abs(schur.diagonal())
        if self._factor.negative_pivots == 0:
            factor, info = _potrf(schur, lower=1)
            if info > 0:
                return n + info - 1, 0
            small = ~(factor.diagonal() ** 2 > PIVOT_TOLERANCE * diagonal)
            self._solve_complement = lambda d: _potrs(factor, d, lower=1)[0]
            return (n + int(np.argmax(small)) if small.any() else -1), 0
        scale = np.sqrt(np.maximum(diagonal, np.finfo(float).tiny))
        values, vectors = np.linalg.eigh(schur / scale / scale[:, None])
        least = int(np.argmin(np.abs(values)))
        if not np.abs(values[least]) > PIVOT_TOLERANCE * np.abs(values).max():
            return n + int(np.argmax(np.abs(vectors[:, least]))), 0
        vectors /= scale[:, None]
        self._solve_complement = lambda d: vectors @ (vectors.T @ d / values)
        return -1, int(np.count_nonzero(values < 0))

    def solve(self, r: Floats, s: Floats) -> tuple[Floats, Floats]:
        """Solve. The error of y shows in J x = s alone and is corrected once."""
        if self._negative is None:
            raise SingularSystemError("there is no factorisation to solve with; factorise a regular matrix first")
        x, y = self._factor.solve(r), np.zeros(self.pattern.n_lam)
        if not len(y):
            return x, y
        d = np.empty_like(y)
        for _ in range(2):
            product(self._j_indptr, self._j_indices, self._j_values, x, d)
            dy = self._solve_complement(d - s)
            y += dy
            x -= self._k_inv_jt @ dy
        return x, y
