"""Rows and columns of the tangent's entries in the order in which the kernels write them."""

from __future__ import annotations

from functools import cache

import numpy as np

from lamella.roles import Ints

PAIRS = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))
"""Pairs of components of an upper triangle."""

ALL_PAIRS = tuple((c, d) for c in range(3) for d in range(3))
"""Pairs of components of a full matrix."""


def _pair_entries(c: int, d: int, upper: bool) -> list[tuple[int, int]]:
    """Entries (b, b', a, a') of one pair of components, as :func:`contract_xi` writes them."""
    return [
        (3 * (4 * a + b) + c, 3 * (4 * a2 + b2) + d)
        for b in range(4)
        for b2 in range(b if upper else 0, 4)
        for a in range(4)
        for a2 in range(a if upper and b == b2 else 0, 4)
    ]


@cache
def upper_entries() -> tuple[Ints, Ints]:
    """Rows and columns (a, b, component) of the 1176 entries of a symmetric element matrix, each pair once."""
    return _columns([entry for c, d in PAIRS for entry in _pair_entries(c, d, c == d)])


@cache
def all_entries() -> tuple[Ints, Ints]:
    """Rows and columns (a, b, component) of all 2304 entries of an element matrix."""
    return _columns([entry for c, d in ALL_PAIRS for entry in _pair_entries(c, d, False)])


def _columns(entries: list[tuple[int, int]]) -> tuple[Ints, Ints]:
    rows, columns = np.ascontiguousarray(np.array(entries).T)
    rows.flags.writeable = columns.flags.writeable = False  # all who ask share them
    return rows, columns
