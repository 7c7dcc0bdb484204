"""The saddle-point matrix of a Newton iteration as one sparse matrix, equilibrated."""

from __future__ import annotations

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import splu

from lamella._jit import njit
from lamella.assembly.pattern import Pattern
from lamella.roles import Floats, Ints

SWEEPS = 4
"""Sweeps of equilibration; each halves the orders of magnitude by which the largest entries differ from 1."""


class SaddleMatrix:
    """A = [[K, J^T], [J, 0]] in compressed columns, scaled to S A S with entries of about 1.

    The rows of a twist r_xy are many orders of magnitude smaller than those of a position r, and those of a constraint smaller
    than those of a stiffness; unscaled, pivot thresholds compare numbers of different units. A few sweeps

        s_i <- s_i / sqrt(max_j |s_i A_ij s_j|)

    bring the largest entry of every row near 1, whatever K and J hold: coordinates without mass and stiffness, which constraints
    alone determine, are scaled by these.

    Source: D. Ruiz, A scaling algorithm to equilibrate both rows and columns norms in matrices, RAL-TR-2001-034.

    Args:
        pattern: sparsity pattern of K and J.
        order: coordinate or multiplier at each position, shape (n + n_lam,); given order when None.
    """

    def __init__(self, pattern: Pattern, order: Ints | None = None) -> None:
        n = pattern.n
        self.pattern, self.size = pattern, n + pattern.n_lam
        self.order = np.arange(self.size) if order is None else np.asarray(order, np.int64)
        kr, kc = pattern.rows, np.asarray(pattern.indices, np.int64)
        jr, jc = pattern.j_rows + n, np.asarray(pattern.j_indices, np.int64)
        k_source, j_source = np.arange(len(kr)), len(kr) + np.arange(len(jr))
        mirrored = np.flatnonzero(kr != kc) if pattern.symmetric else np.zeros(0, np.int64)
        rows = np.concatenate([kr, kc[mirrored], jr, jc])
        cols = np.concatenate([kc, kr[mirrored], jc, jr])
        source = np.concatenate([k_source, mirrored, j_source, j_source])
        position = np.argsort(self.order)
        rows, cols = position[rows], position[cols]
        stored = np.lexsort((rows, cols))
        self._source, self._rows, self._cols = source[stored], rows[stored], cols[stored]
        indptr = np.searchsorted(self._cols, np.arange(self.size + 1))
        data = np.zeros(len(stored))
        self.matrix = sparse.csc_array((data, self._rows.astype(np.intc), indptr.astype(np.intc)), shape=(self.size, self.size))
        self._data: Floats = self.matrix.data  # pyright: ignore[reportAttributeAccessIssue]
        self.scale = np.ones(self.size)

    def fill(self, k: Floats, j: Floats) -> None:
        """Set the values of K and J, in the order of the pattern, and equilibrate."""
        values = np.concatenate([k, j])
        _equilibrate(values, self._source, self._rows, self._cols, SWEEPS, self.scale, self._data)

    def scaled(self, r: Floats, s: Floats) -> Floats:
        """Right-hand side of the equilibrated, ordered system, shape (n + n_lam,)."""
        return np.concatenate([r, s])[self.order] * self.scale

    def unscaled(self, z: Floats) -> tuple[Floats, Floats]:
        """Coordinates (n,) and multipliers (n_lam,) from the solution of the equilibrated system."""
        x = np.empty(self.size)
        x[self.order] = z * self.scale
        return x[: self.pattern.n], x[self.pattern.n :]

    def free_index(self) -> int:
        """Coordinate or multiplier with the largest component in the null vector of the equilibrated matrix.

        The null vector is the limit of inverse iteration with a slightly shifted matrix.
        """
        shifted = (self.matrix + 1e-9 * sparse.eye_array(self.size)).tocsc()
        lu, z = splu(shifted), probe(self.size)
        for _ in range(3):
            z = lu.solve(z)
            z /= np.abs(z).max()
        return int(self.order[np.argmax(np.abs(z))])


@njit
def _equilibrate(values: Floats, source: Ints, rows: Ints, cols: Ints, sweeps: int, scale: Floats, data: Floats) -> None:
    """Scale of each row and column, and the scaled entries, in the order of ``rows`` and ``cols``."""
    n = len(scale)
    largest = np.empty(n)
    scale[:] = 1.0
    for _ in range(sweeps):
        largest[:] = 0.0
        for i in range(len(rows)):
            size = abs(values[source[i]]) * scale[rows[i]] * scale[cols[i]]
            largest[rows[i]] = max(largest[rows[i]], size)
            largest[cols[i]] = max(largest[cols[i]], size)
        for i in range(n):
            if largest[i] > 0.0:
                scale[i] /= np.sqrt(largest[i])
    for i in range(len(rows)):
        data[i] = values[source[i]] * scale[rows[i]] * scale[cols[i]]


def probe(size: int) -> Floats:
    """A fixed vector of signs without structure, so that it has a part along any null vector, shape (size,)."""
    return np.where(np.random.default_rng(7).random(size) < 0.5, -1.0, 1.0)
