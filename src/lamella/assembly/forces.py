"""The sum of all force blocks in all coordinates."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from lamella.assembly.operator import SumOperator
from lamella.roles import Floats, ForceBlock


class ForceSum:
    """f(t, q, v) of some blocks: each writes a part of one buffer, which is summed at once.

    Args:
        blocks: the blocks.
        n_q: number of coordinates.
    """

    def __init__(self, blocks: Sequence[ForceBlock], n_q: int) -> None:
        ends = np.cumsum([len(block.f_coords) for block in blocks], dtype=np.int64)
        self.buffer = np.zeros(int(ends[-1]) if blocks else 0)
        self.parts = [(block, self.buffer[end - len(block.f_coords) : end]) for block, end in zip(blocks, ends, strict=True)]
        coords = np.concatenate([np.zeros(0, np.int64), *(block.f_coords for block in blocks)])
        factors = np.concatenate([np.zeros(0), *(block.f_scale for block in blocks)])
        used = np.flatnonzero(coords >= 0)
        self._sum = SumOperator.of(coords[used], used, factors[used], n_q, len(self.buffer))

    def __call__(self, t: float, q: Floats, v: Floats) -> Floats:
        """Evaluate all blocks, shape (n_q,)."""
        for block, part in self.parts:
            block.force(t, q, v, part)
        return self.summed()

    def summed(self) -> Floats:
        """The sum of what the buffer holds now, shape (n_q,)."""
        return self._sum(self.buffer)
