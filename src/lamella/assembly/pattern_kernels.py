"""Loops over all contributions to a matrix, which are walked once when its pattern is found."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lamella._jit import kernel
from lamella.lane import number_at
from lamella.roles import Floats, Indices, Ints

Unsigned = NDArray[np.uint32]
Marks = NDArray[np.uint64]

FEW = 1024
"""Different factors that are found by their bits; more are sorted."""


def sorted_by(keys: Ints | Unsigned, n_keys: int, order: Ints | None = None) -> tuple[Ints, Ints]:
    """An order of entries, stably sorted by their keys in [0, n_keys), by counting; and where each key's entries end."""
    ends, out = np.zeros(n_keys + 1, np.int64), np.empty(len(keys), np.int64)
    _sort(np.ascontiguousarray(keys), np.arange(len(keys)) if order is None else np.ascontiguousarray(order), ends, out)
    return out, ends


def in_layers(sources: Ints | Unsigned, parts: Ints) -> Ints:
    """The order of contributions by part of the buffer, and within one by layer: the first of each source, then the second ones.

    Args:
        sources: place in the buffer of each contribution, shape (n,).
        parts: where each part begins, and where the last ends, shape (n_part + 1,).
    """
    order, ends = sorted_by(sources, int(parts[-1]))
    out = np.empty_like(order)
    _layer(order, ends, parts, np.empty(int(np.diff(parts).max(initial=0)), np.int64), out)
    return out


def runs_of(sources: Ints | Unsigned, parts: Ints) -> tuple[Ints, Ints]:
    """Runs of consecutive sources of ordered contributions: the first of each part, shape (n_part + 1,), and (first, end, ahead)
    of each, shape (n, 3): contribution i of a run has the source i + ahead.
    """
    starts = np.zeros(len(parts), np.int64)
    runs = np.empty((_runs(sources, parts, starts, np.empty((0, 3), np.int64)), 3), np.int64)
    _runs(sources, parts, starts, runs)
    return starts, runs


def tabulated(factors: Floats) -> tuple[Floats, NDArray[np.integer]]:
    """The different factors, and which of them each is."""
    table, codes = np.empty(FEW), np.empty(len(factors), np.uint16)
    n = _tabulate(factors, factors.view(np.uint64), np.full(4 * FEW, -1), table, codes)
    if n >= 0:
        return table[:n].copy(), codes
    table = np.unique(factors)
    return table, np.searchsorted(table, factors).astype(np.uint16 if len(table) <= np.iinfo(np.uint16).max else np.int32)


def numbered(rows: Ints, cols: Ints, n_rows: int, n_cols: int) -> tuple[Ints, Ints, Ints]:
    """The places (row, col) that occur, in compressed rows of ascending columns, and which of them each entry has."""
    order, ends = sorted_by(rows, n_rows, sorted_by(cols, n_cols)[0])
    indptr, indices, slots = np.zeros(n_rows + 1, np.int64), np.empty(len(rows), np.int64), np.empty(len(rows), np.int64)
    count = _number(np.ascontiguousarray(cols), order, ends, indptr, indices, slots)
    return indptr, indices[:count].copy(), slots


@kernel
def _sort(keys: NDArray[np.integer], order: Ints, ends: Ints, out: Ints) -> None:
    for i in range(len(keys)):
        ends[number_at(keys, i) + 1] += 1
    for k in range(1, len(ends)):
        ends[k] += ends[k - 1]
    for i in range(len(order)):
        entry = number_at(order, i)
        key = number_at(keys, entry)
        at = number_at(ends, key)
        out[at], ends[key] = entry, at + 1


@kernel
def _layer(order: Ints, ends: Ints, parts: Ints, active: Ints, out: Ints) -> None:
    """``active`` lists the sources of a part that have contributions left."""
    at = 0
    for part in range(len(parts) - 1):
        left, layer = parts[part + 1] - parts[part], 0
        for a in range(left):
            active[a] = parts[part] + a
        while left:
            more = 0
            for a in range(left):
                source = active[a]
                i = layer + (ends[source - 1] if source else 0)
                if i < ends[source]:
                    out[at] = order[i]
                    at += 1
                if i + 1 < ends[source]:
                    active[more] = source
                    more += 1
            left, layer = more, layer + 1


@kernel
def _runs(sources: Ints | Unsigned, parts: Ints, starts: Ints, runs: Ints) -> int:
    """The number of runs; they are written where ``runs`` has room."""
    n, part = 0, 0
    for i in range(len(sources)):
        begins = i == 0 or sources[i] != sources[i - 1] + 1
        while sources[i] >= parts[part + 1]:
            part += 1
            starts[part] = n
            begins = True
        if begins:
            if n < len(runs):
                runs[n, 0], runs[n, 2] = i, sources[i] - i
                if n:
                    runs[n - 1, 1] = i
            n += 1
    for later in range(part + 1, len(parts)):
        starts[later] = n
    if n and n <= len(runs):
        runs[n - 1, 1] = len(sources)
    return n


@kernel
def _tabulate(factors: Floats, bits: Marks, places: Ints, table: Floats, codes: NDArray[np.uint16]) -> int:
    """The number of different factors, written to ``table``; -1 when it is too short.

    Args:
        factors, bits: the factors, and their bits as numbers, by which they are found.
        places: workspace four times as long as the table, -1: where a factor is, if it is there, from its place on.
        table, codes: results.
    """
    n, code = 0, 0
    for i in range(len(factors)):
        if n == 0 or factors[i] != table[code]:
            place = int((bits[i] * np.uint64(0x9E3779B97F4A7C15)) >> np.uint64(40)) % len(places)
            while places[place] >= 0 and table[places[place]] != factors[i]:
                place = (place + 1) % len(places)
            if places[place] < 0:
                if n == len(table):
                    return -1
                table[n], places[place] = factors[i], n
                n += 1
            code = places[place]
        codes[i] = code
    return n


@kernel
def _number(cols: Ints, order: Ints, ends: Ints, indptr: Ints, indices: Ints, slots: Ints) -> int:
    count, at = 0, 0
    for row in range(len(indptr) - 1):
        last = -1
        for k in range(at, ends[row]):
            i = number_at(order, k)
            if number_at(cols, i) != last:
                last = number_at(cols, i)
                indices[count] = last
                count += 1
            slots[i] = count - 1
        at = ends[row]
        indptr[row + 1] = count
    return count


@kernel
def count_terms(targets: Ints, lengths: Ints) -> int:
    """Add up how many terms each sum has; the most."""
    longest = 0
    for i in range(len(targets)):
        lengths[targets[i]] += 1
        longest = max(longest, int(lengths[targets[i]]))
    return longest


@kernel
def order_terms(
    targets: Ints, sources: Ints, factors: Floats, lengths: Ints, begins: Ints,
    group_ends: Indices, order: Unsigned, ordered_sources: Unsigned, ordered_factors: Floats,
) -> None:  # fmt: skip
    """Terms of sums, those of the shortest sums first.

    Args:
        targets, sources, factors: the sum, the source and the factor of each term.
        lengths: how many terms each sum has.
        begins: workspace (n_targets,).
        group_ends: result: 0, and how many sums have up to 0, 1, 2, ... terms; zeros before.
        order: result: the sums, ordered.
        ordered_sources, ordered_factors: results: the terms, ordered.
    """
    for target in range(len(lengths)):
        group_ends[lengths[target] + 1] += 1
    for length in range(1, len(group_ends)):
        group_ends[length] += group_ends[length - 1]
    for target in range(len(lengths)):  # each group is filled from where the one before ends
        order[group_ends[lengths[target]]] = target
        group_ends[lengths[target]] += 1
    for length in range(len(group_ends) - 1, 0, -1):
        group_ends[length] = group_ends[length - 1]
    group_ends[0] = 0
    at = 0
    for i in range(len(order)):
        begins[order[i]] = at
        at += lengths[order[i]]
    for i in range(len(targets)):
        at = begins[targets[i]]
        begins[targets[i]] += 1
        ordered_sources[at], ordered_factors[at] = sources[i], factors[i]


@kernel
def plain_entries(
    rows: Ints, cols: Ints, scale: Floats, indptr: Ints, indices: Ints, data: Floats,
    u: Ints, v: Ints, sources: Ints, x: Floats, others: Ints,
) -> tuple[int, int]:  # fmt: skip
    """Entries of a symmetric block whose two coordinates each follow one independent coordinate, in the upper triangle.

    Args:
        rows, cols: coordinates of the entries, -1 for padding, shape (n,).
        scale: factor of each entry.
        indptr, indices, data: the map from independent to all coordinates.
        u, v, sources, x: results: place, entry and factor of each, shapes (n,).
        others: result: entries of coordinates that follow several.

    Returns:
        The numbers of both kinds; entries of a coordinate that is held are of neither.
    """
    n = m = 0
    for k in range(len(rows)):
        if rows[k] < 0 or cols[k] < 0:
            continue
        i, j = indptr[rows[k]], indptr[cols[k]]
        many_i, many_j = indptr[rows[k] + 1] - i, indptr[cols[k] + 1] - j
        if many_i == 0 or many_j == 0:
            continue
        if many_i > 1 or many_j > 1:
            others[m] = k
            m += 1
            continue
        u[n], v[n] = min(indices[i], indices[j]), max(indices[i], indices[j])
        x[n] = scale[k] * data[i] * data[j]
        if indices[i] == indices[j] and i != j:
            x[n] *= 2.0  # the entry and its mirror image fall on the diagonal
        sources[n] = k
        n += 1
    return n, m
