"""The mass matrix as operators on vectors of coordinates."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from scipy import sparse

from lamella.assembly.operator import VectorOperator
from lamella.inertia import whole_mass
from lamella.model import Model
from lamella.roles import Floats


class Mass:
    """M in all coordinates and T^T M T in the independent ones; each is made when first needed, since statics needs neither.

    Args:
        model: the compiled model.
        T: map from independent to all coordinates, (n_q, n_u).
        like: that of another model with the same ``T``, whose operators serve here as well where the masses are equal.
    """

    def __init__(self, model: Model, T: sparse.csr_array, like: Mass | None = None) -> None:
        self._model, self._T, self._like = model, T, like

    @cached_property
    def _same(self) -> Mass | None:
        if self._like is None:
            return None
        mine, theirs = self._model.vector_mass, self._like._model.vector_mass
        return self._like if mine.nnz == theirs.nnz and abs(mine - theirs).max() == 0.0 else None

    @cached_property
    def in_all(self) -> VectorOperator:
        """M, for all coordinates (n_q,)."""
        return self._same.in_all if self._same else VectorOperator(self._model.vector_mass)

    @cached_property
    def in_independent(self) -> VectorOperator | None:
        """T^T M T; None where it does not go by vectors, since three products are faster then."""
        if self._same:
            return self._same.in_independent
        return _operator(self._by_vectors, self._model.vector_mass, self._T)

    @cached_property
    def _by_vectors(self) -> sparse.csr_array | None:
        return reduced(self._model.vector_mass, self._T)

    @cached_property
    def diagonal(self) -> Floats:
        """That of T^T M T, shape (n_u,)."""
        T, by_vectors = self._T, self._by_vectors
        if by_vectors is None:
            return (T.T @ whole_mass(self._model.vector_mass, len(T.indptr) - 1) @ T).diagonal()
        massive = np.repeat(by_vectors.diagonal(), 3)
        found = np.zeros(int(T.indices.max()) + 1)  # each independent coordinate is one of all
        found[: len(massive)] = massive
        return found


def in_independent(m: sparse.csr_array, T: sparse.csr_array) -> VectorOperator | None:
    """T^T (m x 1_3) T; None where it does not go by vectors; arguments as for :func:`reduced`."""
    return _operator(reduced(m, T), m, T)


def _operator(by_vectors: sparse.csr_array | None, m: sparse.csr_array, T: sparse.csr_array) -> VectorOperator | None:
    if by_vectors is not None:
        return VectorOperator(by_vectors)
    return VectorOperator.within(sparse.csr_array(T.T @ whole_mass(m, len(T.indptr) - 1) @ T))


def reduced(m: sparse.csr_array, T: sparse.csr_array) -> sparse.csr_array | None:
    """t^T m t where T = t x 1_3 in the rows of vectors; else, and where there is no mass, None.

    Args:
        m: of the vectors, sparse (n_vectors, n_vectors).
        T: map from independent to all coordinates, (n_q, n_u); fields behind the vectors have no mass.
    """
    t = of_vectors(T, len(m.indptr) - 1)
    if t is None or not m.nnz:
        return None
    if np.all(t.data == 1.0) and len(np.unique(t.indices)) == t.nnz == np.count_nonzero(np.diff(t.indptr)):
        chosen = np.flatnonzero(np.diff(t.indptr))[np.argsort(t.indices)]  # supports hold the others
        return m[chosen][:, chosen]
    return sparse.csr_array(t.T @ m @ t)


def of_vectors(T: sparse.csr_array, n: int) -> sparse.csr_array | None:
    """The map of vectors t, sparse (n, n_u / 3), if T = t x 1_3 in the first 3 n rows; else None."""
    indptr = np.asarray(T.indptr)[: 3 * n + 1]
    rows = np.repeat(np.arange(3 * n), np.diff(indptr))
    columns, factors = np.asarray(T.indices)[: indptr[-1]], np.asarray(T.data)[: indptr[-1]]
    if not np.array_equal(rows % 3, columns % 3):
        return None
    parts = [(rows[c] // 3, columns[c] // 3, factors[c]) for c in (rows % 3 == k for k in range(3))]
    if not all(np.array_equal(*pair) for other in parts[1:] for pair in zip(parts[0], other, strict=True)):
        return None
    i, j, x = parts[0]
    return sparse.csr_array((x, (i, j)), shape=(n, int(j.max(initial=-1)) + 1))
