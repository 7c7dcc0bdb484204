"""From entries in all coordinates to entries in the independent ones: K_u = T^T K T as a list of contributions."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
from scipy import sparse

from lamella.assembly.pattern_kernels import plain_entries
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

    A symmetric block lists each pair once, so its off-diagonal entries are mirrored first. When only its upper triangle is
    wanted, nearly all entries of a large mesh stand for one place (:func:`_plain`).

    Args:
        rows, cols: global coordinates of the entries, -1 for padding, shape (n_k,).
        scale: factor of each entry, shape (n_k,).
        symmetry: how the block lists its entries.
        upper: keep the upper triangle only, of a symmetric block.
        T: map from independent to all coordinates, (n_q, n_u).
    """
    if symmetry == "symmetric" and upper:
        first, sources = _plain(rows, cols, scale, T)
        return _joined(first, _general(rows, cols, scale, sources, symmetry, upper, T)) if len(sources) else first
    counts = np.diff(T.indptr)
    sources = np.flatnonzero((rows >= 0) & (cols >= 0) & (counts[rows] > 0) & (counts[cols] > 0))
    return _general(rows, cols, scale, sources, symmetry, upper, T)


def _plain(rows: Ints, cols: Ints, scale: Floats, T: sparse.csr_array) -> tuple[Entries, Ints]:
    """Entries whose two coordinates each follow one independent coordinate, and which entries are others."""
    u, v, sources, others = (np.empty(len(rows), np.int64) for _ in range(4))
    x = np.empty(len(rows))
    map_of = T.indptr.astype(np.int64), T.indices.astype(np.int64), T.data.astype(float)
    n, m = plain_entries(rows, cols, scale, *map_of, u, v, sources, x, others)
    return Entries(u[:n], v[:n], sources[:n], x[:n]), others[:m]


def _joined(one: Entries, other: Entries) -> Entries:
    return Entries(*(np.concatenate([getattr(e, part.name) for e in (one, other)]) for part in fields(Entries)))


def _general(
    rows: Ints, cols: Ints, scale: Floats, sources: Ints, symmetry: Symmetry, upper: bool, T: sparse.csr_array
) -> Entries:
    """As :func:`expand_matrix` for the buffer entries ``sources``."""
    i, j, x = rows[sources], cols[sources], scale[sources]
    if symmetry == "symmetric":
        off = i != j
        i, j = np.concatenate([i, j[off]]), np.concatenate([j, i[off]])
        sources, x = np.concatenate([sources, sources[off]]), np.concatenate([x, x[off]])
    i, pick, x = through(i, x, T)
    j, sources = j[pick], sources[pick]
    j, pick, x = through(j, x, T)
    i, sources = i[pick], sources[pick]
    if upper:
        keep = i <= j
        i, j, sources, x = i[keep], j[keep], sources[keep], x[keep]
    return Entries(i, j, sources, x)


def expand_rows(rows: Ints, cols: Ints, T: sparse.csr_array) -> Entries:
    """Contributions of constraint Jacobian entries to Phi_q T."""
    j, pick, x = through(cols, np.ones(len(cols)), T)
    return Entries(rows[pick], j, pick, x)


def through(coords: Ints, factors: Floats, T: sparse.csr_array) -> tuple[Ints, Ints, Floats]:
    """Replace each coordinate by the independent ones it depends on.

    Returns:
        independent coordinates, which of the given entries each came from, and their factors.
    """
    counts = np.diff(T.indptr)[coords]
    pick = np.repeat(np.arange(len(coords)), counts)
    offset = np.arange(len(pick)) - np.repeat(np.cumsum(counts) - counts, counts)
    place = T.indptr[coords][pick] + offset
    return T.indices[place].astype(np.int64), pick, factors[pick] * T.data[place]
