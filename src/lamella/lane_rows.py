"""Rows of numbers that are stored one after another in one array, each as long as a number of lanes."""

from __future__ import annotations

from lamella._jit import inner
from lamella.lane import WIDTH, load_at, spread, store_at, total
from lamella.roles import Floats


@inner
def dot(x: Floats, x_at: int, y: Floats, y_at: int, n: int) -> float:
    """x[x_at : x_at + n] . y[y_at : y_at + n]; in two sums, as additions would wait for each other."""
    even, odd, i = spread(0.0), spread(0.0), 0
    while i + WIDTH < n:
        even = even + load_at(x, x_at + i) * load_at(y, y_at + i)
        odd = odd + load_at(x, x_at + i + WIDTH) * load_at(y, y_at + i + WIDTH)
        i += 2 * WIDTH
    if i < n:
        even = even + load_at(x, x_at + i) * load_at(y, y_at + i)
    return total(even + odd)


@inner
def weighed_dot(x: Floats, x_at: int, y: Floats, y_at: int, weights: Floats) -> float:
    """The same with a weight (n,) for each place."""
    even, odd, i, n = spread(0.0), spread(0.0), 0, len(weights)
    while i + WIDTH < n:
        even = even + load_at(x, x_at + i) * load_at(weights, i) * load_at(y, y_at + i)
        j = i + WIDTH
        odd = odd + load_at(x, x_at + j) * load_at(weights, j) * load_at(y, y_at + j)
        i += 2 * WIDTH
    if i < n:
        even = even + load_at(x, x_at + i) * load_at(weights, i) * load_at(y, y_at + i)
    return total(even + odd)


@inner
def add_row(x: Floats, at: int, factor: float, y: Floats, y_at: int, n: int) -> None:
    """x[at : at + n] += factor y[y_at : y_at + n]"""
    for i in range(0, n, WIDTH):
        store_at(x, at + i, load_at(x, at + i) + factor * load_at(y, y_at + i))


@inner
def set_row(x: Floats, at: int, factor: float, y: Floats, y_at: int, n: int) -> None:
    """x[at : at + n] = factor y[y_at : y_at + n]"""
    for i in range(0, n, WIDTH):
        store_at(x, at + i, factor * load_at(y, y_at + i))
