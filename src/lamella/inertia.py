"""The constant mass matrix M = m x 1_3 of coordinates that are vectors, from the blocks of a model."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from math import fsum

import numpy as np
from scipy import sparse

from lamella.roles import Floats, InertiaBlock, Ints


def vector_mass(blocks: Iterable[InertiaBlock], n_vectors: int) -> sparse.csr_array:
    """The matrix m of some blocks, sparse (n_vectors, n_vectors)."""
    return _matrix(_entries(blocks), n_vectors)


def differenced(models: Sequence[Sequence[InertiaBlock]], weights: Sequence[float], n_vectors: int) -> sparse.csr_array:
    """sum w m of several models, as :func:`vector_mass` gives m; nothing of what is equal in all where the weights cancel."""
    entries = [_entries(blocks) for blocks in models]
    (i, j, of_first), *others = entries
    if all(np.array_equal(i, other[0]) and np.array_equal(j, other[1]) for other in others):
        total = fsum(weights) * of_first + np.tensordot(weights[1:], [m - of_first for _, _, m in others], 1)
        return _matrix((i, j, total), n_vectors)
    first, *more = (w * _matrix(each, n_vectors) for w, each in zip(weights, entries, strict=True))
    return sparse.csr_array(sum(more, start=first))


def _entries(blocks: Iterable[InertiaBlock]) -> tuple[Ints, Ints, Floats]:
    nothing = np.zeros(0, np.int64), np.zeros(0, np.int64), np.zeros(0)
    first, *others = [block.mass() for block in blocks] or [nothing]
    if not others:
        return first
    i, j, m = (np.concatenate(part) for part in zip(first, *others, strict=True))
    return i, j, m


def _matrix(entries: tuple[Ints, Ints, Floats], n_vectors: int) -> sparse.csr_array:
    i, j, m = entries
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
