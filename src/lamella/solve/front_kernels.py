"""Compiled kernels of the multifrontal factorisation: dense fronts, a lane of rows at a time.

A front of p pivots and u remaining rows is held as a *panel* (its first p columns, all rows) and an *update* (the u by u rest),
both by columns, of which the lower triangles count. Column lengths are multiples of ``WIDTH`` and p of 4; padding is zero, padded
pivots are 1. The factorisation is K = L S L^T with S = diag(+-1), which is Cholesky's when all signs are positive.
Of the 4 by 4 blocks of L on the diagonal a panel keeps L below it and L^-1 transposed on and above it (:func:`invert_corner`).
"""

# Stores of one tile stand side by side, as its rows do.
# pyright: reportUnusedExpression=false
from __future__ import annotations

import math

from lamella._jit import inlined, inner, shared
from lamella.lane import WIDTH, load_at, number_at, put_at, store_at
from lamella.roles import Floats, Indices, Ints, Reals

BLOCK = 96
"""Columns of a panel that are factorised before the rest is updated: 3 ``WIDTH`` rows of them stay in the first-level cache."""


@inlined
def _subtract_tall(c: Floats, c0: int, c_len: int, a: Floats, a0: int, a_len: int, b: Floats, b0: int, n: int) -> None:
    """C -= A B for 3 WIDTH rows and 4 columns: A (rows, n) at a[a0] and C at c[c0] by columns, B (n, 4) at b[b0] by rows."""
    c1, c2, c3 = c0 + c_len, c0 + 2 * c_len, c0 + 3 * c_len
    p00, p10, p20 = load_at(c, c0), load_at(c, c0 + WIDTH), load_at(c, c0 + 2 * WIDTH)
    p01, p11, p21 = load_at(c, c1), load_at(c, c1 + WIDTH), load_at(c, c1 + 2 * WIDTH)
    p02, p12, p22 = load_at(c, c2), load_at(c, c2 + WIDTH), load_at(c, c2 + 2 * WIDTH)
    p03, p13, p23 = load_at(c, c3), load_at(c, c3 + WIDTH), load_at(c, c3 + 2 * WIDTH)
    for _ in range(n):
        x, y, z = load_at(a, a0), load_at(a, a0 + WIDTH), load_at(a, a0 + 2 * WIDTH)
        f0, f1, f2, f3 = number_at(b, b0), number_at(b, b0 + 1), number_at(b, b0 + 2), number_at(b, b0 + 3)
        p00, p10, p20 = p00 - f0 * x, p10 - f0 * y, p20 - f0 * z
        p01, p11, p21 = p01 - f1 * x, p11 - f1 * y, p21 - f1 * z
        p02, p12, p22 = p02 - f2 * x, p12 - f2 * y, p22 - f2 * z
        p03, p13, p23 = p03 - f3 * x, p13 - f3 * y, p23 - f3 * z
        a0 += a_len
        b0 += 4
    store_at(c, c0, p00), store_at(c, c0 + WIDTH, p10), store_at(c, c0 + 2 * WIDTH, p20)
    store_at(c, c1, p01), store_at(c, c1 + WIDTH, p11), store_at(c, c1 + 2 * WIDTH, p21)
    store_at(c, c2, p02), store_at(c, c2 + WIDTH, p12), store_at(c, c2 + 2 * WIDTH, p22)
    store_at(c, c3, p03), store_at(c, c3 + WIDTH, p13), store_at(c, c3 + 2 * WIDTH, p23)


@inlined
def _subtract_flat(c: Floats, c0: int, c_len: int, a: Floats, a0: int, a_len: int, b: Floats, b0: int, n: int) -> None:
    """C -= A B for WIDTH rows and 4 columns, stored as in :func:`_subtract_tall`."""
    c1, c2, c3 = c0 + c_len, c0 + 2 * c_len, c0 + 3 * c_len
    p0, p1, p2, p3 = load_at(c, c0), load_at(c, c1), load_at(c, c2), load_at(c, c3)
    for _ in range(n):
        x = load_at(a, a0)
        p0, p1 = p0 - number_at(b, b0) * x, p1 - number_at(b, b0 + 1) * x
        p2, p3 = p2 - number_at(b, b0 + 2) * x, p3 - number_at(b, b0 + 3) * x
        a0 += a_len
        b0 += 4
    store_at(c, c0, p0), store_at(c, c1, p1), store_at(c, c2, p2), store_at(c, c3, p3)


@inner
def pack(a: Floats, a0: int, a_len: int, columns: int, signs: Floats, s0: int, b: Floats, n: int) -> None:
    """b <- S A^T for the first ``columns`` rows of A (at a[a0], by columns), four rows after four; S is at signs[s0].

    Surplus numbers of a lane are overwritten by the next one, the last go beyond the end: a and b have room for it.
    """
    i = 0
    for column in range(0, columns, 4):
        source = a0 + column
        for k in range(s0, s0 + n):
            store_at(b, i, signs[k] * load_at(a, source))
            source += a_len
            i += 4


@inlined
def _subtract_rows(
    c: Floats, c0: int, c_len: int, first: int, end: int, columns: int, a: Floats, a0: int, a_len: int, b: Floats, b0: int, n: int
) -> None:
    """See :func:`subtract_rows`."""
    row = first
    while row + 3 * WIDTH <= end:
        for column in range(0, min(columns, row + 3 * WIDTH), 4):
            _subtract_tall(c, c0 + row + column * c_len, c_len, a, a0 + row, a_len, b, b0 + column * n, n)
        row += 3 * WIDTH
    while row < end:
        for column in range(0, min(columns, row + WIDTH), 4):
            _subtract_flat(c, c0 + row + column * c_len, c_len, a, a0 + row, a_len, b, b0 + column * n, n)
        row += WIDTH


@shared
def subtract_rows(
    c: Floats, c0: int, c_len: int, first: int, end: int, columns: int, a: Floats, a0: int, a_len: int, b: Floats, b0: int, n: int
) -> None:
    """:func:`subtract` for the rows from ``first``, a multiple of 3 WIDTH, to ``end``, another one or the last; B is at b[b0]."""
    _subtract_rows(c, c0, c_len, first, end, columns, a, a0, a_len, b, b0, n)


@inner
def subtract(
    c: Floats, c0: int, c_len: int, rows: int, columns: int, a: Floats, a0: int, a_len: int, b: Floats, b0: int, n: int
) -> None:
    """C -= A B on the lower triangle of C (rows, columns), with A (rows, n) by columns and B packed, at b[b0].

    Rows are a multiple of WIDTH, columns of 4.
    """
    _subtract_rows(c, c0, c_len, 0, rows, columns, a, a0, a_len, b, b0, n)


@inner
def _factorise_corner(a: Floats, corner: int, a_len: int, limits: Floats, signs: Floats, s0: int) -> int:
    """L S L^T of the 4 by 4 block at a[corner]; -1, or the column whose pivot is within its limit (or not a number)."""
    for i in range(4):
        pivot = a[corner + i * a_len + i]
        if not abs(pivot) > limits[s0 + i]:
            return i
        sign = 1.0 if pivot > 0 else -1.0
        signs[s0 + i] = sign
        root = math.sqrt(abs(pivot))
        a[corner + i * a_len + i] = root
        for row in range(i + 1, 4):
            a[corner + i * a_len + row] *= sign / root
        for k in range(i + 1, 4):
            for row in range(k, 4):
                a[corner + k * a_len + row] -= sign * a[corner + i * a_len + k] * a[corner + i * a_len + row]
    return -1


@inner
def invert_corner(a: Floats, corner: int, a_len: int) -> None:
    """Put L^-1 of the 4 by 4 block L at a[corner] in its place, transposed: above the diagonal, and on it.

    With it substitution waits for no division, and each of the four unknowns for the right-hand side alone.
    """
    c1, c2, c3 = corner + a_len, corner + 2 * a_len, corner + 3 * a_len
    i0, i1, i2, i3 = 1.0 / a[corner], 1.0 / a[c1 + 1], 1.0 / a[c2 + 2], 1.0 / a[c3 + 3]
    l20, l30 = a[corner + 2], a[corner + 3]
    l21, l31, l32 = a[c1 + 2], a[c1 + 3], a[c2 + 3]
    i10, i21, i32 = -i1 * a[corner + 1] * i0, -i2 * l21 * i1, -i3 * l32 * i2
    i20, i31 = -i2 * (l20 * i0 + l21 * i10), -i3 * (l31 * i1 + l32 * i21)
    a[corner], a[c1 + 1], a[c2 + 2], a[c3 + 3] = i0, i1, i2, i3
    a[c1], a[c2], a[c2 + 1] = i10, i20, i21
    a[c3], a[c3 + 1], a[c3 + 2] = -i3 * (l30 * i0 + l31 * i10 + l32 * i20), i31, i32


@inner
def _factorise_columns(a: Floats, a0: int, a_len: int, j: int, limits: Floats, signs: Floats, s0: int) -> int:
    """Factorise columns j ... j + 3 of the panel at a[a0], from which all columns before are already subtracted."""
    corner = a0 + j * a_len + j
    failed = _factorise_corner(a, corner, a_len, limits, signs, s0 + j)
    if failed >= 0:
        return j + failed
    c0 = a0 + j * a_len
    c1, c2, c3 = c0 + a_len, c0 + 2 * a_len, c0 + 3 * a_len
    f0, f1, f2, f3 = signs[s0 + j], signs[s0 + j + 1], signs[s0 + j + 2], signs[s0 + j + 3]
    l10, l20, l30 = f0 * a[c0 + j + 1], f0 * a[c0 + j + 2], f0 * a[c0 + j + 3]
    l21, l31, l32 = f1 * a[c1 + j + 2], f1 * a[c1 + j + 3], f2 * a[c2 + j + 3]
    d0, d1, d2, d3 = f0 / a[c0 + j], f1 / a[c1 + j + 1], f2 / a[c2 + j + 2], f3 / a[c3 + j + 3]
    row = j + 4
    while row % WIDTH:
        x0 = a[c0 + row] * d0
        x1 = (a[c1 + row] - l10 * x0) * d1
        x2 = (a[c2 + row] - l20 * x0 - l21 * x1) * d2
        a[c3 + row] = (a[c3 + row] - l30 * x0 - l31 * x1 - l32 * x2) * d3
        a[c0 + row], a[c1 + row], a[c2 + row] = x0, x1, x2
        row += 1
    while row < a_len:
        y0 = load_at(a, c0 + row) * d0
        y1 = (load_at(a, c1 + row) - l10 * y0) * d1
        y2 = (load_at(a, c2 + row) - l20 * y0 - l21 * y1) * d2
        y3 = (load_at(a, c3 + row) - l30 * y0 - l31 * y1 - l32 * y2) * d3
        store_at(a, c0 + row, y0), store_at(a, c1 + row, y1), store_at(a, c2 + row, y2), store_at(a, c3 + row, y3)
        row += WIDTH
    invert_corner(a, corner, a_len)
    return -1


@inlined
def _factorise_block(
    a: Floats, a0: int, a_len: int, p: int, first: int, limits: Floats, signs: Floats, s0: int, b: Floats
) -> int:
    """Factorise ``BLOCK`` columns of a panel from ``first`` on and pack them for what is right of it; -1, or the failed pivot."""
    last = min(first + BLOCK, p)
    left, sign = a0 + first * a_len, s0 + first
    for j in range(first, last, 4):
        n, start, width = j - first, j - j % WIDTH, min(4, p - j)
        if n:
            pack(a, left + j, a_len, width, signs, sign, b, n)
            subtract(a, a0 + j * a_len + start, a_len, a_len - start, width, a, left + start, a_len, b, 0, n)
        failed = _factorise_columns(a, a0, a_len, j, limits, signs, s0)
        if failed >= 0:
            return failed
    pack(a, left + last, a_len, a_len - last, signs, sign, b, last - first)
    return -1


@shared
def factorise_block(a: Floats, a0: int, a_len: int, p: int, first: int, limits: Floats, signs: Floats, s0: int, b: Floats) -> int:
    """Factorise ``BLOCK`` columns of a panel from ``first`` on and pack them for what is right of it; -1, or the failed pivot."""
    return _factorise_block(a, a0, a_len, p, first, limits, signs, s0, b)


@inner
def _factorise_front(
    a: Floats, a0: int, a_len: int, p: int, u: Floats, u0: int, u_len: int, limits: Floats, signs: Floats, s0: int, b: Floats
) -> int:
    """Factorise a panel and subtract it from its update, ``BLOCK`` columns at a time; -1, or the pivot that failed."""
    for first in range(0, p, BLOCK):
        failed = _factorise_block(a, a0, a_len, p, first, limits, signs, s0, b)
        if failed >= 0:
            return failed
        last = min(first + BLOCK, p)
        left, n = a0 + first * a_len, last - first
        if last < p:
            subtract(a, a0 + last * (a_len + 1), a_len, a_len - last, p - last, a, left + last, a_len, b, 0, n)
        if u_len:
            subtract(u, u0, u_len, u_len, u_len, a, left + p, a_len, b, (p - last) * n, n)
    return -1


@inner
def extend_add(
    u: Floats, u0: int, u_len: int, runs: Ints, first: int, last: int, a: Floats, a0: int, a_len: int, p: int, t0: int, t_len: int
) -> None:
    """Add a child's update at u[u0] to its parent's panel (a0) and update (t0).

    Each of the runs first ... last - 1 (row of the child, row of the parent, length) has consecutive rows; none crosses row p.
    """
    for r in range(first, last):
        for j in range(runs[r, 2]):
            source, target = u0 + (runs[r, 0] + j) * u_len, runs[r, 1] + j
            if target < p:
                column = a0 + target * a_len
                for i in range(r, last):
                    add_entries(a, column + runs[i, 1], u, source + runs[i, 0], runs[i, 2])
            else:
                column = t0 + (target - p) * t_len - p
                for i in range(r, last):
                    add_entries(u, column + runs[i, 1], u, source + runs[i, 0], runs[i, 2])


@inner
def clear(c: Floats, c0: int, n: int) -> None:
    """c[c0:] = 0 for n entries, a multiple of ``WIDTH``."""
    for i in range(c0, c0 + n, WIDTH):
        store_at(c, i, 0.0)


@inlined
def add_entries(c: Reals, c0: int, d: Reals, d0: int, n: int) -> None:
    """c[c0:] += d[d0:] for n entries."""
    i = 0
    while i + WIDTH <= n:
        store_at(c, c0 + i, load_at(c, c0 + i) + load_at(d, d0 + i))
        i += WIDTH
    while i < n:
        put_at(c, c0 + i, number_at(c, c0 + i) + number_at(d, d0 + i))
        i += 1


@inner
def _assemble(
    k: Floats, entries: Indices, slots: Indices, starts: Ints, f: int, fronts: Ints, runs: Ints, a: Floats, u: Floats
) -> None:
    """See :func:`assemble`."""
    p, a_len, a0, u_len, u0 = fronts[f, 1], fronts[f, 2], fronts[f, 3], fronts[f, 5], fronts[f, 6]
    clear(a, a0, a_len * p)
    for i in range(starts[f], starts[f + 1]):
        entry = number_at(entries, i)
        put_at(a, number_at(slots, i), number_at(k, entry) if entry >= 0 else 1.0)
    clear(u, u0, u_len * u_len)
    child = fronts[f, 9]
    while child >= 0:
        r0, r1 = fronts[child, 8], fronts[child + 1, 8]
        extend_add(u, fronts[child, 6], fronts[child, 5], runs, r0, r1, a, a0, a_len, p, u0, u_len)
        child = fronts[child, 10]


@shared
def assemble(
    k: Floats, entries: Indices, slots: Indices, starts: Ints, f: int, fronts: Ints, runs: Ints, a: Floats, u: Floats
) -> None:
    """Fill a front with its entries of the matrix and with the updates of its children; arguments as for :func:`factorise`."""
    _assemble(k, entries, slots, starts, f, fronts, runs, a, u)


@shared
def factorise(
    k: Floats, entries: Indices, slots: Indices, starts: Ints, first: int, end: int, fronts: Ints, runs: Ints, limits: Floats,
    a: Floats, u: Floats, signs: Floats, b: Floats,
) -> int:  # fmt: skip
    """Factorise the fronts first ... end - 1, which hold all children of each, children before parents.

    Args:
        k: values of the matrix.
        entries: number of each entry of the matrix, front after front; -1 for a padded pivot, which is 1.
        slots: its position in ``a``.
        starts: where those of each front begin, shape (n_front + 1,).
        first, end: which fronts.
        fronts: for each front its first position, pivots (padded), panel column length, panel start in ``a``, remaining rows,
            update column length, update start in ``u``, start of its part of the remaining rows, start of its part of ``runs``,
            first child and next sister (-1 when there is none); shape (n_front + 1, 11), the last row closing the starts.
        runs: where the remaining rows of a child stand in its parent, see :func:`extend_add`; shape (n_run, 3).
        limits: magnitude that a pivot must exceed, by position.
        a: panels, overwritten by L.
        u: updates (workspace; space is used again when an update has been added to its parent).
        signs: signs S by position.
        b: workspace of ``BLOCK`` times the longest panel column, and ``WIDTH``.

    Returns:
        -1, or the position whose pivot is within its limit.
    """
    for f in range(first, end):
        _assemble(k, entries, slots, starts, f, fronts, runs, a, u)
        p, a_len, a0, u_len, u0 = fronts[f, 1], fronts[f, 2], fronts[f, 3], fronts[f, 5], fronts[f, 6]
        failed = _factorise_front(a, a0, a_len, p, u, u0, u_len, limits, signs, fronts[f, 0], b)
        if failed >= 0:
            return fronts[f, 0] + failed
    return -1
