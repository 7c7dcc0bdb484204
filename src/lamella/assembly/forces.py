"""The sum of all force blocks, in all coordinates or in the independent ones."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Any, Generic, TypeVar

import numpy as np
from scipy import sparse

from lamella.assembly.expand import through
from lamella.assembly.operator import SumOperator
from lamella.assembly.point import Weights
from lamella.roles import Floats, Force, ForceBlock, Ints

Block = TypeVar("Block", bound=Force)


class ForceSum(Generic[Block]):
    """f(t, q, v) of some blocks: each writes a part of one buffer, which is summed at once, with weights if there are any.

    Blocks that depend on time alone are evaluated once for each time, and when all do, so are their sums.

    Args:
        blocks: the blocks.
        n_q: number of coordinates.
        T: map from independent to all coordinates, (n_q, n_u); the identity when left out.
        like: the sum of other blocks with the same ``T``; where these have their buffers' entries at the same places, its
            operators serve here as well.
        weights: of each block in the sum, one of all when left out.
    """

    def __init__(
        self,
        blocks: Sequence[Block],
        n_q: int,
        T: sparse.csr_array | None = None,
        like: ForceSum[Any] | None = None,
        weights: Sequence[float] | None = None,
    ) -> None:
        ends = np.cumsum([len(block.f_coords) for block in blocks], dtype=np.int64)
        self.buffer = np.zeros(int(ends[-1]) if blocks else 0)
        self.parts = [(block, self.buffer[end - len(block.f_coords) : end]) for block, end in zip(blocks, ends, strict=True)]
        self._changing = [(block, part) for block, part in self.parts if not block.depends_on_time_alone]
        self._t = np.nan
        self._in_all: Floats | None = None
        self._in_independent: Floats | None = None
        self.onto_what, self._like = (n_q, T), like
        """Number of coordinates, and the map from independent ones, if there is one."""
        self._shares = [1.0] * len(blocks) if weights is None else weights

    @cached_property
    def _form(self) -> tuple[Ints, Floats]:
        """Coordinate and factor of each entry of the buffer."""
        blocks = [block for block, _ in self.parts]
        coords = np.concatenate([np.zeros(0, np.int64), *(block.f_coords for block in blocks)])
        factors = np.concatenate([np.zeros(0), *(w * block.f_scale for w, block in zip(self._shares, blocks, strict=True))])
        return coords, factors

    @cached_property
    def _operators(self) -> tuple[SumOperator, SumOperator]:
        """The sums in all coordinates and in the independent ones; made when first asked for, as some never are."""
        if self._like is not None and all(map(np.array_equal, self._form, self._like._form)):
            return self._like._operators
        (coords, factors), (n_q, T) = self._form, self.onto_what
        used = np.flatnonzero(coords >= 0)
        in_all = SumOperator(coords[used], used, factors[used], n_q)
        if T is None:
            return in_all, in_all
        independent, pick, shares = through(coords[used], factors[used], T)
        n_u = int(T.indices.max(initial=-1)) + 1  # each independent coordinate is one of all, so the last has an entry
        return in_all, SumOperator(independent, used[pick], shares, n_u)

    @property
    def reduction(self) -> SumOperator:
        """T^T times the sum, as a product with the buffer."""
        return self._operators[1]

    def evaluate(self, t: float, q: Floats, v: Floats) -> None:
        """Let all blocks write their parts of the buffer."""
        changing = self._changing if t == self._t else self.parts
        if changing:
            for block, part in changing:
                block.force(t, q, v, part)
            self._filled(t)

    def linearise(
        self: ForceSum[ForceBlock],
        t: float,
        q: Floats,
        v: Floats,
        weights: Weights,
        previous: Floats,
        tangents: Sequence[Floats],
    ) -> None:
        """Let all blocks write their parts of the buffer, and alpha_q K + alpha_v D to their buffers in ``tangents``.

        Args:
            t, q, v: where.
            weights: how the unknown moves coordinates and velocities.
            previous: coordinates of Newton's previous iterate; see :class:`lamella.roles.ForceBlock`.
            tangents: a buffer for each block.
        """
        for (block, part), k in zip(self.parts, tangents, strict=True):
            alpha_v = weights.rate if block.first_order else weights.alpha_v
            block.force_tangent(t, q, v, weights.alpha_q, alpha_v, previous, part, k)
        self._filled(t)

    def damping(self: ForceSum[ForceBlock], t: float, q: Floats, v: Floats) -> Floats:
        """f(t, q, v) - f(t, q, 0), shape (n_q,)."""
        for block, part in self.parts:
            block.damping_force(t, q, v, part)
        self.forget()
        return self._operators[0](self.buffer)

    def forget(self) -> None:
        """Evaluate everything anew, also at the same time: an input has changed."""
        self._t = np.nan

    def _filled(self, t: float) -> None:
        self._t, self._in_all, self._in_independent = t, None, None

    def __call__(self, t: float, q: Floats, v: Floats) -> Floats:
        """Evaluate all blocks, shape (n_q,)."""
        self.evaluate(t, q, v)
        return self.summed()

    def summed(self) -> Floats:
        """The sum of what the buffer holds now, shape (n_q,); not to be written to."""
        if self._in_all is None:
            self._in_all = self._operators[0](self.buffer)
        return self._in_all

    def written(self) -> None:
        """Take note that others have written to the buffer."""
        self._filled(np.nan)

    def reduced(self) -> Floats:
        """T^T times the sum of what the buffer holds now, shape (n_u,); not to be written to."""
        if self._in_independent is None:
            self._in_independent = self._operators[1](self.buffer)
        return self._in_independent

    def onto(self, r: Floats) -> Floats:
        """Add T^T times the sum of what the buffer holds now to ``r`` (n_u,) and return it; the sum is not kept."""
        return self._operators[1].onto(self.buffer, r)

    def onto_all(self, f: Floats) -> Floats:
        """Add the sum of what the buffer holds now to ``f`` (n_q,) and return it; the sum is not kept."""
        return self._operators[0].onto(self.buffer, f)
