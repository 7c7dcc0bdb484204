"""Conjugate gradients: the energy of what is left is least."""

from __future__ import annotations

from collections.abc import Callable
from math import sqrt

import numpy as np

from lamella._jit import kernel
from lamella.differentiation.directions import LEAST, Directions, add_direction, set_direction, share_of
from lamella.lane import number_at, put_at
from lamella.lane_rows import add_row, dot
from lamella.roles import Floats

WORSE, FAST, AT_BEST = 2.5, 0.02, 0.004
"""The next direction is expected to leave the share that the last one has left; of a share up to ``FAST`` so many times as much
(of plates without damping 1.3 to 2.7 times in nine of ten steps), and ``AT_BEST`` in any case."""
FINE = 1e-6
"""What a solution may lack below which its first substitution is made anew once earlier directions have taken their share: what
is known of these tells it to single precision where B^-1 computes with that."""


class ConjugateGradients(Directions):
    """Solves A z = b for several b, with conjugate directions, p_i . A p_j = 0 for i != j; for symmetric A and B without
    multipliers.

    What is left is substituted anew after each direction, so that B^-1 need not be linear to more than that. Of a plate, whose
    membrane is stiffer than its bending by orders of magnitude, they need half as many directions for the same forces as
    :class:`~lamella.differentiation.residuals.ConjugateResiduals`. How much a solution lacks is told as the square root of the
    energy of what is left, beside that of the solution, or of what was left at first if that is more.

    Args:
        per_magnitude, most: as for :class:`Directions`.

    Attributes:
        force: b - A z, shape (n,).

    Source: the flexible form of Y. Notay, SIAM J. Sci. Comput. 22 (2000) 1444-1460, with all directions kept.
    """

    def __init__(self, per_magnitude: Floats, most: int) -> None:
        super().__init__(per_magnitude, 0, most)
        self._force = np.zeros(self._padded)
        self.force = self._force[: len(per_magnitude)]
        self._directions, self._forces, self._images = np.zeros((3, most * self._padded))
        self._energies = np.zeros(most)
        self._vectors = self._z, self._left, self._force, self._directions, self._forces, self._images
        self._whole, self._last = 0.0, 0.0

    def begin(self, z: Floats | None, left: Floats, force: Floats, energy: float = 0.0) -> float:
        """As the role says; ``energy`` is that of the solution, as far as it is known."""
        self._start(z, left)
        self.force[:] = force
        at_first, of_magnitudes, of_left = _begin(self.known, *self._vectors, self._energies, self._weights)
        self._whole = max(at_first, energy)
        self._last = 0.0
        return self._lacking(of_magnitudes, of_left)

    def renew(self, left: Floats) -> float:
        """Take what a substitution has found of ``force`` for what is left; how much the solution lacks."""
        self.left[:] = left
        self._last = 0.0
        return self._lacking(*_shares(self._z, self._left, self._force, self._weights))

    def improve(self, rest: Floats, substituted: Callable[[Floats], Floats]) -> float:
        """Add the direction ``left``, of which A left = -``rest``; ``substituted`` multiplies with B^-1."""
        k = self._place()
        share = _advance(rest, k, *self._vectors, self._energies)
        if not share > 0.0:
            return np.nan
        return self._lacking(*_left_anew(substituted(self.force), share, k, *self._vectors, self._weights))

    def _lacking(self, of_magnitudes: float, energy: float) -> float:
        """What the solution lacks once it has gained ``left``: what the next direction would leave of it."""
        if of_magnitudes <= LEAST:
            return of_magnitudes
        share = sqrt(energy / self._whole) if energy >= 0.0 and self._whole > 0.0 else np.nan
        last = share / self._last if self._last else 1.0
        self._last = share
        return share * min(1.0, max(last, min(WORSE * last, FAST), AT_BEST))


@kernel
def _begin(
    known: int, z: Floats, left: Floats, force: Floats, directions: Floats, forces: Floats, images: Floats, energies: Floats,
    weights: Floats,
) -> tuple[float, float, float]:  # fmt: skip
    """Take what is known into z; the energy of what was left before, and the shares of what is left now."""
    n = len(left)
    whole = dot(left, 0, force, 0, n)
    for k in range(known):
        at = k * n
        share = dot(directions, at, force, 0, n) / energies[k]
        add_row(z, 0, share, directions, at, n)
        add_row(force, 0, -share, forces, at, n)
        add_row(left, 0, -share, images, at, n)
    of_magnitudes, energy = _shares(z, left, force, weights)
    return whole, of_magnitudes, energy


@kernel
def _advance(
    rest: Floats, k: int, z: Floats, left: Floats, force: Floats, directions: Floats, forces: Floats, images: Floats,
    energies: Floats,
) -> float:  # fmt: skip
    """Direction number k, of no energy with those before; its share, which is taken into z, 0 where it has no energy."""
    n = len(left)
    at = k * n
    set_direction(left, rest, at, directions, forces)
    for i in range(k):
        add_direction(directions, forces, at, -dot(forces, i * n, directions, at, n) / energies[i], i * n, n)
    energies[k] = dot(directions, at, forces, at, n)
    if not energies[k] > 0.0:
        return 0.0
    share = dot(directions, at, force, 0, n) / energies[k]
    add_row(z, 0, share, directions, at, n)
    add_row(force, 0, -share, forces, at, n)
    return share


@kernel
def _left_anew(
    new: Floats, share: float, k: int, z: Floats, left: Floats, force: Floats, directions: Floats, forces: Floats,
    images: Floats, weights: Floats,
) -> tuple[float, float]:  # fmt: skip
    """What a substitution has found of what is left now; the image of direction number k follows; the shares of what is left."""
    at, per_share = k * len(left), 1.0 / share
    for i in range(len(new)):
        put_at(images, at + i, per_share * (number_at(left, i) - number_at(new, i)))
        put_at(left, i, number_at(new, i))
    return _shares(z, left, force, weights)


@kernel
def _shares(z: Floats, left: Floats, force: Floats, weights: Floats) -> tuple[float, float]:
    """What is left as a share of z, in magnitudes, and its energy."""
    return share_of(z, left, weights), dot(left, 0, force, 0, len(left))
