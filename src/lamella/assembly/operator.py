"""The assembly operator: one sparse map from the blocks' buffers to the values of a vector or matrix."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from lamella._jit import inlined, kernel, shared
from lamella.assembly.pattern_kernels import count_terms, in_layers, order_terms, runs_of, tabulated
from lamella.lane import WIDTH, load_at, number_at, put_at, spread, store_at
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
        lengths, begins = np.zeros(n_targets, np.int64), np.empty(n_targets, np.int64)
        self.n, longest = n_targets, count_terms(targets, lengths)
        self.targets: Places = np.empty(n_targets, np.uint32)
        self.group_ends = np.zeros(longest + 2, np.int32)
        self.sources: Places = np.empty(len(targets), np.uint32)
        self.factors = np.empty(len(targets))
        order_terms(
            targets, sources, factors, lengths, begins, self.group_ends, self.targets, self.sources, self.factors
        )  # fmt: skip
        self.arrays = self.group_ends, self.targets, self.sources, self.factors

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
        return self.onto(x, np.zeros(self.n))

    def onto(self, x: Floats, out: Floats) -> Floats:
        """Add the sums to ``out`` (n_targets,) and return it."""
        _add_sums(*self.arrays, x, out)
        return out

    def onto_each(self, several: Floats, out: Floats) -> Floats:
        """Add the sums of several vectors (n, n_sources) to the rows of ``out`` (n, n_targets), and return it."""
        for x, row in zip(several, out, strict=True):
            _add_sums(*self.arrays, x, row)
        return out


Places = NDArray[np.uint32]
"""Places in arrays, without sign, so that Numba does not look for negative ones."""


@kernel
def _add_sums(group_ends: Indices, targets: Places, sources: Places, factors: Floats, x: Floats, out: Floats) -> None:
    at = 0
    for length in range(1, len(group_ends) - 1):
        first, end = group_ends[length], group_ends[length + 1]
        if length == 1:
            for i in range(first, end):
                out[targets[i]] += _term(factors, sources, x, at)
                at += 1
        elif length == 2:
            for i in range(first, end):
                out[targets[i]] += _term(factors, sources, x, at) + _term(factors, sources, x, at + 1)
                at += 2
        elif length == 4:
            for i in range(first, end):
                one = _term(factors, sources, x, at) + _term(factors, sources, x, at + 1)
                two = _term(factors, sources, x, at + 2) + _term(factors, sources, x, at + 3)
                out[targets[i]] += one + two
                at += 4
        else:
            for i in range(first, end):
                total = 0.0
                for k in range(at, at + length):
                    total += _term(factors, sources, x, k)
                out[targets[i]] += total
                at += length


@inlined
def _term(factors: Floats, sources: Places, x: Floats, k: int) -> float:
    return number_at(factors, k) * number_at(x, number_at(sources, k))


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

    def __init__(
        self,
        targets: Ints | Places,
        sources: Ints | Places,
        factors: Floats,
        parts: Ints,
        bounds: Sequence[int] | None = None,
    ) -> None:
        targets, sources = targets.astype(np.uint32, copy=False), sources.astype(np.uint32, copy=False)
        once = bool(np.all(sources[1:] > sources[:-1]))  # as on a mesh whose supports hold coordinates: they are in order then
        order = slice(None) if once else in_layers(sources, parts)
        ordered, sources = targets[order], sources[order]
        self._table, codes = tabulated(factors[order].astype(float, copy=False))
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
                    to = number_at(targets, i)
                    put_at(out, to, number_at(out, to) + number_at(table, number_at(codes, i)) * number_at(x, i + ahead))


class VectorOperator:
    """y = (E x I3) x for vectors stacked in one array: the same sums for each component, with a third of the look-ups.

    A vector is loaded as a lane, whose surplus numbers are not looked at. Four rows are summed together, with zeros where not all
    of them have an entry: those of a node's position and slopes have theirs at nearly the same places.

    Args:
        scalar: E, sparse (n, n).
    """

    def __init__(self, scalar: sparse.csr_array) -> None:
        n = len(scalar.indptr) - 1
        ends = np.append(scalar.indptr, np.full(-n % TOGETHER, scalar.nnz))
        rows = sparse.csr_array((scalar.data, scalar.indices, ends), shape=(len(ends) - 1, n)).tobsr((TOGETHER, 1))
        self.n = 3 * n
        starts: Indices = rows.indptr.astype(np.int32)
        sources: Places = (3 * rows.indices).astype(np.uint32)
        longer, y = np.zeros(self.n + WIDTH), np.zeros(3 * (len(ends) - 1) + WIDTH)
        self.arrays = starts, sources, rows.data.astype(float).reshape(-1), longer, y

    @classmethod
    def within(cls, matrix: sparse.csr_array) -> VectorOperator | None:
        """The product with a mass matrix (n, n), if it treats the three components of each vector alike.

        In independent coordinates it does as long as supports hold whole vectors. Behind the vectors may lie scalar fields, which
        have no mass.
        """
        massive = np.flatnonzero(np.diff(matrix.indptr))
        n = 3 * (int(massive[-1]) // 3 + 1) if len(massive) else 0
        if not 0 < n <= len(matrix.indptr) - 1:
            return None
        vectors = sparse.csr_array(matrix[:n, :n])
        scalar = sparse.csr_array(vectors[::3, ::3])
        alike = abs(vectors - sparse.kron(scalar, sparse.eye_array(3))).max() <= 1e-12 * abs(matrix).max()
        return cls(scalar) if alike else None

    def __call__(self, x: Floats) -> Floats:
        """The sums in a new array, as long as x."""
        return self.onto(x, np.zeros(len(x)))

    def onto(self, x: Floats, out: Floats) -> Floats:
        """Add the sums to ``out`` and return it; what lies behind the 3 n numbers of vectors is left alone in both."""
        _add_vectors(*self.arrays, 1.0, x, out, self.n)
        return out


def balance(factor: float, r: Floats, sums: SumOperator, buffer: Floats, mass: VectorOperator, x: Floats) -> Floats:
    """factor r + E buffer + M x in a new array, in one call: made one after the other the calls take as long as the sums."""
    out = np.empty_like(r)
    _balance(factor, r, *sums.arrays, buffer, *mass.arrays, 1.0, x, out, mass.n)
    return out


def negative_sum(r: Floats, sums: SumOperator, buffer: Floats, factor: float, mass: VectorOperator, x: Floats) -> Floats:
    """-(r + E buffer + factor M x) in a new array, in one call as well."""
    out = np.empty_like(r)
    _negative_balance(1.0, r, *sums.arrays, buffer, *mass.arrays, factor, x, out, mass.n)
    return out


TOGETHER = 4
"""Rows of a :class:`VectorOperator` that are summed together."""


@kernel
def _add_vectors(
    starts: Indices, sources: Places, factors: Floats, longer: Floats, y: Floats, factor: float, x: Floats, out: Floats, n: int
) -> None:
    """out += factor M x, with work space for x and for the sums.

    Even and odd entries of a row are summed apart, as additions would wait for each other.
    """
    for i in range(n):
        longer[i] = x[i]
    for group in range(len(starts) - 1):
        first, end = starts[group], starts[group + 1]
        e0, e1, e2, e3 = spread(0.0), spread(0.0), spread(0.0), spread(0.0)
        o0, o1, o2, o3 = e0, e1, e2, e3
        for k in range(first, end - 1, 2):
            even, odd = load_at(longer, number_at(sources, k)), load_at(longer, number_at(sources, k + 1))
            at = TOGETHER * k
            e0, o0 = e0 + number_at(factors, at) * even, o0 + number_at(factors, at + 4) * odd
            e1, o1 = e1 + number_at(factors, at + 1) * even, o1 + number_at(factors, at + 5) * odd
            e2, o2 = e2 + number_at(factors, at + 2) * even, o2 + number_at(factors, at + 6) * odd
            e3, o3 = e3 + number_at(factors, at + 3) * even, o3 + number_at(factors, at + 7) * odd
        if (end - first) % 2:
            even, at = load_at(longer, number_at(sources, end - 1)), TOGETHER * (end - 1)
            e0, e1 = e0 + number_at(factors, at) * even, e1 + number_at(factors, at + 1) * even
            e2, e3 = e2 + number_at(factors, at + 2) * even, e3 + number_at(factors, at + 3) * even
        to = 3 * TOGETHER * group
        store_at(y, to, e0 + o0)  # what is written beyond a vector is overwritten by the next, or lies behind the last
        store_at(y, to + 3, e1 + o1)
        store_at(y, to + 6, e2 + o2)
        store_at(y, to + 9, e3 + o3)
    for i in range(n):
        out[i] += factor * y[i]


@kernel
def _balance(
    factor: float, r: Floats, group_ends: Indices, targets: Places, sources: Places, factors: Floats, buffer: Floats,
    starts: Indices, vectors: Places, masses: Floats, longer: Floats, y: Floats, of_mass: float, x: Floats, out: Floats, n: int,
) -> None:  # fmt: skip
    for i in range(len(out)):
        out[i] = factor * r[i]
    _add_sums(group_ends, targets, sources, factors, buffer, out)
    _add_vectors(starts, vectors, masses, longer, y, of_mass, x, out, n)


@kernel
def _negative_balance(
    factor: float, r: Floats, group_ends: Indices, targets: Places, sources: Places, factors: Floats, buffer: Floats,
    starts: Indices, vectors: Places, masses: Floats, longer: Floats, y: Floats, of_mass: float, x: Floats, out: Floats, n: int,
) -> None:  # fmt: skip
    _balance(factor, r, group_ends, targets, sources, factors, buffer, starts, vectors, masses, longer, y, of_mass, x, out, n)
    for i in range(len(out)):
        out[i] = -out[i]
