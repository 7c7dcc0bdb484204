"""Compiled forward and back substitution with the fronts of a multifrontal factorisation."""

from __future__ import annotations

from lamella import lane
from lamella._jit import njit
from lamella.roles import Floats, Ints


@njit
def _forward(a: Floats, a0: int, a_len: int, p: int, y: Floats) -> None:
    """y <- L^-1 y for the pivots, rest of y minus what they cause."""
    for k in range(p):
        column = a0 + k * a_len
        x = y[k] / a[column + k]
        y[k] = x
        row = k + 1
        while row % 8:
            y[row] -= a[column + row] * x
            row += 1
        while row < a_len:
            lane.store(y, row, lane.load(y, row) - x * lane.load(a, column + row))
            row += 8


@njit
def _backward(a: Floats, a0: int, a_len: int, p: int, y: Floats) -> None:
    """y <- L^-T y for the pivots, with the rest of y known; the eight entries behind it are workspace."""
    for k in range(p - 1, -1, -1):
        column = a0 + k * a_len
        x = y[k]
        row = k + 1
        while row % 8:
            x -= a[column + row] * y[row]
            row += 1
        part = lane.spread(0.0)
        while row < a_len:
            part = part + lane.load(a, column + row) * lane.load(y, row)
            row += 8
        lane.store(y, a_len, part)
        for i in range(a_len, a_len + 8):
            x -= y[i]
        y[k] = x / a[column + k]


@njit
def solve(fronts: Ints, rows: Ints, a: Floats, signs: Floats, x: Floats, y: Floats) -> None:
    """x <- K^-1 x, by position.

    Args:
        fronts: as in :func:`lamella.solve.front_kernels.factorise`.
        rows: position of each remaining row, front after front.
        a: panels with L.
        signs: signs S by position.
        x: right-hand side and solution by position, zero at padded pivots.
        y: workspace of the longest panel column and eight more entries.
    """
    for f in range(len(fronts) - 1):
        first, p, a_len, a0, n, start = fronts[f, 0], fronts[f, 1], fronts[f, 2], fronts[f, 3], fronts[f, 4], fronts[f, 7]
        for i in range(p):
            y[i] = x[first + i]
        for i in range(p, a_len):
            y[i] = 0.0
        _forward(a, a0, a_len, p, y)
        for i in range(p):
            x[first + i] = y[i] * signs[first + i]
        for i in range(n):
            x[rows[start + i]] += y[p + i]
    for f in range(len(fronts) - 2, -1, -1):
        first, p, a_len, a0, n, start = fronts[f, 0], fronts[f, 1], fronts[f, 2], fronts[f, 3], fronts[f, 4], fronts[f, 7]
        for i in range(p):
            y[i] = x[first + i]
        for i in range(n):
            y[p + i] = x[rows[start + i]]
        for i in range(p + n, a_len):
            y[i] = 0.0
        _backward(a, a0, a_len, p, y)
        for i in range(p):
            x[first + i] = y[i]
