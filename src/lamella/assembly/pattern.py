"""The fixed sparsity pattern of a model's matrix and of its constraint Jacobian."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy import sparse

from lamella.roles import Floats, Ints


def _rows(indptr: Ints) -> Ints:
    """Row of each stored entry of a CSR pattern."""
    return np.repeat(np.arange(len(indptr) - 1), np.diff(indptr))


@dataclass(frozen=True, eq=False)
class Pattern:
    """Where the entries of K and of the constraint Jacobian J = Phi_q (after elimination) stand, in compressed rows.

    A pattern is equal to itself alone, so that what is found for it can be kept with it.

    Args:
        n: number of independent coordinates.
        indptr: start of each row of K, shape (n + 1,).
        indices: columns of K, ascending in each row: the upper triangle with the diagonal when symmetric, else all entries.
        symmetric: whether K is symmetric, so that only its upper triangle is stored.
        n_lam: number of Lagrange multipliers, may be 0.
        j_indptr: start of each row of J, shape (n_lam + 1,).
        j_indices: columns of J.

    Raises:
        ValueError: the arrays do not fit together.
    """

    n: int
    indptr: Ints
    indices: Ints
    symmetric: bool
    n_lam: int
    j_indptr: Ints
    j_indices: Ints

    def __post_init__(self) -> None:
        if len(self.indptr) != self.n + 1 or self.indptr[-1] != len(self.indices):
            raise ValueError(f"pattern of K: {len(self.indptr)} row starts, {len(self.indices)} columns for n = {self.n}")
        if len(self.j_indptr) != self.n_lam + 1 or self.j_indptr[-1] != len(self.j_indices):
            raise ValueError(
                f"pattern of J: {len(self.j_indptr)} row starts, {len(self.j_indices)} columns for {self.n_lam} rows"
            )
        if self.symmetric and np.any(self.indices < self.rows):
            raise ValueError("pattern of K: an entry lies below the diagonal of a symmetric matrix; list the upper triangle only")

    @property
    def rows(self) -> Ints:
        """Row of each entry of K, shape (nnz,)."""
        return _rows(self.indptr)

    @cached_property
    def _diagonal(self) -> Ints:
        return np.flatnonzero(self.rows == self.indices)

    def diagonal(self, k: Floats) -> Floats:
        """Diagonal of K with the given values, shape (n,)."""
        return k[self._diagonal]

    @property
    def j_rows(self) -> Ints:
        """Row of each entry of J, shape (j_nnz,)."""
        return _rows(self.j_indptr)

    def matrix(self, k: Floats) -> sparse.csr_array:
        """K with the given values [in pattern order], both triangles, shape (n, n)."""
        stored = sparse.csr_array((k, self.indices, self.indptr), shape=(self.n, self.n))
        if not self.symmetric:
            return stored
        return (stored + sparse.triu(stored, 1).T).tocsr()

    def jacobian(self, j: Floats) -> sparse.csr_array:
        """J with the given values [in pattern order], shape (n_lam, n)."""
        return sparse.csr_array((j, self.j_indices, self.j_indptr), shape=(self.n_lam, self.n))
