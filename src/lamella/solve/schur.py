"""A symmetric matrix with few multipliers, by the Schur complement."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.linalg import get_lapack_funcs

from lamella.errors import SingularSystemError
from lamella.roles import Floats
from lamella.solve.base import (
    BACKWARD_ERROR_LIMIT,
    PIVOT_TOLERANCE,
    REFINE_ABOVE,
    LinearSolver,
    SymmetricFactor,
    not_finite,
    singular,
)
from lamella.solve.check_kernels import backward_error, residual
from lamella.solve.null_space_kernels import product, scaled
from lamella.solve.saddle import probe

_potrf, _potrs = get_lapack_funcs(("potrf", "potrs"), dtype=np.float64)


class SchurSolver(LinearSolver):
    """Solver on a symmetric factorisation of K:

        S y = J K^-1 r - s,      x = K^-1 (r - J^T y),      S = J K^-1 J^T

    S is formed densely, with one solution for each multiplier. Without multipliers only K is factorised. By Haynsworth's
    formula K has as many negative eigenvalues on the null space of J as K has, less those of S.

    Each factorisation is checked by the solution of a known system, and where it is less accurate than it could be, solutions
    are refined once.

    Args:
        factor: factorisation of K.

    Source: M. Benzi, G. H. Golub, J. Liesen, Acta Numerica 14 (2005) 1-137, section 5.
    """

    def __init__(self, factor: SymmetricFactor) -> None:
        self.pattern, self._factor = factor.pattern, factor
        pattern = factor.pattern
        self._probe, self._b, self._rest = probe(pattern.n), np.zeros(pattern.n), np.zeros(pattern.n)
        self._rows = pattern.indptr.astype(np.int64), pattern.indices.astype(np.uint32)
        self._k: Floats | None = None
        self._negative: int | None = None
        self._j_indptr, self._j_indices = pattern.j_indptr.astype(np.int64), pattern.j_indices.astype(np.int32)

    @property
    def negative_pivots(self) -> int | None:
        """Of K on the null space of J."""
        return self._negative

    @property
    def work_per_entry(self) -> float:
        """Of the factorisation of K."""
        return self._factor.cost / self._factor.size * (1.6 if self._factor.shortens else 1.0)

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
        if free < 0:
            error, worst = self._backward_error(k)
            self._k = k.copy() if error > REFINE_ABOVE else None
            free = -1 if error <= BACKWARD_ERROR_LIMIT else worst
        negative = self._factor.negative_pivots
        if free < 0 and self.pattern.n_lam:
            free, negative_complement = self._complement(j)
            negative -= negative_complement
        if free < 0:
            self._negative = negative
        return free

    def _backward_error(self, k: Floats) -> tuple[float, int]:
        """Largest |K x - b| / (|x| + 1) of a known system, scaled to a diagonal of 1, and where it is."""
        b, rest, magnitude = self._b, self._rest, np.abs(self.pattern.diagonal(k))
        scaled(magnitude, self._probe, b, rest)
        return backward_error(*self._rows, k, magnitude, b, self._factor.solve(b), rest)

    def _solved(self, r: Floats) -> Floats:
        """K^-1 r, shape (n,)."""
        x = self._factor.solve(r)
        if self._k is not None:
            residual(*self._rows, self._k, r, x, self._rest)
            x += self._factor.solve(self._rest)
        return x

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

    def shorten(self, singles: bool = True) -> None:
        """Solve roughly from now on; constraints hold to rounding all the same."""
        self._factor.shorten(singles and not self.pattern.n_lam)

    def solve(self, r: Floats, s: Floats) -> tuple[Floats, Floats]:
        """Solve. The error of y shows in J x = s alone and is corrected once."""
        if self._negative is None:
            raise SingularSystemError("there is no factorisation to solve with; factorise a regular matrix first")
        return self._completed(self._solved(r), s)

    def solve_each(self, rights: Sequence[tuple[Floats, Floats]]) -> list[tuple[Floats, Floats]]:
        """Solve, with one reading of the factor for several right-hand sides unless solutions are refined."""
        if self._k is not None or self._negative is None:
            return super().solve_each(rights)
        x = self._factor.solve(np.array([r for r, _ in rights]).T)
        return [self._completed(row, s) for row, (_, s) in zip(x.T, rights, strict=True)]

    def _completed(self, x: Floats, s: Floats) -> tuple[Floats, Floats]:
        """The solution with multipliers from x = K^-1 r, which is overwritten."""
        y = np.zeros(self.pattern.n_lam)
        if not len(y):
            return x, y
        d = np.empty_like(y)
        for _ in range(2):
            product(self._j_indptr, self._j_indices, self._j_values, x, d)
            dy = self._solve_complement(d - s)
            y += dy
            x -= self._k_inv_jt @ dy
        return x, y
