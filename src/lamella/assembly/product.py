"""Products of the blocks' tangents with vectors, in all coordinates, without a matrix."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from lamella._jit import kernel
from lamella.assembly.constraints import ConstraintStack
from lamella.assembly.forces import ForceSum
from lamella.assembly.point import Point, Weights
from lamella.model import Model
from lamella.roles import Floats, ForceBlock, Ints


class TangentProduct:
    """(alpha_q K + alpha_v D) x at one point, entry by entry of the blocks' tangent buffers.

    A matrix in all coordinates would have to be laid out first, which costs as much as some hundred products.

    Args:
        model: the compiled model.
        forces, loads: the force buffers, which are filled on the way.
        constraints: the constraints, with the rows that are kept.
        point: where.
        q, v: its coordinates and velocities.
        weights: how the unknown moves coordinates and velocities.
    """

    def __init__(
        self,
        model: Model,
        forces: ForceSum,
        loads: ForceSum,
        constraints: ConstraintStack,
        point: Point,
        q: Floats,
        v: Floats,
        weights: Weights,
    ) -> None:
        self._parts: list[tuple[Ints, Ints, Floats, bool]] = []
        for total, factor in ((forces, 1.0), (loads, point.factor)):
            tangents = [np.zeros(len(block.k_rows)) for block, _ in total.parts]
            total.linearise(point.t, q, v, weights, q, tangents)
            for (block, _), k in zip(total.parts, tangents, strict=True):
                k *= factor * block.k_scale
                _clear_unused(block, k)
                self._parts.append((block.k_rows, block.k_cols, k, block.symmetry == "symmetric"))
        lam = constraints.full(point.lam)
        for block in model.constraints:
            k = np.zeros(len(block.k_rows))
            block.curvature(point.t, q, lam[block.first : block.first + block.n_lam], k)
            self._parts.append((block.k_rows, block.k_cols, weights.alpha_q * k, True))

    def __call__(self, x: Floats) -> Floats:
        """The product with a vector in all coordinates, shape (n_q,)."""
        total = np.zeros_like(x)
        for rows, cols, values, mirrored in self._parts:
            _add_product(rows, cols, values, mirrored, x, total)
        return total


class SkewProduct:
    """1/2 (A - A^T) x with the tangents in the buffers of an assembly, which leaves this out of its symmetric matrix.

    Args:
        blocks: all force blocks of the assembly, in its order.
        parts: their tangent buffers, behind which those of constraints may follow.
    """

    def __init__(self, blocks: Sequence[ForceBlock], parts: Sequence[Floats]) -> None:
        self._parts = [pair for pair in zip(blocks, parts, strict=False) if pair[0].symmetry != "symmetric"]

    def __call__(self, x: Floats) -> Floats:
        """The product with a vector in all coordinates, shape (n_q,)."""
        total = np.zeros_like(x)
        for block, k in self._parts:
            _clear_unused(block, k)
            _add_skew_product(block.k_rows, block.k_cols, block.k_scale, k, x, total)
        return total


def _clear_unused(block: ForceBlock, k: Floats) -> None:
    """What a block has not written counts as zero."""
    if block.k_parts is not None:
        for part in np.flatnonzero(~block.k_used):
            k[block.k_parts[part] : block.k_parts[part + 1]] = 0.0


@kernel
def _add_product(rows: Ints, cols: Ints, values: Floats, mirrored: bool, x: Floats, total: Floats) -> None:
    """A symmetric block lists each pair once."""
    for i in range(len(values)):
        row, col = rows[i], cols[i]
        if row >= 0 and col >= 0:
            total[row] += values[i] * x[col]
            if mirrored and row != col:
                total[col] += values[i] * x[row]


@kernel
def _add_skew_product(rows: Ints, cols: Ints, scale: Floats, values: Floats, x: Floats, total: Floats) -> None:
    for i in range(len(values)):
        row, col = rows[i], cols[i]
        if row >= 0 and col >= 0 and row != col:
            half = 0.5 * scale[i] * values[i]
            total[row] += half * x[col]
            total[col] -= half * x[row]
