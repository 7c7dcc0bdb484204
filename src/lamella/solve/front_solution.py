"""Compiled forward and back substitution with the fronts of a multifrontal factorisation."""

# Stores side by side, as their numbers are.
# pyright: reportUnusedExpression=false
from __future__ import annotations

from lamella._jit import inlined, inner, kernel, shared
from lamella.lane import WIDTH, load_at, number_at, put_at, spread, store_at, total
from lamella.roles import Floats, Ints, Reals
from lamella.solve.front_kernels import add_entries
from lamella.solve.readable import Readable, corner_of, entry_of, fetch_ahead, first_row, lane_of, scaled, weighed
from lamella.solve.single_rows import products_of_singles, rows_of_singles, subtract_singles


@inlined
def _copy(c: Reals, c0: int, d: Reals, d0: int, n: int) -> None:
    """c[c0:] = d[d0:] for n entries. With small fronts to move numbers one by one takes nearly as long as the arithmetic."""
    i = 0
    while i + WIDTH <= n:
        store_at(c, c0 + i, load_at(d, d0 + i))
        i += WIDTH
    while i < n:
        put_at(c, c0 + i, number_at(d, d0 + i))
        i += 1


@inner
def _forward(a: Readable, a0: int, a_len: int, p: int, first: int, y: Reals) -> None:
    """y <- L^-1 y for the pivots, rest of y minus what they cause; four columns at a time, so that y is read and written once."""
    for k in range(0, p, 4):
        c0, s, at = a0 + k * a_len, first + k, 4 * (first + k)
        c1, c2, c3 = c0 + a_len, c0 + 2 * a_len, c0 + 3 * a_len
        y0, y1, y2, y3 = number_at(y, k), number_at(y, k + 1), number_at(y, k + 2), number_at(y, k + 3)
        x0 = corner_of(a, c0 + k, at) * y0
        x1 = corner_of(a, c1 + k, at + 4) * y0 + corner_of(a, c1 + k + 1, at + 5) * y1
        x2 = corner_of(a, c2 + k, at + 8) * y0 + corner_of(a, c2 + k + 1, at + 9) * y1 + corner_of(a, c2 + k + 2, at + 10) * y2
        x3 = corner_of(a, c3 + k, at + 12) * y0 + corner_of(a, c3 + k + 1, at + 13) * y1
        x3 += corner_of(a, c3 + k + 2, at + 14) * y2 + corner_of(a, c3 + k + 3, at + 15) * y3
        f0, f1, f2, f3 = scaled(a, s, x0), scaled(a, s + 1, x1), scaled(a, s + 2, x2), scaled(a, s + 3, x3)
        row = k + 4 - (k + 4) % WIDTH  # a lane that begins with pivots is put right below
        end = a_len - rows_of_singles(y, a_len - row)
        while row < end:
            fetch_ahead(a, c0 + 4 * (2 * a_len + row))
            one = load_at(y, row) - f0 * lane_of(a, c0 + row) - f1 * lane_of(a, c1 + row)
            store_at(y, row, one - f2 * lane_of(a, c2 + row) - f3 * lane_of(a, c3 + row))
            row += WIDTH
        subtract_singles(a, c0, a_len, end, f0, f1, f2, f3, y)
        put_at(y, k, x0), put_at(y, k + 1, x1), put_at(y, k + 2, x2), put_at(y, k + 3, x3)


@inner
def _backward(a: Readable, a0: int, a_len: int, p: int, first: int, y: Reals) -> None:
    """y <- L^-T y for the pivots, with the rest of y known."""
    for k in range(p - 4, -1, -4):
        c0, s, at = a0 + k * a_len, first + k, 4 * (first + k)
        c1, c2, c3 = c0 + a_len, c0 + 2 * a_len, c0 + 3 * a_len
        x0, x1, x2, x3 = 0.0, 0.0, 0.0, 0.0
        row = first_row(a, k + 4)
        end = a_len - rows_of_singles(y, a_len - row)
        while row % WIDTH:
            known = number_at(y, row)
            x0, x1, x2, x3 = (
                x0 + entry_of(a, c0 + row) * known,
                x1 + entry_of(a, c1 + row) * known,
                x2 + entry_of(a, c2 + row) * known,
                x3 + entry_of(a, c3 + row) * known,
            )
            row += 1
        if row < end:
            s0, s1, s2, s3 = spread(0.0), spread(0.0), spread(0.0), spread(0.0)
            t0, t1, t2, t3 = s0, s1, s2, s3  # two sums of each, as additions would wait for each other
            while row + WIDTH < end:
                fetch_ahead(a, c0 - 4 * (2 * a_len - row))
                fetch_ahead(a, c0 - 4 * (2 * a_len - row - WIDTH))
                known, other = load_at(y, row), load_at(y, row + WIDTH)
                s0, t0 = s0 + lane_of(a, c0 + row) * known, t0 + lane_of(a, c0 + row + WIDTH) * other
                s1, t1 = s1 + lane_of(a, c1 + row) * known, t1 + lane_of(a, c1 + row + WIDTH) * other
                s2, t2 = s2 + lane_of(a, c2 + row) * known, t2 + lane_of(a, c2 + row + WIDTH) * other
                s3, t3 = s3 + lane_of(a, c3 + row) * known, t3 + lane_of(a, c3 + row + WIDTH) * other
                row += 2 * WIDTH
            if row < end:
                known = load_at(y, row)
                s0, s1 = s0 + lane_of(a, c0 + row) * known, s1 + lane_of(a, c1 + row) * known
                s2, s3 = s2 + lane_of(a, c2 + row) * known, s3 + lane_of(a, c3 + row) * known
            x0, x1, x2, x3 = x0 + total(s0 + t0), x1 + total(s1 + t1), x2 + total(s2 + t2), x3 + total(s3 + t3)
        z0, z1, z2, z3 = products_of_singles(a, c0, a_len, end, y)
        x0, x1, x2, x3 = x0 + z0, x1 + z1, x2 + z2, x3 + z3
        x0, x1 = number_at(y, k) - scaled(a, s, x0), number_at(y, k + 1) - scaled(a, s + 1, x1)
        x2, x3 = number_at(y, k + 2) - scaled(a, s + 2, x2), number_at(y, k + 3) - scaled(a, s + 3, x3)
        y0 = corner_of(a, c0 + k, at) * x0 + corner_of(a, c1 + k, at + 4) * x1
        y1 = corner_of(a, c1 + k + 1, at + 5) * x1 + corner_of(a, c2 + k + 1, at + 9) * x2
        y1 += corner_of(a, c3 + k + 1, at + 13) * x3
        y2 = corner_of(a, c2 + k + 2, at + 10) * x2 + corner_of(a, c3 + k + 2, at + 14) * x3
        y0 += corner_of(a, c2 + k, at + 8) * x2 + corner_of(a, c3 + k, at + 12) * x3
        y3 = corner_of(a, c3 + k + 3, at + 15) * x3
        put_at(y, k, y0), put_at(y, k + 1, y1), put_at(y, k + 2, y2), put_at(y, k + 3, y3)


@inlined
def _forward_fronts(order: Ints, fronts: Ints, runs: Ints, a: Readable, signs: Floats, x: Reals, rest: Reals, y: Reals) -> None:
    """x <- S L^-1 x for the pivots of some fronts, children before parents; arguments as for :func:`solve`.

    What a front adds to rows above it is kept, so that fronts of which none is above the other can be done at the same time.
    """
    for f in order:
        first, p, a_len, a0, n, start = fronts[f, 0], fronts[f, 1], fronts[f, 2], fronts[f, 3], fronts[f, 4], fronts[f, 7]
        _copy(y, 0, x, first, p)
        for i in range(p, a_len, WIDTH):
            store_at(y, i, 0.0)
        child = fronts[f, 9]
        while child >= 0:
            for r in range(fronts[child, 8], fronts[child + 1, 8]):
                add_entries(y, runs[r, 1], rest, fronts[child, 7] + runs[r, 0], runs[r, 2])
            child = fronts[child, 10]
        _forward(a, a0, a_len, p, first, y)
        for i in range(p):
            put_at(x, first + i, number_at(y, i) * number_at(signs, first + i))
        _copy(rest, start, y, p, n)


@shared
def forward(order: Ints, fronts: Ints, runs: Ints, a: Readable, signs: Floats, x: Reals, rest: Reals, y: Reals) -> None:
    """x <- S L^-1 x for the pivots of some fronts, children before parents; arguments as for :func:`solve`."""
    _forward_fronts(order, fronts, runs, a, signs, x, rest, y)


@inlined
def _backward_fronts(order: Ints, fronts: Ints, rows: Ints, c: Readable, x: Reals, y: Reals) -> None:
    """x <- U^-1 x for the pivots of some fronts, parents before children, the last in ``order`` first; see :func:`solve`."""
    for k in range(len(order) - 1, -1, -1):
        f = order[k]
        first, p, a_len, a0, n, start = fronts[f, 0], fronts[f, 1], fronts[f, 2], fronts[f, 3], fronts[f, 4], fronts[f, 7]
        _copy(y, 0, x, first, p)
        for i in range(n):
            put_at(y, p + i, number_at(x, number_at(rows, start + i)))
        for i in range(p + n, a_len):
            put_at(y, i, 0.0)
        _backward(c, a0, a_len, p, first, y)
        _copy(x, first, y, 0, p)


@shared
def backward(order: Ints, fronts: Ints, rows: Ints, c: Readable, x: Reals, y: Reals) -> None:
    """x <- U^-1 x for the pivots of some fronts, parents before children, the last in ``order`` first; see :func:`solve`."""
    _backward_fronts(order, fronts, rows, c, x, y)


@inlined
def _solve(
    order: Ints, fronts: Ints, rows: Ints, runs: Ints, a: Readable, c: Readable, signs: Floats, x: Reals, rest: Reals, y: Reals
) -> None:
    _forward_fronts(order, fronts, runs, a, signs, x, rest, y)
    _backward_fronts(order, fronts, rows, c, x, y)


@kernel
def solve(
    order: Ints, fronts: Ints, rows: Ints, runs: Ints, a: Readable, c: Readable, signs: Floats, x: Reals, rest: Reals, y: Reals
) -> None:
    """x <- (L S U)^-1 x, by position.

    Args:
        order: all fronts, children before parents.
        fronts, runs: as in :func:`lamella.solve.front_kernels.factorise`.
        rows: position of each remaining row, front after front.
        a: panels with L.
        c: panels with U^T, which are those of L for a symmetric matrix.
        signs: signs S by position.
        x: right-hand side and solution by position, zero at padded pivots.
        rest: workspace, as long as ``rows``.
        y: workspace of the longest panel column, and ``WIDTH``.
    """
    _solve(order, fronts, rows, runs, a, c, signs, x, rest, y)


@kernel
def spread_positions(r: Floats, a: Readable, position: Ints, x: Reals) -> None:
    """x <- r by position, zero where a position fills up; in the units of the panels."""
    _spread_positions(r, a, position, x)


@kernel
def gather_coordinates(x: Reals, a: Readable, position: Ints, out: Floats) -> None:
    """out <- x by coordinate, from the units of the panels."""
    _gather_coordinates(x, a, position, out)


@kernel
def solve_coordinates(
    order: Ints, fronts: Ints, rows: Ints, runs: Ints, a: Readable, signs: Floats, position: Ints, r: Floats,
    x: Reals, rest: Reals, y: Reals, out: Floats,
) -> None:  # fmt: skip
    """out <- (L S L^T)^-1 r, both by coordinate; ``x`` is a workspace by position, ``position`` that of each coordinate."""
    _spread_positions(r, a, position, x)
    _solve(order, fronts, rows, runs, a, a, signs, x, rest, y)
    _gather_coordinates(x, a, position, out)


@inlined
def _spread_positions(r: Floats, a: Readable, position: Ints, x: Reals) -> None:
    x[:] = 0.0
    for i in range(len(r)):
        x[position[i]] = weighed(a, i, r[i])


@inlined
def _gather_coordinates(x: Reals, a: Readable, position: Ints, out: Floats) -> None:
    for i in range(len(out)):
        out[i] = weighed(a, i, x[position[i]])
