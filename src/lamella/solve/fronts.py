"""Symbolic part of the multifrontal factorisation: order, elimination tree and fronts, from the pattern alone.

Coordinates with the same neighbours (those of one node) are treated together, so the graphs are small. The order with the
fewest operations is taken from the given one, reverse Cuthill-McKee and minimum degree.

Source: J. W. H. Liu, The multifrontal method for sparse matrix solution, SIAM Review 34 (1992) 82-109.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TypeVar

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import reverse_cuthill_mckee
from scipy.sparse.linalg import splu

from lamella.assembly.pattern import Pattern
from lamella.roles import Floats, Ints

FRONT_COST = 4000.0
"""Time to set up a front, in multiplications and additions of the dense kernels (some tens of flops a nanosecond)."""
ADD_COST = 12.0
"""Time to add one entry of an update to the parent, in the same unit."""
HOPELESS = 3.0
"""An order with so many times the operations of another, node by node, is not looked at further."""

Number = TypeVar("Number", float, Floats)


@dataclass
class Front:
    """Nodes eliminated together (``pivots``, in order) and the nodes left that they are connected to (``rest``)."""

    pivots: list[int]
    rest: set[int]


def nodes_of(pattern: Pattern) -> tuple[list[Ints], sparse.csr_array]:
    """Groups of coordinates with the same neighbours, in A and in A^T, and the graph of the groups: ones, with the diagonal."""
    rows, cols = pattern.rows, np.asarray(pattern.indices, np.int64)
    # Equal sums of random numbers of 64 bits, one for each coordinate, are those of equal sets.
    marks = np.random.default_rng(0).integers(0, 2**64, pattern.n, np.uint64)
    of_row, of_column = np.add.reduceat(marks[cols], pattern.indptr[:-1]), np.zeros_like(marks)
    np.add.at(of_column, cols, marks[rows])
    neighbours = of_row + of_column - marks if pattern.symmetric else of_row + np.uint64(3) * of_column
    _, heads, group = np.unique(neighbours, return_index=True, return_inverse=True)
    number = np.empty(len(heads), np.int64)
    number[np.argsort(heads)] = np.arange(len(heads))  # in the order of their first coordinates
    group = number[group]
    of_heads = np.zeros(pattern.n, bool)
    of_heads[heads] = True
    kept = of_heads[rows] & of_heads[cols]
    rows, cols = group[rows[kept]], group[cols[kept]]
    both, shape = (np.concatenate([rows, cols]), np.concatenate([cols, rows])), (len(heads), len(heads))
    graph = sparse.csr_array(sparse.coo_array((np.ones(len(both[0])), both), shape=shape))  # sums what is there twice
    graph.data[:] = 1.0
    return np.split(np.argsort(group, kind="stable"), np.cumsum(np.bincount(group))[:-1]), graph


def _candidates(graph: sparse.csr_array) -> list[Ints]:
    """Orders worth trying: node at each position."""
    n = len(graph.indptr) - 1
    degree = np.diff(graph.indptr)
    dominant = sparse.csc_array(sparse.diags_array(degree + 1.0) - graph)
    by_degree = splu(dominant, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}).perm_c
    natural = np.arange(n)
    return [natural, np.asarray(reverse_cuthill_mckee(graph, symmetric_mode=True)), np.argsort(by_degree), np.asarray(by_degree)]


def _eliminate(graph: sparse.csr_array, order: Ints) -> tuple[list[set[int]], list[int]]:
    """Neighbours left when each node is eliminated, and its parent in the elimination tree (-1 for a root), by position."""
    n = len(order)
    position = np.argsort(order)
    rows, cols = np.repeat(position, np.diff(graph.indptr)), position[graph.indices]
    later = np.flatnonzero(cols > rows)
    later = later[np.argsort(rows[later], kind="stable")]
    starts = np.searchsorted(rows[later], np.arange(n + 1)).tolist()
    near = cols[later].tolist()
    left = [set(near[first:end]) for first, end in pairwise(starts)]
    parent = [-1] * n
    for j in range(n):
        rest = left[j]
        rest.discard(j)
        if rest:
            parent[j] = min(rest)
            left[parent[j]] |= rest
    return left, parent


def operations(p: Number, u: Number) -> Number:
    """Multiplications and additions of a front."""
    return p**3 / 6 + p * p * u / 2 + p * u * u / 2


def _cost(p: float, u: float) -> float:
    return operations(p, u) + FRONT_COST + ADD_COST * u * u / 2


def _sums(weight: list[float], sets: Sequence[Iterable[int]]) -> list[float]:
    """Sums of weights over the members of each set."""
    return [sum(map(weight.__getitem__, members)) for members in sets]


def _merge(left: list[set[int]], parent: list[int], weight: list[float], sizes: list[float]) -> list[Front]:
    """Fronts in the order of elimination: each child is merged into its parent when that saves time.

    Args:
        left, parent: as :func:`_eliminate` finds them.
        weight: coordinates of each node.
        sizes: coordinates left when each node is eliminated.
    """
    n = len(left)
    front = [Front([j], left[j]) for j in range(n)]
    children: list[list[int]] = [[] for _ in range(n)]
    p, alone = weight.copy(), [_cost(*pair) for pair in zip(weight, sizes, strict=True)]
    for j in range(n):
        kept: list[int] = []
        for c in children[j]:
            together = _cost(p[c] + p[j], sizes[j])
            if together <= alone[c] + alone[j]:
                front[j].pivots = front[c].pivots + front[j].pivots
                p[j] += p[c]
                alone[j] = together
                kept += children[c]
            else:
                kept.append(c)
        children[j] = kept
        if parent[j] >= 0:
            children[parent[j]].append(j)
    ordered: list[Front] = []
    stack = [j for j in range(n) if parent[j] < 0]
    while stack:  # parents before children, to be reversed
        j = stack.pop()
        ordered.append(front[j])
        stack += children[j]
    return ordered[::-1]


def fronts_of(graph: sparse.csr_array, weight: Floats) -> tuple[list[Front], float]:
    """The fronts of the cheapest order, in nodes, children before parents, and their multiplications and additions."""
    best: list[Front] = []
    cost, of_best = np.inf, 0.0
    tried = []
    for order in _candidates(graph):
        left, parent = _eliminate(graph, order)
        own = weight[order].tolist()
        sizes = _sums(own, left)
        tried.append((order, left, parent, own, sizes, sum(map(operations, own, sizes))))
    least = min(count for *_, count in tried)
    for order, left, parent, own, sizes, count in tried:
        if count > HOPELESS * least:
            continue
        fronts = _merge(left, parent, own, sizes)
        pairs = list(zip(_sums(own, [f.pivots for f in fronts]), _sums(own, [f.rest for f in fronts]), strict=True))
        total = sum(_cost(*pair) for pair in pairs)
        if total < cost:
            cost, of_best = total, sum(operations(*pair) for pair in pairs)
            node = order.tolist()
            best = [Front([node[i] for i in f.pivots], {node[i] for i in f.rest}) for f in fronts]
    return best, of_best
