"""Between the coordinates of Plate36 and of Plate48, a lane of elements at a time: e48 = P e36, f36 = P^T f48, K36 = P^T K48 P.

Twelve of the sixteen rows of P are rows of the unit matrix; the other four, the twists, are the array ``twists`` (4, 12), flat.
The same numbers serve all elements and the three components of a vector. ``places`` (16,) holds the place (4 a + b) 3 of each
vector among the coordinates (a, b, component) of Plate48: first those of the twelve vectors of Plate36, then those of the twists.
Arrays are flat and counted in lanes, as in :mod:`lamella.element.plate48.kernels`.
"""

from __future__ import annotations

from typing import Any

from lamella._jit import inlined, kernel, shared
from lamella.lane import WIDTH, load, number_at, put_at, spread, store
from lamella.roles import Floats, Ints


@kernel
def expand(q: Floats, index: Ints, scale: Floats, twists: Floats, places: Ints, out: Floats) -> None:
    """Coordinates of Plate48, scaled, out (block, 48), from global coordinates of Plate36."""
    for block in range(index.size // (36 * WIDTH)):
        first = 48 * block
        for i in range(12):
            source, target = (36 * block + 3 * i) * WIDTH, (first + places[i]) * WIDTH
            for k in range(3 * WIDTH):
                put_at(out, target + k, number_at(q, number_at(index, source + k)) * number_at(scale, source + k))
        for t in range(4):
            for c in range(3):
                value = spread(0.0)
                for i in range(12):
                    value = value + twists[12 * t + i] * load(out, first + places[i] + c)
                store(out, first + places[12 + t] + c, value)


@inlined
def _four(values: Floats, t0: int, t1: int, t2: int, t3: int) -> Any:
    return (load(values, t0), load(values, t1), load(values, t2), load(values, t3))


@inlined
def _with_twists(value: Any, of_twists: Any, twists: Floats, i: int) -> Any:
    """The value of vector i and what the four twists add to it: its part of P^T times a column of sixteen."""
    value = value + twists[i] * of_twists[0] + twists[12 + i] * of_twists[1]
    return value + twists[24 + i] * of_twists[2] + twists[36 + i] * of_twists[3]


@kernel
def condense_force(full: Floats, twists: Floats, places: Ints, f: Floats) -> None:
    """P^T f48, f (block, 36), from full (block, 48)."""
    for block in range(full.size // (48 * WIDTH)):
        first = 48 * block
        for c in range(3):
            at = first + c
            of_twists = _four(full, at + places[12], at + places[13], at + places[14], at + places[15])
            for i in range(12):
                store(f, 36 * block + 3 * i + c, _with_twists(load(full, at + places[i]), of_twists, twists, i))


@shared
def condense_tangent(full: Floats, n_entry: int, source: Ints, is_upper: Ints, twists: Floats, work: Floats, k: Floats) -> None:
    """P^T K48 P, k (block, entry), from full (block, n_entry): rows first, then columns, for each pair of components.

    Args:
        full: tangents of Plate48.
        n_entry: their entries for an element.
        source: place among them of the entry of each pair of components, row and column, with vectors in the order of ``places``,
            shape (pair, 16, 16), flat.
        is_upper: for each pair of components, 1 where the block is symmetric and only its upper triangle is wanted.
        twists: rows of P, see the module.
        work: space for 12 x 16 lanes.
        k: receives (pair, i, j), with j >= i where only the upper triangle is wanted.
    """
    position = 0
    for block in range(full.size // (n_entry * WIDTH)):
        first = n_entry * block
        for pair in range(is_upper.size):
            s = 256 * pair
            for m in range(16):
                column = s + m
                of_twists = _four(
                    full,
                    first + source[column + 192],
                    first + source[column + 208],
                    first + source[column + 224],
                    first + source[column + 240],
                )
                for i in range(12):
                    value = load(full, first + source[column + 16 * i])
                    store(work, 16 * i + m, _with_twists(value, of_twists, twists, i))
            for i in range(12):
                row = 16 * i
                of_twists = _four(work, row + 12, row + 13, row + 14, row + 15)
                for j in range(i * is_upper[pair], 12):
                    store(k, position, _with_twists(load(work, row + j), of_twists, twists, j))
                    position += 1
