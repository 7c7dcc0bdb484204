"""Generalised conjugate residuals: what is left is least in magnitudes."""

from __future__ import annotations

from math import sqrt

import numpy as np

from lamella._jit import inner, kernel
from lamella.differentiation.directions import Directions, add_direction, set_direction, share_of
from lamella.lane_rows import add_row, set_row, weighed_dot
from lamella.roles import Floats


class ConjugateResiduals(Directions):
    """Solves C z = B^-1 b with C = B^-1 A for several b, with directions p whose images C p are orthonormal.

    Scalar products are those of unknowns in their magnitudes. B^-1 must be linear to what a solution may lack.

    Source: S. C. Eisenstat, H. C. Elman, M. H. Schultz, SIAM J. Numer. Anal. 20 (1983) 345-357, algorithm GCR.
    """

    def __init__(self, per_magnitude: Floats, n_lam: int, most: int) -> None:
        super().__init__(per_magnitude, n_lam, most)
        self._directions, self._images = np.zeros((2, most * self._padded))
        self._vectors = self._z, self._left, self._directions, self._images, self._weights

    def begin(self, z: Floats | None, left: Floats, force: Floats) -> float:
        """As the role says; how much the solution lacks is told as a share of z."""
        self._start(z, left)
        return _begin(self.known, *self._vectors)

    def improve(self, lacking: Floats) -> float:
        """Add the direction ``left``, of which C left = -``lacking``."""
        return _improve(lacking, self._place(), *self._vectors)


@kernel
def _begin(known: int, z: Floats, left: Floats, directions: Floats, images: Floats, weights: Floats) -> float:
    """Take what is known into z; what is left then, as a share of it."""
    for k in range(known):
        _take(z, left, k, directions, images, weights)
    return share_of(z, left, weights)


@kernel
def _improve(lacking: Floats, k: int, z: Floats, left: Floats, directions: Floats, images: Floats, weights: Floats) -> float:
    """Direction number k is made conjugate to those before, its image of length 1; what is left then, as a share of z."""
    n = len(left)
    at = k * n
    set_direction(left, lacking, at, directions, images)
    for before in range(0, at, n):
        add_direction(directions, images, at, -weighed_dot(images, before, images, at, weights), before, n)
    size = weighed_dot(images, at, images, at, weights)
    if not size > 0.0:
        return np.nan
    factor = 1.0 / sqrt(size)
    set_row(directions, at, factor, directions, at, n)
    set_row(images, at, factor, images, at, n)
    _take(z, left, k, directions, images, weights)
    return share_of(z, left, weights)


@inner
def _take(z: Floats, left: Floats, k: int, directions: Floats, images: Floats, weights: Floats) -> None:
    """Take the share of a direction in what is left into z."""
    n = len(left)
    share = weighed_dot(images, k * n, left, 0, weights)
    add_row(z, 0, share, directions, k * n, n)
    add_row(left, 0, -share, images, k * n, n)
