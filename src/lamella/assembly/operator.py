"""The assembly operator: one sparse map from the blocks' buffers to the values of a vector or matrix."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from lamella._jit import kernel, shared
from lamella.assembly.pattern_kernels import in_layers, runs_of, sorted_by, tabulated
from lamella.lane import WIDTH, load_at, number_at, spread, store_at
from lamella.roles import Bools, Floats, Indices, Ints


class SumOperator:
    """y = E x, where row i of E lists the entries of x that are summed into y[i], with their factors.

    SciPy's product costs several microseconds of checks at each call, as much as the sums themselves on small models. Rows are
    kept in the order of their length, so that the loops over one, two or four entries have no branches: 1.6 times as fast as
    row by row.

    Args:
        targets, sources, factors: the entries of E, each with its place in y, its place in x, and its factor, shapes (n,).
        n_targets: numbers in y.
    """

    def __init__(self, targets: Ints, sources: Ints, factors: Floats, n_targets: int) -> None:
        lengths = np.bincount(targets, minlength=n_targets)
        order = np.argsort(lengths, kind="stable")
        place = np.empty_like(order)
        place[order] = np.arange(n_targets)
        by_row, _ = sorted_by(place[targets], n_targets)
        self.n = n_targets
        self.targets: Indices = order.astype(np.int32)
        self.group_ends = np.concatenate([[0], np.cumsum(np.bincount(lengths, minlength=1))]).astype(np.int32)
        self.sources: Indices = sources[by_row].astype(np.int32)
        self.factors = factors[by_row]

    @classmethod
    def of(cls, matrix: sparse.sparray) -> SumOperator:
        """The product with a matrix, sparse (n_targets, n_sources)."""
        rows = sparse.csr_array(matrix)
        n_targets = len(rows.indptr) - 1
        targets = np.repeat(np.arange(n_targets), np.diff(rows.indptr))
        return cls(targets, rows.indices.astype(np.int64), rows.data.astype(float), n_targets)

    def transposed(self, n_targets: int) -> SumOperator:
        """The product with the transpose, which has so many rows."""
        lengths = np.repeat(np.arange(len(self.group_ends) - 1), np.diff(self.group_ends))
        sources = np.repeat(self.targets, lengths).astype(np.int64)
        return SumOperator(self.sources.astype(np.int64), sources, self.factors, n_targets)

    def __call__(self, x: Floats) -> Floats:
        """The sums in a new array, shape (n_targets,)."""
        return self.into(x, np.empty(self.n))

    def into(self, x: Floats, out: Floats) -> Floats:
        """Overwrite ``out`` with the sums and return it."""
        _sum(self.group_ends, self.targets, self.sources, self.factors, x, out)
        return out


@kernel
def _sum(group_ends: Indices, targets: Indices, sources: Indices, factors: Floats, x: Floats, out: Floats) -> None:
    at = 0
    for length in range(len(group_ends) - 1):
        first, end = group_ends[length], group_ends[length + 1]
        if length == 1:
            for i in range(first, end):
                out[targets[i]] = factors[at] * x[sources[at]]
                at += 1
        elif length == 2:
            for i in range(first, end):
                out[targets[i]] = factors[at] * x[sources[at]] + factors[at + 1] * x[sources[at + 1]]
                at += 2
        elif length == 4:
            for i in range(first, end):
                one = factors[at] * x[sources[at]] + factors[at + 1] * x[sources[at + 1]]
                two = factors[at + 2] * x[sources[at + 2]] + factors[at + 3] * x[sources[at + 3]]
                out[targets[i]] = one + two
                at += 4
        else:
            for i in range(first, end):
                total = 0.0
                for k in range(at, at + length):
                    total += factors[k] * x[sources[k]]
                out[targets[i]] = total
                at += length


class ScatterSum:
    """y += E x for a long buffer x, read in its own order, in parts of which some may not be in use.

    For the matrix of a model this is twice as fast as row by row, since neighbours in a row of the matrix lie far apart in x.
    What costs time is memory, so a contribution is listed in six bytes: sources are runs of consecutive numbers, each source's
    first contributions before the second ones, and of factors there are few different ones, by the sizes of elements.

    Ranges of y may be summed side by side. Each number of y is summed in the same order, whatever the ranges.

    Args:
        targets, sources, factors: contributions, each with its place in y, its place in x, and its factor, shapes (n,).
        parts: where each part of x begins, and where the last ends, shape (n_part + 1,).
        bounds: where each range of y begins, and where the last ends; all of y when left out.
    """

    def __init__(self, targets: Ints, sources: Ints, factors: Floats, parts: Ints, bounds: Sequence[int] | None = None) -> None:
        once = bool(np.all(sources[1:] > sources[:-1]))  # as on a mesh whose supports hold coordinates: they are in order then
        order = slice(None) if once else in_layers(sources, parts)
        ordered, sources = targets[order].astype(np.uint32), sources[order]
        self._table, codes = tabulated(factors[order].astype(float))
        self._ranges: list[Listed] = []
        for first, end in pairwise([0, np.inf] if bounds is None else bounds):
            own = slice(None) if bounds is None or len(bounds) == 2 else np.flatnonzero((ordered >= first) & (ordered < end))
            self._ranges.append((*runs_of(sources[own], parts), ordered[own], codes[own]))

    def add(self, x: Floats, used: Bools, out: Floats, number: int = 0) -> None:
        """Add the parts in use, (n_part,), to a range of ``out``, whose other numbers are left alone."""
        _add_parts(*self._ranges[number], self._table, x, used, out)


Listed = tuple[Ints, Ints, NDArray[np.uint32], NDArray[np.integer]]
"""Where the runs of each part begin, the runs, targets, and codes of factors. Targets have no sign, so that Numba does not look
for negative ones."""


@shared
def _add_parts(
    starts: Ints,
    runs: Ints,
    targets: NDArray[np.uint32],
    codes: NDArray[np.integer],
    table: Floats,
    x: Floats,
    used: Bools,
    out: Floats,
) -> None:
    for part in range(len(used)):
        if used[part]:
            for run in range(starts[part], starts[part + 1]):
                ahead = runs[run, 2]
                for i in range(runs[run, 0], runs[run, 1]):
                    out[targets[i]] += table[codes[i]] * number_at(x, i + ahead)


class VectorOperator:
    """y = (E x I3) x for vectors stacked in one array: the same sums for each component, with a third of the look-ups.

    A vector is loaded as a lane, whose surplus numbers are not looked at.

    Args:
        scalar: E, sparse (n, n).
    """

    def __init__(self, scalar: sparse.csr_array) -> None:
        self.starts: Indices = scalar.indptr.astype(np.int32)
        self.sources: Indices = (3 * scalar.indices).astype(np.int32)
        self.factors = scalar.data.astype(float)
        self._x = np.zeros(3 * (len(self.starts) - 1) + WIDTH)
        self._y = np.zeros_like(self._x)

    def __call__(self, x: Floats) -> Floats:
        """The sums in a new array, shape (3 n,)."""
        out = np.empty_like(x)
        _sum_vectors(self.starts, self.sources, self.factors, x, self._x, self._y, out)
        return out


def mass_operator(matrix: sparse.csr_array) -> SumOperator | VectorOperator:
    """The faster operator of a mass matrix (n, n): by vectors where it treats the three components of each alike.

    In all coordinates it does; in the independent ones as long as supports hold whole vectors.
    """
    if matrix.nnz and (len(matrix.indptr) - 1) % 3 == 0:
        scalar = sparse.csr_array(matrix[::3, ::3])
        if abs(matrix - sparse.kron(scalar, sparse.eye_array(3))).max() <= 1e-12 * abs(matrix).max():
            return VectorOperator(scalar)
    return SumOperator.of(matrix)


@kernel
def _sum_vectors(starts: Indices, sources: Indices, factors: Floats, x: Floats, longer: Floats, y: Floats, out: Floats) -> None:
    """Even and odd entries of a row are summed apart, as additions would wait for each other."""
    for i in range(len(x)):
        longer[i] = x[i]
    for i in range(len(starts) - 1):
        even, odd = spread(0.0), spread(0.0)
        end = starts[i + 1]
        for k in range(starts[i], end - 1, 2):
            even = even + factors[k] * load_at(longer, sources[k])
            odd = odd + factors[k + 1] * load_at(longer, sources[k + 1])
        if (end - starts[i]) % 2:
            even = even + factors[end - 1] * load_at(longer, sources[end - 1])
        store_at(y, 3 * i, even + odd)  # what is written beyond the vector is overwritten by the next, or lies behind the last
    for i in range(len(out)):
        out[i] = y[i]
