"""Compiled loops of the symbolic factorisation: nodes, elimination tree, fronts, and places of entries."""

from __future__ import annotations

from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from lamella._jit import inlined, kernel
from lamella.roles import Floats, Ints

FRONT_COST = 4000.0
"""Time to set up a front, in multiplications and additions of the dense kernels (some tens of flops a nanosecond)."""
ADD_COST = 12.0
"""Time to add one entry of an update to the parent, in the same unit."""

Marks = NDArray[np.uint64]
Number = TypeVar("Number", float, Floats)


@kernel
def add_marks(starts: Ints, cols: Ints, marks: Marks, of_row: Marks, of_column: Marks) -> None:
    """Add up the marks of the columns in each row and of the rows in each column of a pattern."""
    for i in range(len(marks)):
        for k in range(starts[i], starts[i + 1]):
            of_row[i] += marks[cols[k]]
            of_column[cols[k]] += marks[i]


@kernel
def grow_tree(
    starts: Ints, near: Ints, order: Ints, position: Ints, weight: Floats,
    parent: Ints, count: Ints, rest: Floats, seen: Ints,
) -> None:  # fmt: skip
    """The elimination tree and what is left beside each node when it is eliminated, nodes counted by their positions.

    Row i of the factor holds the nodes on the ways from the earlier neighbours of i up to i, which is the parent of those that
    have none yet.

    Args:
        starts, near: graph, the neighbours of each node, shapes (n + 1,) and (starts[n],).
        order, position: node at each position, position of each node.
        weight: coordinates of the node at each position.
        parent: result: position of the parent, -1 for a root.
        count, rest: results: number of later nodes that a node is connected to when it is eliminated, and of their coordinates.
        seen: workspace (n,).

    Source: J. W. H. Liu, The role of elimination trees in sparse factorization, SIAM J. Matrix Anal. Appl. 11 (1990) 134-172.
    """
    for i in range(len(order)):
        parent[i], count[i], rest[i], seen[i] = -1, 0, 0.0, i
        for k in range(starts[order[i]], starts[order[i] + 1]):
            j = position[near[k]]
            while j < i and seen[j] != i:
                seen[j] = i
                count[j] += 1
                rest[j] += weight[i]
                if parent[j] < 0:
                    parent[j] = i
                j = parent[j]


@kernel
def list_rest(
    starts: Ints, near: Ints, order: Ints, position: Ints, parent: Ints, ends: Ints, found: Ints, seen: Ints
) -> None:  # fmt: skip
    """The nodes that some nodes are connected to when these are eliminated, as :func:`grow_tree` counts them.

    Args:
        starts, near, order, position, parent, seen: as there.
        ends: where the list of each position begins, -1 for none; moved to its end.
        found: result: the lists.
    """
    for i in range(len(order)):
        seen[i] = i
        for k in range(starts[order[i]], starts[order[i] + 1]):
            j = position[near[k]]
            while j < i and seen[j] != i:
                seen[j] = i
                if ends[j] >= 0:
                    found[ends[j]] = order[i]
                    ends[j] += 1
                j = parent[j]


@inlined
def operations(p: Number, u: Number) -> Number:
    """Multiplications and additions of a front with p pivots and u remaining rows."""
    return p * p * p / 6 + p * p * u / 2 + p * u * u / 2


@inlined
def time_of(p: Number, u: Number) -> Number:
    """Time of a front with p pivots and u remaining rows, in multiplications and additions."""
    return operations(p, u) + FRONT_COST + ADD_COST * u * u / 2


@kernel
def merge_fronts(
    parent: Ints, weight: Floats, rest: Floats, pivots: Floats, last: Ints, count: Ints, listed: Ints, links: Ints
) -> int:
    """Fronts in the order of elimination, children before parents: each child is merged into its parent when that saves time.

    Args:
        parent, weight, rest: as for :func:`grow_tree`.
        pivots: result: coordinates of the front that ends with each position.
        last: result: position of the last pivot of each front, in the last entries.
        count: result: number of nodes that are pivots of the front, in the last entries.
        listed: result: positions of the pivots, front after front.
        links: workspace (5, n).

    Returns:
        The number of fronts.
    """
    n = len(parent)
    first, end, sister, head, after = links[0], links[1], links[2], links[3], links[4]  # children, and pivots, as linked lists
    for j in range(n):
        first[j], end[j], sister[j], head[j], after[j], pivots[j] = -1, -1, -1, j, -1, weight[j]
    top = 0  # of a stack of roots
    for j in range(n):
        child, alone = first[j], time_of(pivots[j], rest[j])
        first[j] = end[j] = -1
        while child >= 0:
            following, begin, stop = sister[child], child, child
            together = time_of(pivots[child] + pivots[j], rest[j])
            if together <= time_of(pivots[child], rest[child]) + alone:
                after[child], head[j] = head[j], head[child]
                pivots[j] += pivots[child]
                alone, begin, stop = together, first[child], end[child]
            if begin >= 0:
                if first[j] < 0:
                    first[j] = begin
                else:
                    sister[end[j]] = begin
                end[j], sister[stop] = stop, -1
            child = following
        above = parent[j]
        if above < 0:
            listed[top] = j
            top += 1
        else:
            if first[above] < 0:
                first[above] = j
            else:
                sister[end[above]] = j
            end[above] = j
    at = n
    while top:  # parents before children, from the end
        top -= 1
        j = listed[top]
        at -= 1
        last[at] = j
        j = first[j]
        while j >= 0:
            listed[top] = j
            top += 1
            j = sister[j]
    place = 0
    for f in range(at, n):
        j, count[f] = head[last[f]], 0
        while j >= 0:
            listed[place] = j
            place += 1
            count[f] += 1
            j = after[j]
    return n - at


@kernel
def place_entries(
    entries: Ints, starts: Ints, columns: Ints, rows: Ints, fronts: Ints, rest: Ints, local: Ints, slots: Ints
) -> None:
    """Place of entries of a matrix in the panels of their fronts.

    Args:
        entries, starts: entries of each front, shapes (nnz,) and (n_front + 1,).
        columns, rows: positions of each entry.
        fronts, rest: fronts and their remaining rows, see :func:`lamella.solve.front_kernels.factorise`.
        local: workspace, as long as there are positions.
        slots: result: place of each entry.
    """
    for f in range(len(starts) - 1):
        first, p, a_len, a0, more = fronts[f, 0], fronts[f, 1], fronts[f, 2], fronts[f, 3], fronts[f, 7]
        for i in range(p):
            local[first + i] = i
        for i in range(fronts[f, 4]):
            local[rest[more + i]] = p + i
        for k in range(starts[f], starts[f + 1]):
            entry = entries[k]
            slots[entry] = a0 + (columns[entry] - first) * a_len + local[rows[entry]]
