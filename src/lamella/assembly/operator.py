"""The assembly operator: one sparse map from the blocks' buffers to the values of a vector or matrix."""

from __future__ import annotations

import numpy as np
from scipy import sparse

from lamella._jit import njit
from lamella.roles import Floats, Ints


class SumOperator:
    """out = E buffer, where row i of E lists the buffer entries that are summed into out[i], with their factors.

    Args:
        targets: place in the output of each contribution, shape (n,).
        sources: place in the buffer of each contribution, shape (n,).
        factors: factor of each contribution, shape (n,).
        n_targets: length of the output.
        n_sources: length of the buffer.
    """

    def __init__(self, targets: Ints, sources: Ints, factors: Floats, n_targets: int, n_sources: int) -> None:
        matrix = sparse.csr_array(sparse.coo_array((factors, (targets, sources)), shape=(n_targets, n_sources)))
        self.starts = matrix.indptr.astype(np.int32)
        self.sources = matrix.indices.astype(np.int32)
        self.factors = matrix.data.astype(float)
        self.out = np.zeros(n_targets)

    def __call__(self, buffer: Floats) -> Floats:
        """The sums; the array is overwritten by the next call."""
        _sum(self.starts, self.sources, self.factors, buffer, self.out)
        return self.out


@njit
def _sum(starts: Ints, sources: Ints, factors: Floats, buffer: Floats, out: Floats) -> None:  # pragma: no cover - compiled
    for i in range(len(starts) - 1):
        total = 0.0
        for k in range(starts[i], starts[i + 1]):
            total += factors[k] * buffer[sources[k]]
        out[i] = total
