"""All constraints with Lagrange multipliers, stacked, in all coordinates."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from lamella.roles import ConstraintBlock, Floats


class ConstraintStack:
    """Phi(t, q) of some blocks, one below the other.

    Args:
        blocks: the blocks.
    """

    def __init__(self, blocks: Sequence[ConstraintBlock]) -> None:
        ends = np.cumsum([block.n_lam for block in blocks], dtype=np.int64)
        self.n_lam = int(ends[-1]) if blocks else 0
        self.blocks = [(block, slice(int(end) - block.n_lam, int(end))) for block, end in zip(blocks, ends, strict=True)]

    def phi(self, t: float, q: Floats) -> Floats:
        """Phi, shape (n_lam,)."""
        out = np.zeros(self.n_lam)
        for block, part in self.blocks:
            block.phi(t, q, out[part])
        return out

    def phi_t(self, t: float, q: Floats) -> Floats:
        """Partial derivative by time, shape (n_lam,)."""
        out = np.zeros(self.n_lam)
        for block, part in self.blocks:
            block.phi_t(t, q, out[part])
        return out

    def gamma(self, t: float, q: Floats, v: Floats) -> Floats:
        """(Phi_q v)_q v + 2 Phi_qt v + Phi_tt, shape (n_lam,)."""
        out = np.zeros(self.n_lam)
        for block, part in self.blocks:
            block.gamma(t, q, v, out[part])
        return out

    def times(self, t: float, q: Floats, x: Floats) -> Floats:
        """Phi_q x, shape (n_lam,)."""
        out = np.zeros(self.n_lam)
        for block, part, values in self._jacobians(t, q):
            np.add.at(out[part], block.j_rows, values * x[block.j_cols])
        return out

    def add_force(self, t: float, q: Floats, lam: Floats, total: Floats) -> None:
        """Add Phi_q^T lam to ``total`` (n_q,)."""
        for block, part, values in self._jacobians(t, q):
            np.add.at(total, block.j_cols, values * lam[part][block.j_rows])

    def _jacobians(self, t: float, q: Floats) -> Iterator[tuple[ConstraintBlock, slice, Floats]]:
        for block, part in self.blocks:
            values = np.empty(len(block.j_rows))
            block.jacobian(t, q, values)
            yield block, part, values
