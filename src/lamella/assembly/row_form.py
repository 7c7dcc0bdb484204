"""Linear rows as arrays, and the matrices that they make where each holds a single coordinate."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from lamella.dofs import LinearRow
from lamella.roles import Floats, Ints

Form = tuple[Ints, Ints, Floats]
"""Rows as arrays: where each starts, and the coordinates and coefficients of all."""


def form_of(rows: Sequence[LinearRow]) -> Form:
    """Where each row starts, and all their coordinates and coefficients."""
    starts = np.cumsum([0, *(len(row.coords) for row in rows)])
    coords = np.concatenate([np.zeros(0, np.int64), *(row.coords for row in rows)])
    coefs = np.concatenate([np.zeros(0), *(row.coefs for row in rows)])
    return starts, coords, coefs


def taken(form: Form, rows: Sequence[int] | Ints) -> Form:
    """Some of the rows."""
    starts, coords, coefs = form
    chosen = np.asarray(rows, np.int64)
    lengths = np.diff(starts)[chosen]
    ends = np.cumsum(lengths)
    places = np.arange(lengths.sum()) + np.repeat(starts[chosen] - ends + lengths, lengths)
    return np.append(0, ends), coords[places], coefs[places]


class Diagonal:
    """A diagonal matrix, used as a factorised one."""

    def __init__(self, diagonal: Floats) -> None:
        self._diagonal, self.nnz = diagonal, len(diagonal)

    def solve(self, b: Floats, trans: str = "N") -> Floats:
        """The solution for b (n,) or (n, m), also of the transpose."""
        return (b.T / self._diagonal).T
