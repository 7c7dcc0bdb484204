"""The constant mass matrix M = m x 1_3 of coordinates that are vectors, from the blocks of a model."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from scipy import sparse

from lamella.roles import Floats, InertiaBlock, Ints


def vector_mass(blocks: Iterable[InertiaBlock], n_vectors: int) -> sparse.csr_array:
    """The matrix m of some blocks, sparse (n_vectors, n_vectors)."""
    nothing = np.zeros(0, np.int64), np.zeros(0, np.int64), np.zeros(0)
    i, j, m = (np.concatenate(part) for part in zip(nothing, *(block.mass() for block in blocks), strict=True))
    return sparse.csr_array(sparse.coo_array((m, (i, j)), shape=(n_vectors, n_vectors)))


def of_components(i: Ints, j: Ints, m: Floats) -> tuple[Ints, Ints, Floats]:
    """Rows, columns and values in M of entries of m, shapes (3 n,)."""
    axes = np.arange(3)
    return (3 * i[:, None] + axes).reshape(-1), (3 * j[:, None] + axes).reshape(-1), np.repeat(m, 3)


def whole_mass(m: sparse.csr_array, n_q: int) -> sparse.csr_array:
    """M from m, sparse (n_q, n_q); coordinates behind the vectors, those of scalar fields, have no mass."""
    entries = m.tocoo()
    rows, columns, values = of_components(entries.row.astype(np.int64), entries.col.astype(np.int64), entries.data.astype(float))
    return sparse.csr_array(sparse.coo_array((values, (rows, columns)), shape=(n_q, n_q)))
