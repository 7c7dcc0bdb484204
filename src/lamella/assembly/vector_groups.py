"""Where contributions stand in a matrix, found for groups of coordinates in place of single ones.

A group (a supervariable of sparse solvers) holds the independent coordinates of one vector of finite elements, which stand side
by side and couple with the same others. A pattern of pairs of groups has up to a ninth of the places, and gives the place of an
entry by counting.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from lamella.assembly import vector_group_kernels as kernels
from lamella.assembly.expand import Entries
from lamella.assembly.pattern_kernels import numbered
from lamella.lane import WIDTH
from lamella.roles import Bools, Floats, Ints, TangentTables

NONE = np.zeros(0, bool)
HELD, MANY = -1, -2
"""In place of the one independent coordinate that a coordinate follows: it follows none, or several."""

Pairs = tuple[Ints, Ints]
Places32 = NDArray[np.uint32]
EMPTY: Pairs = np.zeros(0, np.int64), np.zeros(0, np.int64)


class Placed(NamedTuple):
    """Place, source in the buffer and factor of each entry, and whether it stands below the diagonal or on it."""

    slots: Ints | Places32
    sources: Ints | Places32
    factors: Floats
    below: Bools = NONE
    on_diagonal: Bools = NONE


class Followed:
    """The independent coordinate that each coordinate follows, and by which factor.

    Args:
        T: map from independent to all coordinates, (n_q, n_u).

    Attributes:
        one: the coordinate, ``HELD`` or ``MANY``, shape (n_q + 1,); the last, which padding refers to, is held.
        factors: its factor, shape (n_q + 1,).
    """

    def __init__(self, T: sparse.csr_array) -> None:
        counts = np.diff(T.indptr)
        single = np.flatnonzero(counts == 1)
        self.one = np.where(np.append(counts, 0) > 1, MANY, HELD)
        self.one[single] = T.indices[T.indptr[single]]
        self.factors = np.zeros(len(self.one))
        self.factors[single] = T.data[T.indptr[single]]


class Table:
    """The tangent of elements whose coordinates follow one independent coordinate each, in the upper triangle.

    Args:
        tables: its entries in all coordinates.
        followed: what the coordinates follow.
    """

    def __init__(self, tables: TangentTables, followed: Followed) -> None:
        self._tables, self._u = tables, followed.one[tables.coords]
        self._factors = tables.scale * followed.factors[tables.coords]
        self.suits = not np.any(self._u == MANY)
        """Whether no coordinate follows several."""

    @property
    def vectors(self) -> Ints:
        """Vectors of the elements."""
        return self._tables.coords[self._tables.coords >= 0] // 3

    def pairs(self, group_of: Ints) -> Pairs:
        """All pairs of groups that an element couples."""
        n = self._tables.n
        self._local, self._members = np.empty_like(self._u), np.empty_like(self._u)
        self._counts = np.empty(len(self._u) // n, np.int64)
        total = kernels.find_members(self._u, group_of, n, self._local, self._members, self._counts)
        first, second = np.empty(total, np.int64), np.empty(total, np.int64)
        kernels.list_pairs(self._members, self._counts, n, first, second)
        return first, second

    def placed(self, places: Places) -> Placed:
        """The places of the entries whose coordinates are not held."""
        tables = self._tables
        n_k, most = len(self._u) // tables.n * len(tables.rows), int(self._counts.max(initial=0))
        slots, sources, factors = np.empty(n_k, np.uint32), np.empty(n_k, np.uint32), np.empty(n_k)
        n = kernels.place_tables(
            self._u, self._factors, tables.rows, tables.columns, tables.n, self._local, self._members, self._counts,
            places.starts, places.groups, places.lead, places.shift, most, np.empty(WIDTH * most * most, np.int64),
            slots, sources, factors,
        )  # fmt: skip
        return Placed(slots[:n], sources[:n], factors[:n])


class Listed:
    """Entries of a block, one by one.

    Args:
        entries: the entries.
    """

    def __init__(self, entries: Entries) -> None:
        self._entries = entries

    def pairs(self, group_of: Ints) -> Pairs:
        """The pairs of their groups."""
        return pairs_of(self._entries, group_of)

    def placed(self, places: Places) -> Placed:
        """The places of the entries."""
        e = self._entries
        return Placed(places.of(e), e.sources, e.factors, e.rows > e.cols, e.rows == e.cols)


class Places:
    """The places of a matrix whose pairs of groups are known, in compressed rows.

    Args:
        pairs: pairs of groups that couple; each couples with itself as well.
        first: first coordinate of each group, and the number of all.
        group_of: group of each coordinate.
        symmetric: list the upper triangle only.

    Attributes:
        indptr, indices: the places.
    """

    def __init__(self, pairs: Sequence[Pairs], first: Ints, group_of: Ints, symmetric: bool) -> None:
        n, own = len(first) - 1, np.arange(len(first) - 1)
        rows, cols = (np.concatenate([own, *part]) for part in zip(EMPTY, *pairs, strict=True))
        if symmetric:
            rows, cols = np.minimum(rows, cols), np.maximum(rows, cols)
        self.starts, self.groups, _ = numbered(rows, cols, n, n)
        self.group_of, self._symmetric = group_of, symmetric
        self.shift, self.indptr, self.lead = (
            np.empty_like(self.groups),
            np.zeros(len(group_of) + 1, np.int64),
            np.empty_like(group_of),
        )
        kernels.count_places(self.starts, self.groups, first, symmetric, self.shift, self.lead, self.indptr)
        self.indices = np.empty(self.indptr[-1], np.int64)
        kernels.list_places(self.starts, self.groups, first, symmetric, self.indices)

    def of(self, entries: Entries) -> Ints:
        """Place of each entry, those below the diagonal of a symmetric matrix as if mirrored."""
        slots = np.empty(len(entries.rows), np.int64)
        kernels.find_places(
            entries.rows, entries.cols, self._symmetric, self.group_of, self.starts, self.groups, self.lead, self.shift, slots
        )
        return slots


def groups_of(independent: Ints, vectors: Ints) -> tuple[Ints, Ints]:
    """Groups of the independent coordinates: those of one of the ``vectors`` together, all others alone.

    Returns:
        First coordinate of each group and their number, and the group of each coordinate.
    """
    whole = np.zeros(max(int(independent[-1]) // 3, int(vectors.max(initial=0))) + 1 if len(independent) else 1, bool)
    whole[vectors] = True
    vector = independent // 3
    begins = np.ones(len(vector), bool)
    begins[1:] = (vector[1:] != vector[:-1]) | ~whole[vector[1:]]
    return np.append(np.flatnonzero(begins), len(vector)), np.cumsum(begins) - 1


def pairs_of(entries: Entries, group_of: Ints) -> Pairs:
    """The pairs of groups of some entries, without those that repeat the one before."""
    first, second = np.empty(len(entries.rows), np.int64), np.empty(len(entries.rows), np.int64)
    n = kernels.list_pairs_of(entries.rows, entries.cols, group_of, first, second)
    return first[:n], second[:n]


def pairs_of_mass(i: Ints, j: Ints, followed: Followed, group_of: Ints) -> tuple[Pairs, Ints]:
    """The pairs of groups that pairs of vectors couple component by component, and which have coordinates that follow several."""
    first, second, others = np.empty(3 * len(i), np.int64), np.empty(3 * len(i), np.int64), np.empty(len(i), np.int64)
    i, j = np.ascontiguousarray(i), np.ascontiguousarray(j)
    n, m = kernels.list_pairs_of_mass(i, j, followed.one, group_of, first, second, others)
    return (first[:n], second[:n]), others[:m]
