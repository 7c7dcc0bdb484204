"""The panels of a factor: as a factorisation writes them, and as substitutions read them."""

from __future__ import annotations

import numpy as np

from lamella._jit import kernel
from lamella.lane import WIDTH, aligned, load_at, store_at
from lamella.roles import Floats, Singles

SHORTENED = 300_000
"""Entries from which a factor is read faster in single precision, by a third to a half: those of the second level of a cache. To
shorten it takes as long as two to four substitutions save."""

Readable = Floats | Singles
"""What substitutions read: panels in either precision, with which they compute in double precision."""


class Panels:
    """Panels of a factor, flat, with room for a lane behind them.

    Args:
        size: entries.

    Attributes:
        written: in double precision, to be written by a factorisation; of no use after :meth:`shorten`.
        read: the same, or what :meth:`shorten` has put in its place.
    """

    def __init__(self, size: int) -> None:
        self.size, self.written = size, aligned((size // WIDTH + 2) * WIDTH)
        self.read: Readable = self.written

    def renew(self) -> None:
        """A factorisation begins to write."""
        self.read = self.written

    def shorten(self) -> None:
        """Let substitutions read single precision from now on, where that is faster.

        It takes the place of the panels themselves: on some machines new memory takes as long as fifty substitutions save.
        """
        if self.size >= SHORTENED and self.read is self.written:
            self.read = self.written.view(np.float32)[: len(self.written)]
            _narrow(self.written, self.read)


@kernel
def _narrow(panels: Floats, short: Singles) -> None:
    """short <- panels, in whose memory it lies: each lane is read before its place is written."""
    for i in range(0, len(short), WIDTH):
        store_at(short, i, load_at(panels, i))
