"""Compiled loops of the symbolic factorisation: nodes, elimination tree, fronts, and places of entries."""

from __future__ import annotations

from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from lamella._jit import inlined, kernel
from lamella.lane import number_at
from lamella.roles import Floats, Indices, Ints

FRONT_COST = 4000.0
"""Time to set up a front, in multiplications and additions of the dense kernels (some tens of flops a nanosecond)."""
ADD_COST = 12.0
"""Time to add one entry of an update to the parent, in the same unit."""

Marks = NDArray[np.uint64]
Number = TypeVar("Number", float, Floats)


@inlined
def _mark(i: int) -> np.uint64:
    """A number of 64 bits for each i, as good as a random one (SplitMix64)."""
    z = np.uint64(i) * np.uint64(0x9E3779B97F4A7C15) + np.uint64(0x9E3779B97F4A7C15)
    z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return z ^ (z >> np.uint64(31))


@kernel
def add_marks(starts: Ints, cols: Ints, symmetric: bool, marks: Marks, of_row: Marks, of_column: Marks) -> None:
    """Add up the marks of the columns in each row and of the rows in each column of a pattern.

    Equal sums are those of equal sets. Of a symmetric pattern, of which one triangle is given, places on the diagonal count in
    ``of_row`` alone.
    """
    for i in range(len(marks)):
        marks[i] = _mark(i)
    for i in range(len(marks)):
        total = np.uint64(0)
        for k in range(starts[i], starts[i + 1]):
            j = number_at(cols, k)
            total += number_at(marks, j)
            if j != i or not symmetric:
                of_column[j] += marks[i]
        of_row[i] = total


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
def find_runs(starts: Ints, rows: Ints, fronts: Ints, parents: Ints, runs: Ints, firsts: Ints) -> int:
    """Runs of remaining rows that stay together in the parent; none crosses the end of its pivots.

    Args:
        starts, rows: positions of the remaining rows of each front, ascending.
        fronts: see :func:`lamella.solve.front_kernels.factorise`.
        parents: parent of each front, -1 for a root.
        runs: result: first row, first row in the parent, and length of each.
        firsts: result: where the runs of each front begin.

    Returns:
        The number of runs.
    """
    n = 0
    for f in range(len(parents)):
        firsts[f] = n
        if parents[f] < 0:
            continue
        first, p, at, last = fronts[parents[f], 0], fronts[parents[f], 1], starts[parents[f]], -2
        for k in range(starts[f], starts[f + 1]):
            place = rows[k] - first
            if place >= p:
                while rows[at] < rows[k]:
                    at += 1
                place = p + at - starts[parents[f]]
            if place != last + 1 or place == p:
                runs[n, 0], runs[n, 1], runs[n, 2] = k - starts[f], place, 0
                n += 1
            runs[n - 1, 2] += 1
            last = place
    firsts[len(parents)] = n
    return n


@kernel
def count_entries(
    starts: Ints, cols: Ints, position: Ints, front_at: Ints, coordinate: Ints,
    begins: Ints, diagonal: Ints, diagonal_position: Ints,
) -> int:  # fmt: skip
    """Where the entries of each front begin, those of padded pivots among them, and the entries on the diagonal.

    Args:
        starts, cols: the pattern in compressed rows.
        position: position of each coordinate.
        front_at: the front in which each position is eliminated.
        coordinate: coordinate at each position, -1 at padded pivots.
        begins: result, (n_front + 1,), zeros before.
        diagonal, diagonal_position: results: entries on the diagonal, and their positions.

    Returns:
        The number of entries on the diagonal.
    """
    n = 0
    for i in range(len(position)):
        p = position[i]
        for k in range(starts[i], starts[i + 1]):
            j = number_at(cols, k)
            begins[number_at(front_at, min(p, number_at(position, j))) + 1] += 1
            if j == i:
                diagonal[n], diagonal_position[n] = k, p
                n += 1
    for place in range(len(coordinate)):
        if coordinate[place] < 0:
            begins[front_at[place] + 1] += 1
    for f in range(1, len(begins)):
        begins[f] += begins[f - 1]
    return n


@kernel
def list_entries(
    starts: Ints, cols: Ints, position: Ints, front_at: Ints, coordinate: Ints, begins: Ints,
    fronts: Ints, rest: Ints, ends: Ints, local: Ints, columns: Ints, numbers: Indices, slots: Indices,
) -> None:  # fmt: skip
    """The entries of each front with their places in the panels, padded pivots, of the number -1, behind the others.

    Args:
        starts, cols, position, front_at, coordinate, begins: see :func:`count_entries`.
        fronts, rest: fronts and their remaining rows, see :func:`lamella.solve.front_kernels.factorise`.
        ends: workspace (n_front,), a copy of where each front begins.
        local: workspace, as long as there are positions.
        columns: workspace, as long as there are entries.
        numbers, slots: results: number and place of each entry.
    """
    for i in range(len(position)):
        p = position[i]
        for k in range(starts[i], starts[i + 1]):
            q = number_at(position, number_at(cols, k))
            front = number_at(front_at, min(p, q))
            at = number_at(ends, front)
            ends[front] = at + 1
            numbers[at], columns[at], slots[at] = k, min(p, q), max(p, q)
    for place in range(len(coordinate)):
        if coordinate[place] < 0:
            at = ends[front_at[place]]
            ends[front_at[place]] += 1
            numbers[at], columns[at], slots[at] = -1, place, place
    for f in range(len(begins) - 1):
        first, p, a_len, a0, more = fronts[f, 0], fronts[f, 1], fronts[f, 2], fronts[f, 3], fronts[f, 7]
        for i in range(p):
            local[first + i] = i
        for i in range(fronts[f, 4]):
            local[rest[more + i]] = p + i
        for at in range(begins[f], begins[f + 1]):
            slots[at] = a0 + (number_at(columns, at) - first) * a_len + number_at(local, number_at(slots, at))
