"""The panels of a factor: as a factorisation writes them, and as substitutions read them."""

from __future__ import annotations

import numpy as np

from lamella._jit import kernel
from lamella.lane import WIDTH, aligned, chosen, load_at, number_at, put_at, spread, store_at
from lamella.roles import Floats, Ints, Singles
from lamella.solve.readable import Integers, Scaled

SHORTENED = 300_000
"""Entries from which a factor is read faster in single precision, by a third to a half, and as integers of 16 bits by more: those
of the second level of a cache. To shorten it takes as long as two to four substitutions save, to scale it as three to six."""
LARGEST = 32767.0
"""Integer that stands for the largest entry of a column."""
TO_INTEGER = 1.5 * 2.0**52
"""A number to which others are added, and from which it is taken, so that they are rounded to integers."""


class Panels:
    """Panels of a factor, flat, with room for a lane behind them.

    Args:
        size: entries.

    Attributes:
        written: in double precision, to be written by a factorisation; of no use after :meth:`shorten` and :meth:`scale`, which
            put others in their place: on some machines new memory takes as long as fifty substitutions save.
        read: the same, or what :meth:`shorten` has made of it.
        fresh: whether they are as the factorisation has written them.
    """

    def __init__(self, size: int) -> None:
        self.size, self.written = size, aligned((size // WIDTH + 2) * WIDTH)
        self.renew()

    def renew(self) -> None:
        """A factorisation begins to write."""
        self.read: Floats | Singles = self.written
        self.fresh = True

    def shorten(self) -> None:
        """Let substitutions read single precision from now on, where that is faster."""
        if self.size >= SHORTENED and self.fresh:
            self.fresh, self.read = False, self.written.view(np.float32)[: len(self.written)]
            _narrow(self.written, self.read)

    def scale(self, fronts: Ints, rows: Ints, longest: int, by_position: Floats, weights: Floats) -> Scaled:
        """What substitutions may read instead from now on.

        Args:
            fronts, rows: as in :func:`lamella.solve.front_solution.solve`.
            longest: length of the longest column.
            by_position, weights: the diagonal of W, by position and by coordinate.
        """
        shares, n = self.written.view(np.int16)[: len(self.written)], len(by_position)
        found, self.fresh = Scaled(shares, np.empty(4 * n), np.empty(n), weights), False
        work = aligned(longest + WIDTH), aligned(WIDTH)
        _scale(self.written, shares, found.corners, found.scales, fronts, rows, by_position, *work)
        return found


@kernel
def _narrow(panels: Floats, short: Singles) -> None:
    """short <- panels, in whose memory it lies: each lane is read before its place is written."""
    for i in range(0, len(short), WIDTH):
        store_at(short, i, load_at(panels, i))


@kernel
def _scale(
    panels: Floats, shares: Integers, corners: Floats, scales: Floats, fronts: Ints, rows: Ints, weights: Floats, own: Floats,
    lane: Floats,
) -> None:  # fmt: skip
    """See :class:`Scaled`; as in :func:`_narrow` each lane is read before its place is written.

    ``own`` is work space for the weights of a front's rows, ``lane`` for one lane.
    """
    for f in range(len(fronts) - 1):
        first, p, a_len, a0, n, start = fronts[f, 0], fronts[f, 1], fronts[f, 2], fronts[f, 3], fronts[f, 4], fronts[f, 7]
        for i in range(p):
            put_at(own, i, number_at(weights, first + i))
        for i in range(n):
            put_at(own, p + i, number_at(weights, number_at(rows, start + i)))
        for i in range(p + n, a_len):
            put_at(own, i, 0.0)
        for j in range(p):
            column, block = a0 + j * a_len, j - j % 4
            for i in range(4):  # L^-1 W^-1
                put_at(corners, 4 * (first + j) + i, number_at(panels, column + block + i) / number_at(own, block + i))
            begin = block + 4 - (block + 4) % WIDTH  # a lane that begins with pivots, which substitutions put right
            for row in range(begin, block + 4):
                put_at(panels, column + row, 0.0)
            sizes = spread(0.0)
            for row in range(begin, a_len, WIDTH):
                entry = load_at(own, row) * load_at(panels, column + row)
                size = chosen(entry, entry, -entry)
                sizes = chosen(size - sizes, size, sizes)
            store_at(lane, 0, sizes)
            largest = 0.0
            for i in range(WIDTH):
                largest = max(largest, number_at(lane, i))
            put_at(scales, first + j, largest / LARGEST)
            factor = LARGEST / largest if largest > 0.0 else 0.0
            for row in range(begin, a_len, WIDTH):
                entry = factor * load_at(own, row) * load_at(panels, column + row)
                store_at(shares, column + row, (entry + TO_INTEGER) - TO_INTEGER)
