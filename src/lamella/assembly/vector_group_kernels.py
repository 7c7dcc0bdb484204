"""Compiled loops over groups of coordinates and over the entries of element tables."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lamella._jit import inlined, kernel
from lamella.lane import WIDTH, number_at
from lamella.roles import Floats, Ints

Places = NDArray[np.uint32]


@kernel
def find_members(u: Ints, group_of: Ints, n: int, local: Ints, members: Ints, counts: Ints) -> int:
    """The groups of each element of a table.

    Args:
        u: independent coordinate of each of the ``n`` coordinates of an element, negative for none, (block, n, WIDTH), flat.
        group_of: group of each independent coordinate.
        n: coordinates of an element.
        local: result: number of the group of each coordinate among those of the element, as ``u``.
        members: result: groups of each element, (block, WIDTH, n), flat.
        counts: result: their number, (block, WIDTH), flat.

    Returns:
        The number of pairs of groups, those with themselves included.
    """
    total = 0
    for element in range(len(counts)):
        block, lane = element // WIDTH, element % WIDTH
        count, last = 0, -1
        for a in range(n):
            at = (block * n + a) * WIDTH + lane
            if u[at] < 0:
                continue
            group = group_of[u[at]]
            if last < 0 or members[element * n + last] != group:
                last = 0
                while last < count and members[element * n + last] != group:
                    last += 1
                members[element * n + last] = group
                count = max(count, last + 1)
            local[at] = last
        counts[element] = count
        total += count * (count + 1) // 2
    return total


@kernel
def list_pairs(members: Ints, counts: Ints, n: int, first: Ints, second: Ints) -> None:
    """The pairs of groups of each element."""
    k = 0
    for element in range(len(counts)):
        for i in range(element * n, element * n + counts[element]):
            for j in range(i, element * n + counts[element]):
                first[k], second[k] = members[i], members[j]
                k += 1


@kernel
def list_pairs_of(rows: Ints, cols: Ints, group_of: Ints, first: Ints, second: Ints) -> int:
    """The pairs of groups of some entries, without those that repeat the one before; their number."""
    n = 0
    for k in range(len(rows)):
        a, b = group_of[rows[k]], group_of[cols[k]]
        if n == 0 or first[n - 1] != a or second[n - 1] != b:
            first[n], second[n] = a, b
            n += 1
    return n


@kernel
def list_pairs_of_mass(i: Ints, j: Ints, one: Ints, group_of: Ints, first: Ints, second: Ints, others: Ints) -> tuple[int, int]:
    """The pairs of groups that pairs of vectors couple component by component, without those that repeat the one before.

    Args:
        i, j: vectors.
        one: see :class:`lamella.assembly.vector_groups.Followed`.
        group_of: group of each independent coordinate.
        first, second: results, three times as long.
        others: result: which pairs of vectors have a coordinate that follows several.

    Returns:
        The numbers of both kinds.
    """
    n = m = 0
    for k in range(len(i)):
        several = False
        for c in range(3):
            row, col = number_at(one, 3 * number_at(i, k) + c), number_at(one, 3 * number_at(j, k) + c)
            if row >= 0 and col >= 0:
                a, b = number_at(group_of, row), number_at(group_of, col)
                if n == 0 or first[n - 1] != a or second[n - 1] != b:
                    first[n], second[n] = a, b
                    n += 1
            several |= row != -1 and col != -1 and (row < -1 or col < -1)
        if several:
            others[m] = k
            m += 1
    return n, m


@kernel
def count_places(starts: Ints, groups: Ints, first: Ints, symmetric: bool, shift: Ints, lead: Ints, indptr: Ints) -> None:
    """Where the places of each row begin. The place of (row, col) is lead[row] + col + shift of their pair of groups.

    Args:
        starts, groups: pairs of groups in compressed rows.
        first: first coordinate of each group, and the number of all.
        symmetric: whether places below the diagonal are left out.
        shift, lead, indptr: results.
    """
    for a in range(len(first) - 1):
        width = 0
        for pair in range(starts[a], starts[a + 1]):
            shift[pair] = width - first[groups[pair]] + (first[a] if symmetric else 0)
            width += first[groups[pair] + 1] - first[groups[pair]]
        for row in range(first[a], first[a + 1]):
            indptr[row + 1] = indptr[row] + width - (row - first[a] if symmetric else 0)
            lead[row] = indptr[row] - (row if symmetric else 0)


@kernel
def list_places(starts: Ints, groups: Ints, first: Ints, symmetric: bool, indices: Ints) -> None:
    """The column of each place."""
    k = 0
    for a in range(len(first) - 1):
        for row in range(first[a], first[a + 1]):
            for pair in range(starts[a], starts[a + 1]):
                for col in range(first[groups[pair]], first[groups[pair] + 1]):
                    if not symmetric or col >= row:
                        indices[k] = col
                        k += 1


@inlined
def _pair(starts: Ints, groups: Ints, a: int, b: int) -> int:
    """The number of a pair of groups."""
    low, high = starts[a], starts[a + 1] - 1
    while low < high:
        middle = (low + high) // 2
        if groups[middle] < b:
            low = middle + 1
        else:
            high = middle
    return low


@kernel
def find_places(
    rows: Ints, cols: Ints, symmetric: bool, group_of: Ints, starts: Ints, groups: Ints, lead: Ints, shift: Ints, slots: Ints
) -> None:
    """The place of each entry."""
    last_a, last_b, pair = -1, -1, 0
    for k in range(len(rows)):
        row, col = rows[k], cols[k]
        if symmetric and row > col:
            row, col = col, row
        a, b = int(group_of[row]), int(group_of[col])
        if a != last_a or b != last_b:
            last_a, last_b, pair = a, b, _pair(starts, groups, a, b)
        slots[k] = lead[row] + col + shift[pair]


@kernel
def place_tables(
    u: Ints, scale: Floats, rows: Ints, columns: Ints, n: int, local: Ints, members: Ints, counts: Ints,
    starts: Ints, groups: Ints, lead: Ints, shift: Ints, most: int, shifts: Ints,
    slots: Places, sources: Places, factors: Floats,
) -> int:  # fmt: skip
    """Places of the entries of symmetric elements in the upper triangle.

    Args:
        u, n, local, members, counts: see :func:`find_members`.
        scale: factor of each coordinate, as ``u``.
        rows, columns: coordinates of each entry of an element.
        starts, groups, lead, shift: see :func:`count_places`.
        most: the largest number of groups of an element.
        shifts: workspace (WIDTH, most, most), flat.
        slots, sources, factors: results: place, number in the buffer, and factor of each entry.

    Returns:
        The number of entries; those of a coordinate that is held are left out.
    """
    found = k = 0
    for block in range(len(counts) // WIDTH):
        for lane in range(WIDTH):
            element = block * WIDTH + lane
            for i in range(counts[element]):
                for j in range(i, counts[element]):
                    a, b = int(members[element * n + i]), int(members[element * n + j])
                    pair = _pair(starts, groups, min(a, b), max(a, b))
                    shifts[(lane * most + i) * most + j] = shifts[(lane * most + j) * most + i] = shift[pair]
        for entry in range(len(rows)):
            at_row, at_column = (block * n + rows[entry]) * WIDTH, (block * n + columns[entry]) * WIDTH
            for lane in range(WIDTH):
                i, j = at_row + lane, at_column + lane
                row, col = number_at(u, i), number_at(u, j)
                if row >= 0 and col >= 0:
                    between = number_at(shifts, (lane * most + number_at(local, i)) * most + number_at(local, j))
                    slots[found] = number_at(lead, min(row, col)) + max(row, col) + between
                    # The entry and its mirror image fall on the diagonal where two coordinates follow the same one.
                    factors[found] = number_at(scale, i) * number_at(scale, j) * (2.0 if row == col and i != j else 1.0)
                    sources[found] = k
                    found += 1
                k += 1
    return found
