"""Symbolic part of the multifrontal factorisation: order, elimination tree and fronts, from the pattern alone.

Coordinates with the same neighbours (those of one node) are treated together, so the graphs are small. The order with the
fewest operations is taken from the given one, reverse Cuthill-McKee and minimum degree.

Source: J. W. H. Liu, The multifrontal method for sparse matrix solution, SIAM Review 34 (1992) 82-109.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import reverse_cuthill_mckee
from scipy.sparse.linalg import splu

from lamella.assembly.pattern import Pattern
from lamella.assembly.pattern_kernels import numbered, sorted_by
from lamella.roles import Floats, Ints
from lamella.solve.lists import Lists, starts_of
from lamella.solve.symbolic_kernels import add_marks, grow_tree, list_rest, merge_fronts, operations, time_of

HOPELESS = 3.0
"""An order with so many times the operations of another, node by node, is not looked at further."""


class Fronts(NamedTuple):
    """The nodes eliminated together, ``pivots``, in order, and those left that they are connected to, ``rest``, of each front.

    Children come before parents; ``cost`` counts the multiplications and additions of all.
    """

    pivots: Lists
    rest: Lists
    cost: float


def nodes_of(pattern: Pattern) -> tuple[Lists, Lists]:
    """Groups of coordinates with the same neighbours, in A and in A^T, and the neighbours of each group, itself among them."""
    starts, cols = (np.ascontiguousarray(part, np.int64) for part in (pattern.indptr, pattern.indices))
    marks, of_row, of_column = (np.zeros(pattern.n, np.uint64) for _ in range(3))
    add_marks(starts, cols, pattern.symmetric, marks, of_row, of_column)
    sums = of_row + (of_column if pattern.symmetric else np.uint64(3) * of_column)
    _, heads, group = np.unique(sums, return_index=True, return_inverse=True)
    n, number = len(heads), np.empty(len(heads), np.int64)
    number[np.argsort(heads)] = np.arange(n)  # in the order of their first coordinates
    members, ends = sorted_by(number[group], n)
    node = np.full(pattern.n, -1)
    node[np.sort(heads)] = np.arange(n)
    beside = Lists(cols, starts).take(np.sort(heads))
    rows, cols = np.repeat(np.arange(n), np.diff(beside.starts)), node[beside.numbers]
    rows, cols = rows[cols >= 0], cols[cols >= 0]
    starts, near, _ = numbered(np.concatenate([rows, cols]), np.concatenate([cols, rows]), n, n)
    return Lists(members, np.append(0, ends[:-1])), Lists(near, starts)


def _candidates(graph: Lists) -> list[Ints]:
    """Orders worth trying: node at each position."""
    near, starts = graph
    n, degree = len(starts) - 1, np.diff(starts)
    dominant = np.where(near == np.repeat(np.arange(n), degree), np.repeat(degree, degree), -1.0)
    matrix = sparse.csc_array((dominant, near.astype(np.int32), starts.astype(np.int32)), shape=(n, n))
    by_degree = splu(matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}).perm_c
    orders = [np.arange(n), reverse_cuthill_mckee(matrix, symmetric_mode=True), np.argsort(by_degree), by_degree]
    return [np.array(order, np.int64) for order in orders]


class _Tree:
    """The elimination of the nodes of a graph in some order, counted by position.

    Args:
        graph: neighbours of each node.
        weight: coordinates of each node.
        order: node at each position.
    """

    def __init__(self, graph: Lists, weight: Floats, order: Ints) -> None:
        n = len(order)
        self._graph, self._order, self._position = graph, order, np.argsort(order)
        self._weight, self._parent = weight[order], np.empty(n, np.int64)
        self._count, self._rest = np.empty(n, np.int64), np.empty(n)
        grow_tree(*self._walked, self._weight, self._parent, self._count, self._rest, np.empty(n, np.int64))
        self.operations = sum(operations(self._weight, self._rest).tolist())
        """Multiplications and additions, node by node."""

    @property
    def _walked(self) -> tuple[Ints, Ints, Ints, Ints]:
        return self._graph.starts, self._graph.numbers, self._order, self._position

    def merge(self) -> float:
        """Let nodes share fronts where that saves time; the time of all."""
        n = len(self._order)
        pivots, last, length, listed = np.empty(n), np.empty(n, np.int64), np.empty(n, np.int64), np.empty(n, np.int64)
        m = merge_fronts(
            self._parent, self._weight, self._rest, pivots, last, length, listed, np.empty((5, n), np.int64)
        )  # fmt: skip
        self._last, self._pivots = last[n - m :], Lists(self._order[listed], starts_of(length[n - m :]))
        self._sizes = pivots[self._last], self._rest[self._last]
        return sum(time_of(*self._sizes).tolist())

    def fronts(self) -> Fronts:
        """The fronts that were merged."""
        n = len(self._order)
        starts = starts_of(self._count[self._last])
        at, rest = np.full(n, -1), np.empty(starts[-1], np.int64)
        at[self._last] = starts[:-1]
        list_rest(*self._walked, self._parent, at, rest, np.empty(n, np.int64))
        return Fronts(self._pivots, Lists(rest, starts), sum(operations(*self._sizes).tolist()))


def fronts_of(graph: Lists, weight: Floats) -> Fronts:
    """The fronts of the cheapest order, in nodes.

    Args:
        graph: neighbours of each node, itself among them.
        weight: coordinates of each node, shape (n,).
    """
    trees = [_Tree(graph, weight, order) for order in _candidates(graph)]
    least = min(tree.operations for tree in trees)
    return min((tree for tree in trees if tree.operations <= HOPELESS * least), key=_Tree.merge).fronts()
