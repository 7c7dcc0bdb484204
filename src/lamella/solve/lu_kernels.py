"""Compiled kernels of the multifrontal factorisation A = L U of an unsymmetric matrix with a symmetric pattern.

L and U^T are two lower triangles, held in two sets of panels and updates that are laid out as the one of
:mod:`lamella.solve.front_kernels`. The diagonal of A comes in with L, whose own is 1 at the end; U holds the pivots.
"""

# Stores of one tile stand side by side, as its rows do.
# pyright: reportUnusedExpression=false
from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from lamella._jit import inlined, inner, kernel
from lamella.lane import WIDTH, load_at, number_at, put_at, store_at
from lamella.roles import Floats, Indices, Ints
from lamella.solve.front_kernels import BLOCK, clear, extend_add, invert_corner, pack, subtract


class Entries(NamedTuple):
    """Values of a matrix, front after front, so that a panel is filled just before it is factorised.

    Args:
        sources: number of each value in the first or the second of two arrays.
        slots: its place in the panels, without sign, so that Numba does not look for negative ones.
        starts: where the values of each front from the first and from the second array begin, and where they all end,
            shape (2 n_front + 1,).
    """

    sources: Indices
    slots: NDArray[np.uint32]
    starts: Ints


@inlined
def value(k: Floats, more: Floats, source: int) -> float:
    """The value of a source: its number among those of the first array, or -1 less its number among those of the second."""
    return number_at(k, source) if source >= 0 else number_at(more, -1 - source)


@kernel
def sizes(k: Floats, more: Floats, sources: Indices, places: Ints, out: Floats) -> None:
    """out[places] = absolute values."""
    for i in range(len(sources)):
        out[places[i]] = abs(value(k, more, sources[i]))


@inner
def _factorise_corner(a: Floats, c: Floats, corner: int, a_len: int, limits: Floats, s0: int) -> int:
    """L U of a 4 by 4 block, L in a[corner] and U^T in c[corner]; -1, or the column whose pivot is within its limit."""
    for i in range(4):
        column = corner + i * a_len
        pivot = a[column + i]
        if not abs(pivot) > limits[s0 + i]:
            return i
        a[column + i], c[column + i] = 1.0, pivot
        for row in range(i + 1, 4):
            a[column + row] /= pivot
        for k in range(i + 1, 4):
            below = corner + k * a_len
            a[below + k] -= a[column + k] * c[column + k]
            for row in range(k + 1, 4):
                a[below + row] -= a[column + row] * c[column + k]
                c[below + row] -= a[column + k] * c[column + row]
    return -1


@inner
def _factorise_columns(a: Floats, c: Floats, a0: int, a_len: int, j: int, limits: Floats, s0: int) -> int:
    """Factorise columns j ... j + 3 of the panels at a0, from which all columns before are already subtracted."""
    failed = _factorise_corner(a, c, a0 + j * (a_len + 1), a_len, limits, s0 + j)
    if failed >= 0:
        return j + failed
    c0 = a0 + j * a_len
    c1, c2, c3 = c0 + a_len, c0 + 2 * a_len, c0 + 3 * a_len
    l10, l20, l30 = a[c0 + j + 1], a[c0 + j + 2], a[c0 + j + 3]
    l21, l31, l32 = a[c1 + j + 2], a[c1 + j + 3], a[c2 + j + 3]
    u10, u20, u30 = c[c0 + j + 1], c[c0 + j + 2], c[c0 + j + 3]
    u21, u31, u32 = c[c1 + j + 2], c[c1 + j + 3], c[c2 + j + 3]
    d0, d1, d2, d3 = 1.0 / c[c0 + j], 1.0 / c[c1 + j + 1], 1.0 / c[c2 + j + 2], 1.0 / c[c3 + j + 3]
    row = j + 4
    while row % WIDTH:
        x0 = a[c0 + row] * d0
        x1 = (a[c1 + row] - u10 * x0) * d1
        x2 = (a[c2 + row] - u20 * x0 - u21 * x1) * d2
        a[c3 + row] = (a[c3 + row] - u30 * x0 - u31 * x1 - u32 * x2) * d3
        a[c0 + row], a[c1 + row], a[c2 + row] = x0, x1, x2
        x0 = c[c0 + row]
        x1 = c[c1 + row] - l10 * x0
        x2 = c[c2 + row] - l20 * x0 - l21 * x1
        c[c3 + row] -= l30 * x0 + l31 * x1 + l32 * x2
        c[c1 + row], c[c2 + row] = x1, x2
        row += 1
    while row < a_len:
        y0 = load_at(a, c0 + row) * d0
        y1 = (load_at(a, c1 + row) - u10 * y0) * d1
        y2 = (load_at(a, c2 + row) - u20 * y0 - u21 * y1) * d2
        y3 = (load_at(a, c3 + row) - u30 * y0 - u31 * y1 - u32 * y2) * d3
        store_at(a, c0 + row, y0), store_at(a, c1 + row, y1), store_at(a, c2 + row, y2), store_at(a, c3 + row, y3)
        y0 = load_at(c, c0 + row)
        y1 = load_at(c, c1 + row) - l10 * y0
        y2 = load_at(c, c2 + row) - l20 * y0 - l21 * y1
        y3 = load_at(c, c3 + row) - l30 * y0 - l31 * y1 - l32 * y2
        store_at(c, c1 + row, y1), store_at(c, c2 + row, y2), store_at(c, c3 + row, y3)
        row += WIDTH
    invert_corner(a, a0 + j * (a_len + 1), a_len)
    invert_corner(c, a0 + j * (a_len + 1), a_len)
    return -1


@inner
def _subtract_both(
    t: Floats, w: Floats, t0: int, t_len: int, rows: int, columns: int, a: Floats, c: Floats, a0: int, packed: int,
    a_len: int, ones: Floats, b: Floats, n: int,
) -> None:  # fmt: skip
    """T -= L U and W -= U^T L^T on their lower triangles (rows, columns), from n columns of the panels.

    Rows begin at a0, and the columns of T are those of U at ``packed``; T and W lie at t0.
    """
    pack(c, packed, a_len, columns, ones, 0, b, n)
    subtract(t, t0, t_len, rows, columns, a, a0, a_len, b, 0, n)
    pack(a, packed, a_len, columns, ones, 0, b, n)
    subtract(w, t0, t_len, rows, columns, c, a0, a_len, b, 0, n)


@inner
def _factorise_front(
    a: Floats, c: Floats, a0: int, a_len: int, p: int, u: Floats, v: Floats, u0: int, u_len: int, limits: Floats, s0: int,
    ones: Floats, b: Floats,
) -> int:  # fmt: skip
    """Factorise two panels and subtract their product from the updates; -1, or the pivot that failed."""
    for first in range(0, p, BLOCK):
        last = min(first + BLOCK, p)
        left = a0 + first * a_len
        for j in range(first, last, 4):
            n, start = j - first, j - j % WIDTH
            if n:
                to, rows = a0 + j * a_len + start, a_len - start
                _subtract_both(a, c, to, a_len, rows, min(4, p - j), a, c, left + start, left + j, a_len, ones, b, n)
            failed = _factorise_columns(a, c, a0, a_len, j, limits, s0)
            if failed >= 0:
                return failed
        n = last - first
        if last < p:
            to, at = a0 + last * (a_len + 1), left + last
            _subtract_both(a, c, to, a_len, a_len - last, p - last, a, c, at, at, a_len, ones, b, n)
        if u_len:
            _subtract_both(u, v, u0, u_len, u_len, u_len, a, c, left + p, left + p, a_len, ones, b, n)
    return -1


@kernel
def factorise(
    k: Floats, more: Floats, entries: Entries, ones_at: Ints, fronts: Ints, runs: Ints, limits: Floats,
    panels: Floats, a: Floats, c: Floats, u: Floats, v: Floats, ones: Floats, b: Floats,
) -> int:  # fmt: skip
    """Factorise all fronts, children before parents.

    Args:
        k, more: values of the matrix, in two arrays.
        entries: where its values go.
        ones_at: positions in ``a`` of padded pivots, ascending.
        fronts, runs: as in :func:`lamella.solve.front_kernels.factorise`.
        limits: magnitude that a pivot must exceed, by position.
        panels: all panels, and ``WIDTH``.
        a, c: the two halves of ``panels``, overwritten by L and U^T.
        u, v: their updates (workspace).
        ones: ones, as many as ``BLOCK``.
        b: workspace of ``BLOCK`` times the longest panel column, and ``WIDTH``.

    Returns:
        -1, or the position whose pivot is within its limit.
    """
    padded = 0
    for f in range(len(fronts) - 1):
        first, p, a_len, a0, u_len, u0 = fronts[f, 0], fronts[f, 1], fronts[f, 2], fronts[f, 3], fronts[f, 5], fronts[f, 6]
        end = a0 + p * a_len
        clear(a, a0, p * a_len)
        clear(c, a0, p * a_len)
        for i in range(entries.starts[2 * f], entries.starts[2 * f + 1]):
            put_at(panels, number_at(entries.slots, i), number_at(k, number_at(entries.sources, i)))
        for i in range(entries.starts[2 * f + 1], entries.starts[2 * f + 2]):
            put_at(panels, number_at(entries.slots, i), number_at(more, number_at(entries.sources, i)))
        while padded < len(ones_at) and ones_at[padded] < end:
            a[ones_at[padded]] = 1.0
            padded += 1
        clear(u, u0, u_len * u_len)
        clear(v, u0, u_len * u_len)
        child = fronts[f, 9]
        while child >= 0:
            r0, r1 = fronts[child, 8], fronts[child + 1, 8]
            extend_add(u, fronts[child, 6], fronts[child, 5], runs, r0, r1, a, a0, a_len, p, u0, u_len)
            extend_add(v, fronts[child, 6], fronts[child, 5], runs, r0, r1, c, a0, a_len, p, u0, u_len)
            child = fronts[child, 10]
        failed = _factorise_front(a, c, a0, a_len, p, u, v, u0, u_len, limits, first, ones, b)
        if failed >= 0:
            return first + failed
    return -1
