"""Products of the blocks' tangents with vectors, in all coordinates, without a matrix."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lamella._jit import kernel
from lamella.assembly.constraints import ConstraintStack
from lamella.assembly.forces import ForceSum
from lamella.assembly.matrix import MatrixAssembly
from lamella.assembly.point import Point, Weights
from lamella.model import Model
from lamella.roles import Floats, ForceBlock, Ints

Unsigned = NDArray[np.uint32]


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
    """N x with the skew part N of the matrix that an assembly, which keeps the symmetric part alone, has evaluated last.

    Args:
        assembly: of the matrix.
    """

    def __init__(self, assembly: MatrixAssembly) -> None:
        self._assembly, pattern = assembly, assembly.pattern
        # Without sign, so that Numba does not look for negative ones: twice as fast.
        self._indptr, self._indices = pattern.indptr.astype(np.uint32), pattern.indices.astype(np.uint32)

    def look(self) -> None:
        """Take the tangents that are in the buffers now."""
        self._values = self._assembly.skew()

    def __call__(self, x: Floats) -> Floats:
        """The product with a vector, shape (n,)."""
        total = np.zeros_like(x)
        _add_skew_product(self._indptr, self._indices, self._values, x, total)
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
def _add_skew_product(indptr: Unsigned, indices: Unsigned, values: Floats, x: Floats, total: Floats) -> None:
    for i in range(len(x)):
        row, own = 0.0, x[i]
        for k in range(indptr[i] + 1, indptr[i + 1]):  # behind the diagonal
            j = indices[k]
            row += values[k] * x[j]
            total[j] -= values[k] * own
        total[i] += row
