"""Rows of a factor of integers in lanes of single numbers: twice as many at once, and half the work to make numbers of integers.

There are such rows where vectors are of single numbers, too; else nothing of this is compiled.
"""

from __future__ import annotations

import numpy as np

from lamella._jit import compiled_as, is_array
from lamella.lane import WIDTH, fetch_at, load_singles, spread_singles, store_singles, total
from lamella.roles import Reals
from lamella.solve.readable import Readable, Scaled

SINGLES = 2 * WIDTH
"""Numbers in a lane of them."""
Four = tuple[float, float, float, float]


def rows_of_singles(y: Reals, n: int) -> int:
    """Of the last n rows of a panel, a multiple of ``WIDTH``, how many are read in lanes of single numbers."""
    return n - n % SINGLES if y.dtype == np.float32 else 0


def subtract_singles(
    factor: Readable, at: int, a_len: int, row: int, f0: float, f1: float, f2: float, f3: float, y: Reals
) -> None:
    """y <- y - four columns times f, for the rows from ``row`` on that are read in lanes of single numbers.

    Args:
        factor: what is read.
        at: where the first of the columns begins.
        a_len: length of a column.
        row: the first row.
        f0, f1, f2, f3: factors of the columns.
        y: by row.
    """
    if isinstance(factor, Scaled):
        for k, f in enumerate((f0, f1, f2, f3)):
            y[row:a_len] -= f * factor.shares[at + k * a_len + row : at + (k + 1) * a_len]


def products_of_singles(factor: Readable, at: int, a_len: int, row: int, y: Reals) -> Four:
    """The products of four columns with y, of the same rows."""
    if not isinstance(factor, Scaled):
        return 0.0, 0.0, 0.0, 0.0
    columns = (factor.shares[at + k * a_len + row : at + (k + 1) * a_len] for k in range(4))
    one, two, three, four = (float(column @ y[row:a_len]) for column in columns)
    return one, two, three, four


# Numba compares the signatures of what follows with those above.
@compiled_as(rows_of_singles)
def _rows_of_singles(y, n):  # noqa: ANN001, ANN202
    if is_array(y, "float32"):
        return lambda y, n: n - n % SINGLES
    return lambda y, n: 0


@compiled_as(subtract_singles)
def _subtract_singles(factor, at, a_len, row, f0, f1, f2, f3, y):  # noqa: ANN001, ANN202
    def of_integers(factor, at, a_len, row, f0, f1, f2, f3, y):  # noqa: ANN001, ANN202
        a, c1, c2, c3 = factor.shares, at + a_len, at + 2 * a_len, at + 3 * a_len
        for i in range(row, a_len, SINGLES):
            fetch_at(a, at + 4 * (2 * a_len + i))
            fetch_at(a, at + 4 * (2 * a_len + i + WIDTH))
            one = load_singles(y, i) - f0 * load_singles(a, at + i) - f1 * load_singles(a, c1 + i)
            store_singles(y, i, one - f2 * load_singles(a, c2 + i) - f3 * load_singles(a, c3 + i))

    if not is_array(y, "float32"):
        return lambda factor, at, a_len, row, f0, f1, f2, f3, y: None
    return of_integers


@compiled_as(products_of_singles)
def _products_of_singles(factor, at, a_len, row, y):  # noqa: ANN001, ANN202
    def of_integers(factor, at, a_len, row, y):  # noqa: ANN001, ANN202
        a, c1, c2, c3 = factor.shares, at + a_len, at + 2 * a_len, at + 3 * a_len
        s0 = s1 = s2 = s3 = t0 = t1 = t2 = t3 = spread_singles(0.0)  # two sums of each, as additions would wait for each other
        i = row
        while i + SINGLES < a_len:
            j = i + SINGLES
            fetch_at(a, at - 4 * (2 * a_len - i))
            fetch_at(a, at - 4 * (2 * a_len - i - WIDTH))
            fetch_at(a, at - 4 * (2 * a_len - j))
            fetch_at(a, at - 4 * (2 * a_len - j - WIDTH))
            known, other = load_singles(y, i), load_singles(y, j)
            s0, t0 = s0 + load_singles(a, at + i) * known, t0 + load_singles(a, at + j) * other
            s1, t1 = s1 + load_singles(a, c1 + i) * known, t1 + load_singles(a, c1 + j) * other
            s2, t2 = s2 + load_singles(a, c2 + i) * known, t2 + load_singles(a, c2 + j) * other
            s3, t3 = s3 + load_singles(a, c3 + i) * known, t3 + load_singles(a, c3 + j) * other
            i += 2 * SINGLES
        if i < a_len:
            known = load_singles(y, i)
            s0, s1 = s0 + load_singles(a, at + i) * known, s1 + load_singles(a, c1 + i) * known
            s2, s3 = s2 + load_singles(a, c2 + i) * known, s3 + load_singles(a, c3 + i) * known
        return total(s0 + t0), total(s1 + t1), total(s2 + t2), total(s3 + t3)

    if not is_array(y, "float32"):
        return lambda factor, at, a_len, row, y: (0.0, 0.0, 0.0, 0.0)
    return of_integers
