"""Many short lists of numbers in two arrays."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from lamella.roles import Ints


class Lists(NamedTuple):
    """Lists of numbers, one after another, and where each begins and the last one ends, shapes (starts[n],) and (n + 1,)."""

    numbers: Ints
    starts: Ints

    def take(self, chosen: Ints) -> Lists:
        """Some of the lists, in the order given."""
        lengths = np.diff(self.starts)[chosen]
        starts = starts_of(lengths)
        ahead = np.repeat(self.starts[chosen] - starts[:-1], lengths)
        return Lists(self.numbers[ahead + np.arange(starts[-1])], starts)

    def joined(self, groups: Lists) -> Lists:
        """For each group the lists whose numbers it holds, as one list."""
        numbers, starts = self.take(groups.numbers)
        return Lists(numbers, starts[groups.starts])


def starts_of(lengths: Ints) -> Ints:
    """Where each of some lists begins, and where the last one ends, shape (n + 1,)."""
    starts = np.zeros(len(lengths) + 1, np.int64)
    np.cumsum(lengths, out=starts[1:])
    return starts
