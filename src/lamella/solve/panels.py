"""The panels of a factor: as a factorisation writes them, and as substitutions read them."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from lamella.lane import WIDTH, aligned, aligned_singles
from lamella.roles import Floats, Singles

SHORTENED = 300_000
"""Entries from which a factor is read faster in single precision, by a third to a half: those of the second level of a cache. To
shorten it takes as long as two substitutions save."""

Readable = Floats | Singles
"""What substitutions read: panels in either precision, with which they compute in double precision."""


class Panels:
    """Panels of a factor, flat, with room for a lane behind them.

    Args:
        size: entries.

    Attributes:
        written: in double precision, to be written by a factorisation.
        read: the same, or a copy in single precision after :meth:`shorten`.
    """

    def __init__(self, size: int) -> None:
        self.size, self.written = size, aligned(size + WIDTH)
        self.read: Readable = self.written

    def renew(self) -> None:
        """A factorisation begins to write."""
        self.read = self.written

    def shorten(self) -> None:
        """Let substitutions read single precision from now on, where that is faster."""
        if self.size >= SHORTENED and self.read is self.written:
            np.copyto(self._short, self.written, casting="same_kind")
            self.read = self._short

    @cached_property
    def _short(self) -> Singles:
        return aligned_singles(len(self.written))
