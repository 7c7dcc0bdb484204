"""All constraints with Lagrange multipliers, stacked, in all coordinates."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from scipy import sparse

from lamella._jit import njit
from lamella.roles import Bools, ConstraintBlock, Floats, Ints


class ConstraintStack:
    """Phi(t, q) of some blocks, one below the other; rows that repeat others may be left out.

    Args:
        blocks: the blocks.
    """

    def __init__(self, blocks: Sequence[ConstraintBlock]) -> None:
        self.n_all = sum(block.n_lam for block in blocks)
        self.blocks = [(block, slice(block.first, block.first + block.n_lam)) for block in blocks if block.n_lam]
        self.moves = any(block.moves for block, _ in self.blocks)
        self._entries = [(block, part, np.empty(len(block.j_rows))) for block, part in self.blocks]
        self.kept: Ints = np.arange(self.n_all)

    @property
    def n_lam(self) -> int:
        """Number of rows kept."""
        return len(self.kept)

    def full(self, lam: Floats) -> Floats:
        """Multipliers of all rows from those of the rows kept; the others carry nothing, shape (n_all,)."""
        if len(self.kept) == self.n_all:
            return lam
        every = np.zeros(self.n_all)
        every[self.kept] = lam
        return every

    @property
    def labels(self) -> list[str]:
        """What each row holds, in words."""
        return [label for block, _ in self.blocks for label in block.labels]

    @property
    def of_bodies(self) -> Bools:
        """True for rows by which a body holds itself together, shape (n_all,)."""
        return np.array([block.body for block, _ in self.blocks for _ in range(block.n_lam)], dtype=bool)

    def prescribed(self, t: float) -> Floats:
        """Prescribed values of all rows, shape (n_all,)."""
        return np.concatenate([np.zeros(0), *(block.prescribed(t) for block, _ in self.blocks)])

    def phi(self, t: float, q: Floats) -> Floats:
        """Phi, shape (n_lam,)."""
        every = self.phi_of_all(t, q)
        return every if len(every) == self.n_lam else every[self.kept]

    def phi_of_all(self, t: float, q: Floats) -> Floats:
        """Phi of all rows, shape (n_all,)."""
        out = np.zeros(self.n_all)
        for block, part in self.blocks:
            block.phi(t, q, out[part])
        return out

    def rate_of_all(self, t: float, q: Floats, v: Floats) -> Floats:
        """Phi_q v + Phi_t of all rows, shape (n_all,)."""
        return self._times(t, q, v) + self._phi_t(t, q)

    def matrix(self, t: float, q: Floats) -> sparse.csr_array:
        """Phi_q of all rows, shape (n_all, n_q)."""
        found = [(part.start + block.j_rows, block.j_cols, values) for block, part, values in self._jacobians(t, q)]
        if not found:
            return sparse.csr_array((self.n_all, len(q)))
        rows, cols, values = (np.concatenate(arrays) for arrays in zip(*found, strict=True))
        return sparse.csr_array(sparse.coo_array((values, (rows, cols)), shape=(self.n_all, len(q))))

    def phi_t(self, t: float, q: Floats) -> Floats:
        """Partial derivative by time, shape (n_lam,)."""
        return self._phi_t(t, q)[self.kept]

    def gamma(self, t: float, q: Floats, v: Floats) -> Floats:
        """(Phi_q v)_q v + 2 Phi_qt v + Phi_tt, shape (n_lam,)."""
        out = np.zeros(self.n_all)
        for block, part in self.blocks:
            block.gamma(t, q, v, out[part])
        return out[self.kept]

    def times(self, t: float, q: Floats, x: Floats) -> Floats:
        """Phi_q x, shape (n_lam,)."""
        return self._times(t, q, x)[self.kept]

    def add_force(self, t: float, q: Floats, lam: Floats, total: Floats) -> None:
        """Add Phi_q^T lam to ``total`` (n_q,)."""
        every = self.full(lam)
        for block, part, values in self._jacobians(t, q):
            _add_products(block.j_cols, values, every[part], block.j_rows, total)

    def _phi_t(self, t: float, q: Floats) -> Floats:
        out = np.zeros(self.n_all)
        for block, part in self.blocks:
            block.phi_t(t, q, out[part])
        return out

    def _times(self, t: float, q: Floats, x: Floats) -> Floats:
        out = np.zeros(self.n_all)
        for block, part, values in self._jacobians(t, q):
            _add_products(block.j_rows, values, x, block.j_cols, out[part])
        return out

    def _jacobians(self, t: float, q: Floats) -> Iterator[tuple[ConstraintBlock, slice, Floats]]:
        """Each block with its rows and the entries of its Phi_q, which the next call overwrites."""
        for block, part, values in self._entries:
            block.jacobian(t, q, values)
            yield block, part, values


@njit
def _add_products(targets: Ints, values: Floats, x: Floats, sources: Ints, out: Floats) -> None:
    """out[targets] += values x[sources], repeated targets each time."""
    for i in range(len(targets)):
        out[targets[i]] += values[i] * x[sources[i]]
