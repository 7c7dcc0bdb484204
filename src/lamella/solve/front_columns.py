"""Compiled forward and back substitution with several right-hand sides at once: a lane holds a row of ``WIDTH`` of them.

Where a factor does not fit the cache its reading takes most of the time, and is shared; in small fronts the sums of several
columns do not wait for each other. Arrays by position are (position, WIDTH), flat; the fronts are those of
:mod:`lamella.solve.front_solution`.
"""

from __future__ import annotations

from lamella._jit import inner, kernel, shared
from lamella.lane import WIDTH, load, number_at, put_at, spread, store, store_at
from lamella.roles import Floats, Ints
from lamella.solve.readable import Readable, corner_of, entry_of, scaled, weighed


@inner
def _forward(a: Readable, a0: int, a_len: int, p: int, end: int, first: int, y: Floats) -> None:
    """y <- L^-1 y for the pivots, rest of y minus what they cause."""
    for k in range(0, p, 4):
        c0, s, at = a0 + k * a_len, first + k, 4 * (first + k)
        c1, c2, c3 = c0 + a_len, c0 + 2 * a_len, c0 + 3 * a_len
        y0, y1, y2, y3 = load(y, k), load(y, k + 1), load(y, k + 2), load(y, k + 3)
        x0 = corner_of(a, c0 + k, at) * y0
        x1 = corner_of(a, c1 + k, at + 4) * y0 + corner_of(a, c1 + k + 1, at + 5) * y1
        x2 = corner_of(a, c2 + k, at + 8) * y0 + corner_of(a, c2 + k + 1, at + 9) * y1 + corner_of(a, c2 + k + 2, at + 10) * y2
        x3 = corner_of(a, c3 + k, at + 12) * y0 + corner_of(a, c3 + k + 1, at + 13) * y1
        x3 = x3 + corner_of(a, c3 + k + 2, at + 14) * y2 + corner_of(a, c3 + k + 3, at + 15) * y3
        f0, f1, f2, f3 = scaled(a, s, x0), scaled(a, s + 1, x1), scaled(a, s + 2, x2), scaled(a, s + 3, x3)
        for row in range(k + 4, end):
            one = load(y, row) - entry_of(a, c0 + row) * f0 - entry_of(a, c1 + row) * f1
            store(y, row, one - entry_of(a, c2 + row) * f2 - entry_of(a, c3 + row) * f3)
        store(y, k, x0)
        store(y, k + 1, x1)
        store(y, k + 2, x2)
        store(y, k + 3, x3)


@inner
def _backward(a: Readable, a0: int, a_len: int, p: int, end: int, first: int, y: Floats) -> None:
    """y <- L^-T y for the pivots, with the rest of y known."""
    for k in range(p - 4, -1, -4):
        c0, s, at = a0 + k * a_len, first + k, 4 * (first + k)
        c1, c2, c3 = c0 + a_len, c0 + 2 * a_len, c0 + 3 * a_len
        x0, x1, x2, x3 = spread(0.0), spread(0.0), spread(0.0), spread(0.0)
        s0, s1, s2, s3 = x0, x1, x2, x3  # a second sum of each, as additions would wait
        row = k + 4
        while row + 1 < end:
            known, other = load(y, row), load(y, row + 1)
            x0, s0 = x0 + entry_of(a, c0 + row) * known, s0 + entry_of(a, c0 + row + 1) * other
            x1, s1 = x1 + entry_of(a, c1 + row) * known, s1 + entry_of(a, c1 + row + 1) * other
            x2, s2 = x2 + entry_of(a, c2 + row) * known, s2 + entry_of(a, c2 + row + 1) * other
            x3, s3 = x3 + entry_of(a, c3 + row) * known, s3 + entry_of(a, c3 + row + 1) * other
            row += 2
        if row < end:
            known = load(y, row)
            x0, x1 = x0 + entry_of(a, c0 + row) * known, x1 + entry_of(a, c1 + row) * known
            x2, x3 = x2 + entry_of(a, c2 + row) * known, x3 + entry_of(a, c3 + row) * known
        x0, x1 = load(y, k) - scaled(a, s, x0 + s0), load(y, k + 1) - scaled(a, s + 1, x1 + s1)
        x2, x3 = load(y, k + 2) - scaled(a, s + 2, x2 + s2), load(y, k + 3) - scaled(a, s + 3, x3 + s3)
        y0 = corner_of(a, c0 + k, at) * x0 + corner_of(a, c1 + k, at + 4) * x1
        store(y, k, y0 + corner_of(a, c2 + k, at + 8) * x2 + corner_of(a, c3 + k, at + 12) * x3)
        y1 = corner_of(a, c1 + k + 1, at + 5) * x1 + corner_of(a, c2 + k + 1, at + 9) * x2
        store(y, k + 1, y1 + corner_of(a, c3 + k + 1, at + 13) * x3)
        store(y, k + 2, corner_of(a, c2 + k + 2, at + 10) * x2 + corner_of(a, c3 + k + 2, at + 14) * x3)
        store(y, k + 3, corner_of(a, c3 + k + 3, at + 15) * x3)


@shared
def forward(order: Ints, fronts: Ints, runs: Ints, a: Readable, signs: Floats, x: Floats, rest: Floats, y: Floats) -> None:
    """x <- S L^-1 x for the pivots of some fronts, children before parents."""
    for f in order:
        first, p, a_len, a0, n, start = fronts[f, 0], fronts[f, 1], fronts[f, 2], fronts[f, 3], fronts[f, 4], fronts[f, 7]
        for i in range(p):
            store(y, i, load(x, first + i))
        for i in range(p, p + n):
            store(y, i, spread(0.0))
        child = fronts[f, 9]
        while child >= 0:
            for r in range(fronts[child, 8], fronts[child + 1, 8]):
                source, target = fronts[child, 7] + runs[r, 0], runs[r, 1]
                for i in range(runs[r, 2]):
                    store(y, target + i, load(y, target + i) + load(rest, source + i))
            child = fronts[child, 10]
        _forward(a, a0, a_len, p, p + n, first, y)
        for i in range(p):
            store(x, first + i, number_at(signs, first + i) * load(y, i))
        for i in range(n):
            store(rest, start + i, load(y, p + i))


@shared
def backward(order: Ints, fronts: Ints, rows: Ints, a: Readable, x: Floats, y: Floats) -> None:
    """x <- L^-T x for the pivots of some fronts, parents before children, the last in ``order`` first."""
    for k in range(len(order) - 1, -1, -1):
        f = order[k]
        first, p, a_len, a0, n, start = fronts[f, 0], fronts[f, 1], fronts[f, 2], fronts[f, 3], fronts[f, 4], fronts[f, 7]
        for i in range(p):
            store(y, i, load(x, first + i))
        for i in range(n):
            store(y, p + i, load(x, rows[start + i]))
        _backward(a, a0, a_len, p, p + n, first, y)
        for i in range(p):
            store(x, first + i, load(y, i))


@kernel
def spread_columns(r: Floats, a: Readable, position: Ints, x: Floats) -> None:
    """x <- up to ``WIDTH`` right-hand sides, the rows of r, by position, zero where there is none; in the units of the panels."""
    for i in range(0, len(x), WIDTH):
        store_at(x, i, spread(0.0))
    for c in range(r.shape[0]):
        for i in range(r.shape[1]):
            put_at(x, position[i] * WIDTH + c, weighed(a, i, r[c, i]))


@kernel
def gather_columns(x: Floats, a: Readable, position: Ints, out: Floats) -> None:
    """The rows of out <- x by coordinate, from the units of the panels."""
    for c in range(out.shape[0]):
        for i in range(out.shape[1]):
            out[c, i] = weighed(a, i, number_at(x, position[i] * WIDTH + c))
