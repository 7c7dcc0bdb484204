"""The assembly operator: one sparse map from the blocks' buffers to the values of a vector or matrix."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from lamella._jit import njit
from lamella.roles import Floats, Ints

Indices = NDArray[np.int32]


class SumOperator:
    """y = E x, where row i of E lists the entries of x that are summed into y[i], with their factors.

    SciPy's product costs several microseconds of checks at each call, as much as the sums themselves on small models.

    Args:
        matrix: E, sparse (n_targets, n_sources).
    """

    def __init__(self, matrix: sparse.sparray) -> None:
        rows = sparse.csr_array(matrix)
        self.n = len(rows.indptr) - 1
        self.starts: Indices = rows.indptr.astype(np.int32)
        self.sources: Indices = rows.indices.astype(np.int32)
        self.factors = rows.data.astype(float)

    @classmethod
    def of(cls, targets: Ints, sources: Ints, factors: Floats, n_targets: int, n_sources: int) -> SumOperator:
        """From a list of contributions, each with its place in y, its place in x, and its factor, shapes (n,)."""
        return cls(sparse.coo_array((factors, (targets, sources)), shape=(n_targets, n_sources)))

    def __call__(self, x: Floats) -> Floats:
        """The sums in a new array, shape (n_targets,)."""
        return self.into(x, np.empty(self.n))

    def into(self, x: Floats, out: Floats) -> Floats:
        """Overwrite ``out`` with the sums and return it."""
        _sum(self.starts, self.sources, self.factors, x, out)
        return out


@njit
def _sum(starts: Indices, sources: Indices, factors: Floats, x: Floats, out: Floats) -> None:  # pragma: no cover - compiled
    for i in range(len(starts) - 1):
        total = 0.0
        for k in range(starts[i], starts[i + 1]):
            total += factors[k] * x[sources[k]]
        out[i] = total
