"""Symbolic part of the multifrontal factorisation: order, elimination tree and fronts, from the pattern alone.

Coordinates with the same neighbours (those of one node) are treated together, so the graphs are small. The order with the
fewest operations is taken from the given one, reverse Cuthill-McKee and minimum degree.

Source: J. W. H. Liu, The multifrontal method for sparse matrix solution, SIAM Review 34 (1992) 82-109.
"""

from __future__ import annotations

from dataclasses import dataclass
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
    """Groups of coordinates with the same neighbours, in A or in A^T, and the graph of the groups: ones, with the diagonal."""
    ones = pattern.matrix(np.ones(len(pattern.indices)))
    graph = ((ones if pattern.symmetric else ones + ones.T) + sparse.eye_array(pattern.n)).tocsr()
    graph.sort_indices()
    groups: dict[bytes, list[int]] = {}
    for i in range(pattern.n):
        groups.setdefault(graph.indices[graph.indptr[i] : graph.indptr[i + 1]].tobytes(), []).append(i)
    nodes = [np.array(group) for group in groups.values()]
    heads = np.array([group[0] for group in nodes], dtype=np.int64)
    reduced = graph[heads][:, heads].tocsr()
    return nodes, sparse.csr_array((np.ones(reduced.nnz), reduced.indices, reduced.indptr), shape=reduced.shape)


def _candidates(graph: sparse.csr_array) -> list[Ints]:
    """Orders worth trying: node at each position."""
    n = len(graph.indptr) - 1
    degree = np.diff(graph.indptr)
    dominant = sparse.csc_array(sparse.diags_array(degree + 1.0) - graph)
    by_degree = splu(dominant, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}).perm_c
    natural = np.arange(n)
    return [natural, np.asarray(reverse_cuthill_mckee(graph, symmetric_mode=True)), np.argsort(by_degree), np.asarray(by_degree)]


def _eliminate(graph: sparse.csr_array, order: Ints) -> tuple[list[set[int]], Ints]:
    """Neighbours left when each node is eliminated, and its parent in the elimination tree (-1 for a root), by position."""
    n = len(order)
    position = np.argsort(order)
    parent = np.full(n, -1)
    left: list[set[int]] = [set() for _ in range(n)]
    for j in range(n):
        node = order[j]
        near = position[graph.indices[graph.indptr[node] : graph.indptr[node + 1]]]
        left[j].update(near[near > j].tolist())
        left[j].discard(j)
        if left[j]:
            parent[j] = min(left[j])
            left[parent[j]] |= left[j]
    return left, parent


def operations(p: Number, u: Number) -> Number:
    """Multiplications and additions of a front."""
    return p**3 / 6 + p * p * u / 2 + p * u * u / 2


def _unmerged(left: list[set[int]], weight: Floats) -> float:
    """Multiplications and additions when each node is a front of its own."""
    rest = np.array([weight[list(near)].sum() for near in left])
    return float(np.sum(operations(weight, rest)))


def _cost(p: float, u: float) -> float:
    return operations(p, u) + FRONT_COST + ADD_COST * u * u / 2


def _merge(left: list[set[int]], parent: Ints, weight: Floats) -> list[Front]:
    """Fronts in the order of elimination: each child is merged into its parent when that saves time."""
    n = len(left)
    front = [Front([j], left[j]) for j in range(n)]
    children: list[list[int]] = [[] for _ in range(n)]
    p, u = weight.copy(), np.array([weight[list(rest)].sum() for rest in left])
    for j in range(n):
        kept: list[int] = []
        for c in children[j]:
            if _cost(p[c] + p[j], u[j]) <= _cost(p[c], u[c]) + _cost(p[j], u[j]):
                front[j].pivots = front[c].pivots + front[j].pivots
                p[j] += p[c]
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
    cost = np.inf
    tried = [(order, *_eliminate(graph, order)) for order in _candidates(graph)]
    counts = [_unmerged(left, weight[order]) for order, left, _ in tried]
    for (order, left, parent), count in zip(tried, counts, strict=True):
        if count > HOPELESS * min(counts):
            continue
        w = weight[order]
        fronts = _merge(left, parent, w)
        total = sum(_cost(w[front.pivots].sum(), w[list(front.rest)].sum()) for front in fronts)
        if total < cost:
            cost = total
            best = [Front([int(order[i]) for i in f.pivots], {int(order[i]) for i in f.rest}) for f in fronts]
    return best, sum(operations(weight[f.pivots].sum(), weight[list(f.rest)].sum()) for f in best)
