"""Compiled forward and back substitution with several right-hand sides at once: a lane holds a row of ``WIDTH`` of them.

Where a factor does not fit the cache its reading takes most of the time, and is shared; in small fronts the sums of several
columns do not wait for each other. Arrays by position are (position, WIDTH), flat; the fronts are those of
:mod:`lamella.solve.front_solution`.
"""

from __future__ import annotations

from lamella._jit import inner, kernel, shared
from lamella.lane import WIDTH, load, number_at, put_at, spread, store, store_at
from lamella.roles import Floats, Ints
from lamella.solve.panels import Readable


@inner
def _forward(a: Readable, a0: int, a_len: int, p: int, end: int, y: Floats) -> None:
    """y <- L^-1 y for the pivots, rest of y minus what they cause."""
    for k in range(0, p, 4):
        c0 = a0 + k * a_len
        c1, c2, c3 = c0 + a_len, c0 + 2 * a_len, c0 + 3 * a_len
        y0, y1, y2, y3 = load(y, k), load(y, k + 1), load(y, k + 2), load(y, k + 3)
        x0 = number_at(a, c0 + k) * y0
        x1 = number_at(a, c1 + k) * y0 + number_at(a, c1 + k + 1) * y1
        x2 = number_at(a, c2 + k) * y0 + number_at(a, c2 + k + 1) * y1 + number_at(a, c2 + k + 2) * y2
        x3 = number_at(a, c3 + k) * y0 + number_at(a, c3 + k + 1) * y1
        x3 = x3 + number_at(a, c3 + k + 2) * y2 + number_at(a, c3 + k + 3) * y3
        for row in range(k + 4, end):
            one = load(y, row) - number_at(a, c0 + row) * x0 - number_at(a, c1 + row) * x1
            store(y, row, one - number_at(a, c2 + row) * x2 - number_at(a, c3 + row) * x3)
        store(y, k, x0)
        store(y, k + 1, x1)
        store(y, k + 2, x2)
        store(y, k + 3, x3)


@inner
def _backward(a: Readable, a0: int, a_len: int, p: int, end: int, y: Floats) -> None:
    """y <- L^-T y for the pivots, with the rest of y known."""
    for k in range(p - 4, -1, -4):
        c0 = a0 + k * a_len
        c1, c2, c3 = c0 + a_len, c0 + 2 * a_len, c0 + 3 * a_len
        x0, x1, x2, x3 = load(y, k), load(y, k + 1), load(y, k + 2), load(y, k + 3)
        s0, s1, s2, s3 = spread(0.0), spread(0.0), spread(0.0), spread(0.0)  # a second sum of each, as additions would wait
        row = k + 4
        while row + 1 < end:
            known, other = load(y, row), load(y, row + 1)
            x0, s0 = x0 - number_at(a, c0 + row) * known, s0 + number_at(a, c0 + row + 1) * other
            x1, s1 = x1 - number_at(a, c1 + row) * known, s1 + number_at(a, c1 + row + 1) * other
            x2, s2 = x2 - number_at(a, c2 + row) * known, s2 + number_at(a, c2 + row + 1) * other
            x3, s3 = x3 - number_at(a, c3 + row) * known, s3 + number_at(a, c3 + row + 1) * other
            row += 2
        if row < end:
            known = load(y, row)
            x0, x1 = x0 - number_at(a, c0 + row) * known, x1 - number_at(a, c1 + row) * known
            x2, x3 = x2 - number_at(a, c2 + row) * known, x3 - number_at(a, c3 + row) * known
        x0, x1, x2, x3 = x0 - s0, x1 - s1, x2 - s2, x3 - s3
        y0 = number_at(a, c0 + k) * x0 + number_at(a, c1 + k) * x1
        store(y, k, y0 + number_at(a, c2 + k) * x2 + number_at(a, c3 + k) * x3)
        store(y, k + 1, number_at(a, c1 + k + 1) * x1 + number_at(a, c2 + k + 1) * x2 + number_at(a, c3 + k + 1) * x3)
        store(y, k + 2, number_at(a, c2 + k + 2) * x2 + number_at(a, c3 + k + 2) * x3)
        store(y, k + 3, number_at(a, c3 + k + 3) * x3)


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
        _forward(a, a0, a_len, p, p + n, y)
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
        _backward(a, a0, a_len, p, p + n, y)
        for i in range(p):
            store(x, first + i, load(y, i))


@kernel
def spread_columns(r: Floats, position: Ints, x: Floats) -> None:
    """x <- up to ``WIDTH`` right-hand sides, the rows of r, by position, zero where there is none."""
    for i in range(0, len(x), WIDTH):
        store_at(x, i, spread(0.0))
    for c in range(r.shape[0]):
        for i in range(r.shape[1]):
            put_at(x, position[i] * WIDTH + c, r[c, i])


@kernel
def gather_columns(x: Floats, position: Ints, out: Floats) -> None:
    """The rows of out <- x by coordinate."""
    for c in range(out.shape[0]):
        for i in range(out.shape[1]):
            out[c, i] = number_at(x, position[i] * WIDTH + c)
