"""The loops that find a matrix's pattern, against NumPy's sorting."""

from __future__ import annotations

import numpy as np
import pytest

from lamella.assembly.pattern_kernels import FEW, in_layers, numbered, runs_of, sorted_by, tabulated

PARTS = np.array([0, 7, 7, 12, 40])


def contributions(n: int = 300) -> np.ndarray:
    """Sources that come up to some ten times, with gaps and with a part that has none."""
    sources = np.random.default_rng(5).integers(0, 35, n)
    return sources[(sources != 3) & (sources != 20)]


def test_entries_are_sorted_by_counting_and_keep_their_order():
    keys = contributions()
    order, ends = sorted_by(keys, 40)
    np.testing.assert_array_equal(order, np.argsort(keys, kind="stable"))
    np.testing.assert_array_equal(ends[:-1], np.cumsum(np.bincount(keys, minlength=40)))


def test_contributions_come_by_part_layer_and_source():
    sources = contributions()
    layer = np.array([np.count_nonzero(sources[:i] == source) for i, source in enumerate(sources)])
    expected = np.lexsort((sources, layer, np.searchsorted(PARTS, sources, side="right")))
    np.testing.assert_array_equal(in_layers(sources, PARTS), expected)


def test_runs_are_consecutive_and_end_at_parts():
    sources = contributions()
    ordered = sources[in_layers(sources, PARTS)]
    starts, runs = runs_of(ordered, PARTS)
    assert runs[0, 0] == 0
    assert runs[-1, 1] == len(ordered)
    np.testing.assert_array_equal(runs[1:, 0], runs[:-1, 1])
    for first, end, ahead in runs:
        np.testing.assert_array_equal(ordered[first:end], np.arange(first, end) + ahead)
    for part in range(len(PARTS) - 1):
        own = [source for first, end, _ in runs[starts[part] : starts[part + 1]] for source in ordered[first:end]]
        np.testing.assert_array_equal(np.sort(own), np.sort(sources[(sources >= PARTS[part]) & (sources < PARTS[part + 1])]))
    part_of = np.searchsorted(PARTS, ordered, side="right")
    breaks = (np.diff(ordered, prepend=-2) != 1) | (np.diff(part_of, prepend=-1) != 0)
    np.testing.assert_array_equal(runs[:, 0], np.flatnonzero(breaks))


def test_nothing_to_sum_has_no_runs():
    nothing = np.zeros(0, np.int64)
    starts, runs = runs_of(nothing, PARTS)
    assert runs.shape == (0, 3)
    np.testing.assert_array_equal(starts, 0)
    assert len(in_layers(nothing, PARTS)) == len(numbered(nothing, nothing, 0, 5)[1]) == len(tabulated(np.zeros(0))[0]) == 0


@pytest.mark.parametrize("different", [1, 20, FEW, FEW + 1, 70_000])
def test_factors_are_told_by_their_place_in_a_table(different: int):
    rng = np.random.default_rng(1)
    factors = rng.permutation(np.concatenate([rng.standard_normal(different), rng.standard_normal(1).repeat(50)]))
    table, codes = tabulated(factors)
    np.testing.assert_array_equal(np.sort(table), np.unique(factors))
    np.testing.assert_array_equal(table[codes], factors)
    assert codes.itemsize == (2 if different < 2**16 - 1 else 4)


def test_places_are_numbered_row_by_row():
    rng = np.random.default_rng(2)
    rows, cols = rng.integers(0, 20, 300), rng.integers(0, 30, 300)
    rows[rows == 7] = 8  # a row without entries
    indptr, indices, slots = numbered(rows, cols, 20, 30)
    expected, inverse = np.unique(rows * 30 + cols, return_inverse=True)
    np.testing.assert_array_equal(np.repeat(np.arange(20), np.diff(indptr)) * 30 + indices, expected)
    np.testing.assert_array_equal(slots, inverse)
