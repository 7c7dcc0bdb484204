"""Sums of the contraction to tangents: as many at once as registers hold, to the same bits either way."""

from __future__ import annotations

import numpy as np
import pytest

from lamella._jit import kernel
from lamella.element.plate48.contraction import four_rows, line_sum, line_sums, two_rows
from lamella.element.plate48.shape import hermite_table
from lamella.lane import WIDTH, aligned, store
from lamella.roles import Floats


@kernel
def _lines(work: Floats, table: Floats, n: int, b: int, alone: Floats, together: Floats) -> None:
    one, other = line_sum(work, 0, table, n, b), line_sum(work, 0, table, n, b + 1)
    t, u = line_sums(work, 0, table, n, b)
    for i in range(3):
        for k in range(3):
            store(alone, 3 * i + k, one[i][k])
            store(alone, 9 + 3 * i + k, other[i][k])
            store(together, 3 * i + k, t[i][k])
            store(together, 9 + 3 * i + k, u[i][k])


@kernel
def _rows(work: Floats, table: Floats, n: int, b: int, alone: Floats, together: Floats) -> None:
    k0, k1 = two_rows(work, 0, table, n, 0)
    k2, k3 = two_rows(work, 0, table, n, 2)
    all_rows = four_rows(work, 0, table, n)
    for m in range(4):
        store(alone, m, k0[m])
        store(alone, 4 + m, k1[m])
        store(alone, 8 + m, k2[m])
        store(alone, 12 + m, k3[m])
        for a in range(4):
            store(together, 4 * a + m, all_rows[a][m])


@pytest.mark.parametrize(("contract", "places"), [(_lines, (0, 2)), (_rows, (0,))])
@pytest.mark.parametrize("n", [3, 4])
def test_fewer_sums_at_once_are_the_same(contract, places, n):
    work, table = aligned(15 * n * WIDTH), hermite_table(n)
    work[:] = np.random.default_rng(n).standard_normal(len(work))
    for b in places:
        alone, together = aligned(18 * WIDTH), aligned(18 * WIDTH)
        contract(work, table, n, b, alone, together)
        assert np.count_nonzero(alone) >= 16 * WIDTH
        np.testing.assert_array_equal(alone, together)
