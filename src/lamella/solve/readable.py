"""What substitutions read of a factor: panels in either precision, or as integers. Kernels are written once for all of them."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from lamella._jit import compiled_as, is_array
from lamella.lane import CACHE_LINE, WIDTH, fetch_at, load_at, number_at
from lamella.roles import Floats, Singles

Integers = NDArray[np.int16]


class Scaled(NamedTuple):
    """The factor of W K W, a matrix with 1 on its diagonal, as integers.

    Args:
        shares: panels, of which entries below the blocks on the diagonal are shares of the largest one in their column.
        corners: the 4 by 4 blocks on the diagonal, as panels hold them, by position.
        scales: what one stands for in each column, by position.
        weights: the diagonal of W by coordinate.
    """

    shares: Integers
    corners: Floats
    scales: Floats
    weights: Floats


Readable = Floats | Singles | Scaled


def lane_of(factor: Readable, place: int) -> Any:
    """The lane of entries below the blocks on the diagonal that begins at a place of the panels."""
    return (factor.shares if isinstance(factor, Scaled) else factor)[place : place + WIDTH]


def entry_of(factor: Readable, place: int) -> float:
    """An entry below the blocks on the diagonal."""
    return factor.shares[place] if isinstance(factor, Scaled) else factor[place]


def first_row(factor: Readable, row: int) -> int:
    """Where rows from ``row`` on may be read from: of integers a lane may begin with those above, which are zero."""
    return row - row % WIDTH if isinstance(factor, Scaled) else row


def fetch_ahead(factor: Readable, place: int) -> None:
    """Bring near as many entries from a place on as four lanes have: beyond a cache the processor does not foresee by itself that
    they will be read. In double precision it does.
    """


def corner_of(factor: Readable, place: int, position: int) -> float:
    """A number of a block on the diagonal, by its place in the panels, and by that among all blocks."""
    return factor.corners[position] if isinstance(factor, Scaled) else factor[place]


def scaled(factor: Readable, position: int, number: Any) -> Any:
    """A number, or a lane, times what one stands for in a column."""
    return factor.scales[position] * number if isinstance(factor, Scaled) else number


def weighed(factor: Readable, coordinate: int, number: Any) -> Any:
    """An entry of a vector by coordinate times that of W."""
    return factor.weights[coordinate] * number if isinstance(factor, Scaled) else number


# Numba compares the signatures of what follows with those above.
@compiled_as(lane_of)
def _lane_of(factor, place):  # noqa: ANN001, ANN202
    if is_array(factor):
        return lambda factor, place: load_at(factor, place)
    return lambda factor, place: load_at(factor.shares, place)


@compiled_as(entry_of)
def _entry_of(factor, place):  # noqa: ANN001, ANN202
    if is_array(factor):
        return lambda factor, place: number_at(factor, place)
    return lambda factor, place: number_at(factor.shares, place)


@compiled_as(first_row)
def _first_row(factor, row):  # noqa: ANN001, ANN202
    if is_array(factor):
        return lambda factor, row: row
    return lambda factor, row: row - row % WIDTH


@compiled_as(fetch_ahead)
def _fetch_ahead(factor, place):  # noqa: ANN001, ANN202
    if not is_array(factor):
        return lambda factor, place: fetch_at(factor.shares, place)
    if is_array(factor, "float64"):
        return lambda factor, place: None

    def two_lines(factor, place):  # noqa: ANN001, ANN202
        fetch_at(factor, place)
        fetch_at(factor, place + 2 * CACHE_LINE)

    return two_lines


@compiled_as(corner_of)
def _corner_of(factor, place, position):  # noqa: ANN001, ANN202
    if is_array(factor):
        return lambda factor, place, position: number_at(factor, place)
    return lambda factor, place, position: number_at(factor.corners, position)


@compiled_as(scaled)
def _scaled(factor, position, number):  # noqa: ANN001, ANN202
    if is_array(factor):
        return lambda factor, position, number: number
    return lambda factor, position, number: number_at(factor.scales, position) * number


@compiled_as(weighed)
def _weighed(factor, coordinate, number):  # noqa: ANN001, ANN202
    if is_array(factor):
        return lambda factor, coordinate, number: number
    return lambda factor, coordinate, number: number_at(factor.weights, coordinate) * number
