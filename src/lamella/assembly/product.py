"""Products of the blocks' tangents with vectors, in all coordinates, without a matrix."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import chain

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from lamella._jit import kernel
from lamella.assembly.constraints import ConstraintStack
from lamella.assembly.forces import ForceSum
from lamella.assembly.matrix import MatrixAssembly
from lamella.assembly.operator import SumOperator, VectorOperator, negative_sum
from lamella.assembly.point import Point, Weights
from lamella.lane import WIDTH, load_at, number_at, spread, store_at, total
from lamella.roles import ConstraintBlock, Floats, ForceBlock, ForceChange, Ints, MatrixFreeBlock, TangentOperator

Unsigned = NDArray[np.uint32]

LISTED, FOR_EACH = 4096, 32
"""Entries of tangents that are multiplied one by one, at a nanosecond each: so many in any case, or for each coordinate of the
elements that multiply, of which each takes 16 ns. A heated plate has 17, and its matrix takes as long as ten such products."""


def matrix_free(forces: Sequence[ForceBlock], loads: Sequence[ForceBlock]) -> list[ForceBlock] | None:
    """The force blocks in forms that multiply their tangents; None where others, and loads, have too many entries beside them."""
    found = [block.symmetric_form or block for block in forces]
    blocks = [*found, *loads]
    listed = sum(len(block.k_rows) for block in blocks if not isinstance(block, MatrixFreeBlock))
    multiplied = sum(len(block.f_coords) for block in blocks if isinstance(block, MatrixFreeBlock))
    return found if listed <= max(LISTED, FOR_EACH * multiplied) else None


class Ahead:
    """Operators that have looked at a point on the way of an evaluation there.

    Args:
        point, weights: where.
        of_blocks: the operators that may, by their blocks.
    """

    def __init__(
        self, point: Point | None, weights: Weights | None, of_blocks: Mapping[int, TangentOperator] | None = None
    ) -> None:
        self.point, self.weights, self._of_blocks = point, weights, of_blocks or {}
        self.operators: list[TangentOperator] = []
        self.place: tuple[Floats, Floats] | None = None
        """Coordinates and velocities there, once something was evaluated."""

    def along(
        self, change: ForceChange, block: ForceBlock, t: float, q: Floats, v: Floats, dq: Floats, dv: Floats, f: Floats
    ) -> None:
        """Evaluate the change of a block's force along a change of the coordinates (:class:`~lamella.roles.ForceChange`)."""
        operator, self.place = self._of_blocks.get(id(block)), (q, v)
        if change.along(t, q, v, dq, dv, f, operator) and operator:
            self.operators.append(operator)


class TangentProduct:
    """(alpha_q K + alpha_v D) x at the point looked at last: by the blocks that multiply, of others entry by entry.

    A matrix in all coordinates would have to be laid out first, which costs as much as some hundred products.

    Args:
        forces, loads: the blocks.
        constraints: the constraints, with the rows that are kept.
        T: map from independent to all coordinates, (n_q, n_u), for :meth:`reduced`.
    """

    def __init__(
        self, forces: ForceSum, loads: ForceSum, constraints: ConstraintStack, T: sparse.csr_array | None = None
    ) -> None:
        self._constraints = constraints
        free = [block for block, _ in forces.parts if isinstance(block, MatrixFreeBlock)]
        self._sum = ForceSum(free, forces.onto_what[0], T, None if T is None else forces)
        self._free, self._ahead = free, Ahead(None, None)
        self._operators = [(block.tangent(), part) for block, (_, part) in zip(free, self._sum.parts, strict=True)]
        self._listed = [
            [(block, _Entries(block)) for block, _ in summed.parts if block not in free and len(block.k_rows)]
            for summed in (forces, loads)
        ]
        self._curvatures = [(block, _Entries(block)) for block, _ in constraints.blocks]
        self._entries = [entries for _, entries in chain(*self._listed, self._curvatures) if len(entries.k)]
        self.lists = bool(self._entries)
        """Whether tangents are multiplied entry by entry as well."""

    def look(self, point: Point, q: Floats, v: Floats, weights: Weights) -> None:
        """Evaluate the tangents that are listed, and what the products of the others need.

        Args:
            point: where.
            q, v: its coordinates and velocities.
            weights: how the unknown moves coordinates and velocities.
        """
        ahead = self._ahead.operators if self._ahead.point is point and self._ahead.weights == weights else []
        for operator, _ in self._operators:
            if operator in ahead:
                operator.weigh(weights.alpha_q, weights.alpha_v)
            else:
                operator.look(point.t, q, v, weights.alpha_q, weights.alpha_v)
        self._ahead = Ahead(None, None)
        for parts, factor in zip(self._listed, (1.0, point.factor), strict=True):
            for block, entries in parts:
                alpha_v = weights.rate if block.first_order else weights.alpha_v
                block.force_tangent(point.t, q, v, weights.alpha_q, alpha_v, q, np.empty(len(block.f_coords)), entries.k)
                entries.k *= entries.scale
                if factor != 1.0:
                    entries.k *= factor
                _clear_unused(block, entries.k)
        if self._curvatures:
            lam = self._constraints.full(point.lam)
            for block, entries in self._curvatures:
                block.curvature(point.t, q, lam[block.first : block.first + block.n_lam], entries.k)
                entries.k *= weights.alpha_q

    def ahead(self, point: Point, weights: Weights) -> Ahead:
        """What evaluates the parts of a sum at a point where this will look next, for operators that need not look then."""
        of_blocks = zip(self._free, self._operators, strict=True) if weights.alpha_q == 1.0 else ()
        self._ahead = Ahead(point, weights, {id(block): operator for block, (operator, _) in of_blocks})
        return self._ahead

    def place_ahead(self, point: Point) -> tuple[Floats, Floats] | None:
        """Coordinates and velocities of a point, if something has been evaluated there :meth:`ahead`."""
        return self._ahead.place if self._ahead.point is point else None

    def __call__(self, x: Floats) -> Floats:
        """The product with a vector in all coordinates, shape (n_q,)."""
        self._multiply(x)
        return self._add_listed(x, self._sum.summed())

    def reduced(self, x: Floats, gather: SumOperator) -> Floats:
        """T^T times the product with a vector in all coordinates, shape (n_u,); ``gather`` is the product with T^T."""
        self._multiply(x)
        y = self._sum.reduced()
        return gather.onto(self._add_listed(x, np.zeros_like(x)), y) if self._entries else y

    def negative_sum(self, r: Floats, x: Floats, factor: float, mass: VectorOperator, u: Floats) -> Floats:
        """-(r + the product as :meth:`reduced` gives it + factor M u), only where no tangents are listed."""
        self._multiply(x)
        return negative_sum(r, self._sum.reduction, self._sum.buffer, factor, mass, u)

    def _multiply(self, x: Floats) -> None:
        """Fill the buffer with the products of the blocks that multiply."""
        for operator, part in self._operators:
            operator.multiply(x, part)
        self._sum.written()

    def _add_listed(self, x: Floats, y: Floats) -> Floats:
        for entries in self._entries:
            _add_product(entries.rows, entries.cols, entries.k, entries.mirrored, x, y)
        return y


class _Entries:
    """The tangent buffer of a block, with the coordinates of its entries, which a block makes anew whenever it is asked."""

    def __init__(self, block: ForceBlock | ConstraintBlock) -> None:
        self.rows, self.cols = block.k_rows, block.k_cols
        self.scale: Floats | float = block.k_scale if isinstance(block, ForceBlock) else 1.0
        self.mirrored = not isinstance(block, ForceBlock) or block.symmetry == "symmetric"
        self.k = np.zeros(len(self.rows))


class SkewProduct:
    """N x with the skew part N of the matrix that an assembly, which keeps the symmetric part alone, has evaluated last.

    Entries of a row stand in runs of consecutive columns, those of whole nodes, that are multiplied a lane at a time, in half the
    time that they take one by one.

    Args:
        assembly: of the matrix.
    """

    def __init__(self, assembly: MatrixAssembly) -> None:
        self._assembly, pattern = assembly, assembly.pattern
        indptr, indices = pattern.indptr, pattern.indices
        begins = np.append(True, np.diff(indices) != 1)
        begins[indptr[:-1]] = False  # the diagonal, which each row begins with
        behind = indptr[:-1] + 1
        begins[behind[behind < indptr[1:]]] = True
        first = np.flatnonzero(begins)
        stops = np.append(begins, True)
        stops[indptr] = True
        ends = np.flatnonzero(stops)
        # Without sign, so that Numba does not look for negative ones.
        self._starts = np.searchsorted(first, indptr).astype(np.uint32)
        self._runs = np.stack([first, ends[np.searchsorted(ends, first, "right")], indices[first]], axis=1).astype(np.uint32)
        self._values = np.empty(len(indices))

    def look(self) -> None:
        """Take the tangents that are in the buffers now."""
        _take_skew(self._assembly.pairs, self._values)

    def __call__(self, x: Floats) -> Floats:
        """The product with a vector, shape (n,)."""
        y = np.zeros_like(x)
        _add_skew_product(self._starts, self._runs, self._values, x, y)
        return y


def _clear_unused(block: ForceBlock, k: Floats) -> None:
    """What a block has not written counts as zero."""
    if block.k_parts is not None:
        for part in np.flatnonzero(~block.k_used):
            k[block.k_parts[part] : block.k_parts[part + 1]] = 0.0


@kernel
def _add_product(rows: Ints, cols: Ints, values: Floats, mirrored: bool, x: Floats, y: Floats) -> None:
    """A symmetric block lists each pair once."""
    for i in range(len(values)):
        row, col = rows[i], cols[i]
        if row >= 0 and col >= 0:
            y[row] += values[i] * x[col]
            if mirrored and row != col:
                y[col] += values[i] * x[row]


@kernel
def _take_skew(pairs: Floats, values: Floats) -> None:
    """1/2 (A_ij - A_ji) of entries that stand side by side; what is on the diagonal is not used."""
    for k in range(len(values)):
        values[k] = 0.5 * (pairs[2 * k] - pairs[2 * k + 1])


@kernel
def _add_skew_product(starts: Unsigned, runs: Unsigned, values: Floats, x: Floats, y: Floats) -> None:
    """The runs, each with the first entry, the end and the first column, lie above the diagonal."""
    for i in range(len(x)):
        own, lanes, single = x[i], spread(0.0), 0.0
        for run in range(starts[i], starts[i + 1]):
            k, end, j = np.intp(runs[run, 0]), np.intp(runs[run, 1]), np.intp(runs[run, 2])
            while k + WIDTH <= end:
                a = load_at(values, k)
                lanes = lanes + a * load_at(x, j)
                store_at(y, j, load_at(y, j) - own * a)
                k, j = k + WIDTH, j + WIDTH
            while k < end:
                a = number_at(values, k)
                single += a * number_at(x, j)
                y[j] -= own * a
                k, j = k + 1, j + 1
        y[i] += single + total(lanes)
