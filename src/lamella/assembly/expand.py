"""From entries in all coordinates to entries in the independent ones: K_u = T^T K T as a list of contributions."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from lamella.roles import Floats, Ints, Symmetry


@dataclass(frozen=True)
class Entries:
    """Contributions of buffer entries to matrix places (row, col) in the independent coordinates.

    Args:
        rows, cols: place, shape (n,).
        sources: buffer entry, shape (n,).
        factors: factor, shape (n,).
    """

    rows: Ints
    cols: Ints
    sources: Ints
    factors: Floats


def expand_matrix(rows: Ints, cols: Ints, scale: Floats, symmetry: Symmetry, upper: bool, T: sparse.csr_array) -> Entries:
    """Contributions of a block's tangent entries to K_u.

    A symmetric block lists each pair once, so its off-diagonal entries are mirrored first. When only the upper triangle is
    wanted, the others give their symmetric part.

    Args:
        rows, cols: global coordinates of the entries, -1 for padding, shape (n_k,).
        scale: factor of each entry, shape (n_k,).
        symmetry: how the block lists its entries.
        upper: keep the upper triangle only.
        T: map from independent to all coordinates, (n_q, n_u).
    """
    sources = np.flatnonzero((rows >= 0) & (cols >= 0))
    i, j, x = rows[sources], cols[sources], scale[sources]
    if symmetry == "symmetric":
        off = i != j
        i, j = np.concatenate([i, j[off]]), np.concatenate([j, i[off]])
        sources, x = np.concatenate([sources, sources[off]]), np.concatenate([x, x[off]])
    elif upper:
        i, j, sources, x = np.concatenate([i, j]), np.concatenate([j, i]), np.tile(sources, 2), np.tile(0.5 * x, 2)
    i, pick, x = _through(i, x, T)
    j, sources = j[pick], sources[pick]
    j, pick, x = _through(j, x, T)
    i, sources = i[pick], sources[pick]
    if upper:
        keep = i <= j
        i, j, sources, x = i[keep], j[keep], sources[keep], x[keep]
    return Entries(i, j, sources, x)


def expand_rows(rows: Ints, cols: Ints, T: sparse.csr_array) -> Entries:
    """Contributions of constraint Jacobian entries to Phi_q T."""
    j, pick, x = _through(cols, np.ones(len(cols)), T)
    return Entries(rows[pick], j, pick, x)


def _through(coords: Ints, factors: Floats, T: sparse.csr_array) -> tuple[Ints, Ints, Floats]:
    """Replace each coordinate by the independent ones it depends on.

    Returns:
        independent coordinates, which of the given entries each came from, and their factors.
    """
    counts = np.diff(T.indptr)[coords]
    pick = np.repeat(np.arange(len(coords)), counts)
    offset = np.arange(len(pick)) - np.repeat(np.cumsum(counts) - counts, counts)
    place = T.indptr[coords][pick] + offset
    return T.indices[place].astype(np.int64), pick, factors[pick] * T.data[place]
