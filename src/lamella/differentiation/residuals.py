"""Generalised conjugate residuals: directions with their images, and what they tell of a solution."""

from __future__ import annotations

from math import sqrt

import numpy as np

from lamella._jit import inner, kernel
from lamella.lane import WIDTH, number_at, put_at
from lamella.lane_rows import add_row, set_row, weighed_dot
from lamella.roles import Floats


class ConjugateResiduals:
    """Solves C z = b for several b: keeps the directions p, whose images C p are orthonormal, from one b to the next.

    With ``left`` = b - C z each direction that is added is ``left`` itself, made conjugate to those before. Scalar products are
    those of unknowns in their magnitudes; multipliers do not count.

    Args:
        per_magnitude: 1 / magnitude of each unknown, shape (n,).
        n_lam: number of multipliers, behind them.
        most: directions that are kept; the next one begins anew.

    Source: S. C. Eisenstat, H. C. Elman, M. H. Schultz, SIAM J. Numer. Anal. 20 (1983) 345-357, algorithm GCR.
    """

    def __init__(self, per_magnitude: Floats, n_lam: int, most: int) -> None:
        self._most, self._known, n = most, 0, len(per_magnitude) + n_lam
        padded = -(-n // WIDTH) * WIDTH
        self._weights = np.zeros(padded)
        self._weights[: len(per_magnitude)] = per_magnitude**2
        self._z, self._left = np.zeros(padded), np.zeros(padded)
        self._directions, self._images = np.zeros((2, most * padded))
        self.left = self._left[:n]
        """What is left now, shape (n,)."""
        self._solution = self._z[:n]

    def forget(self) -> None:
        """C is another one."""
        self._known = 0

    def begin(self, z: Floats | None, left: Floats) -> float:
        """Start from z, or from zero, with what is left there; how much of it is left beside what is known, as a share of z."""
        if z is None:
            self._z[:] = 0.0
        else:
            self._solution[:] = z
        self.left[:] = left
        return _begin(self._z, self._left, self._known, self._directions, self._images, self._weights)

    def improve(self, lacking: Floats) -> float:
        """Add the direction ``left`` with its image C left = -``lacking``; how much is left then, as a share of z."""
        if self._known == self._most:
            self._known = 0
        self._known += 1
        return _improve(lacking, self._z, self._left, self._known - 1, self._directions, self._images, self._weights)

    def solution(self) -> Floats:
        """z with what is left, as if C were the identity, shape (n,)."""
        return self._solution + self.left


@kernel
def _begin(z: Floats, left: Floats, known: int, directions: Floats, images: Floats, weights: Floats) -> float:
    for k in range(known):
        _take(z, left, k, directions, images, weights)
    return _share(z, left, weights)


@kernel
def _improve(
    lacking: Floats, z: Floats, left: Floats, k: int, directions: Floats, images: Floats, weights: Floats
) -> float:  # fmt: skip
    """Direction number k is made conjugate to those before, its image of length 1."""
    n = len(left)
    at = k * n
    set_row(directions, at, 1.0, left, 0, n)
    for i in range(len(lacking)):
        put_at(images, at + i, -number_at(lacking, i))
    for before in range(0, at, n):
        share = weighed_dot(images, before, images, at, weights)
        add_row(directions, at, -share, directions, before, n)
        add_row(images, at, -share, images, before, n)
    factor = 1.0 / sqrt(weighed_dot(images, at, images, at, weights))
    set_row(directions, at, factor, directions, at, n)
    set_row(images, at, factor, images, at, n)
    _take(z, left, k, directions, images, weights)
    return _share(z, left, weights)


@inner
def _take(z: Floats, left: Floats, k: int, directions: Floats, images: Floats, weights: Floats) -> None:
    """Take the share of a direction in what is left into z."""
    n = len(left)
    share = weighed_dot(images, k * n, left, 0, weights)
    add_row(z, 0, share, directions, k * n, n)
    add_row(left, 0, -share, images, k * n, n)


@inner
def _share(z: Floats, left: Floats, weights: Floats) -> float:
    size, rest = weighed_dot(z, 0, z, 0, weights), weighed_dot(left, 0, left, 0, weights)
    return sqrt(rest / size) if size > 0.0 else np.inf if rest > 0.0 else 0.0
