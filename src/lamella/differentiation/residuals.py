"""Generalised conjugate residuals: directions with their images, and what they tell of a solution."""

from __future__ import annotations

from math import sqrt

import numpy as np

from lamella._jit import inner, kernel
from lamella.lane import WIDTH, number_at, put_at
from lamella.lane_rows import add_row, dot, set_row, weighed_dot
from lamella.roles import Floats

LEAST = 1e-12
"""What a solution may lack in any case, as a share of it: below lies rounding."""

AT_BEST = 0.02
"""Share of what is left that the next direction is expected to leave at least, however little the last one has left by chance."""


class ConjugateResiduals:
    """Solves C z = B^-1 b with C = B^-1 A for several b: keeps the directions p with their images C p, which are orthonormal,
    from one b to the next.

    With ``left`` = B^-1 (b - A z) each direction that is added is ``left`` itself, made conjugate to those before. Scalar
    products are those of unknowns in their magnitudes, or by their energy, x . B y, where products with A are at hand:
    C p . B C q = C p . A q. Of a plate, whose membrane is stiffer than its bending by orders of magnitude, the second needs half
    as many directions for the same forces. Multipliers do not count.

    Args:
        per_magnitude: 1 / magnitude of each unknown, shape (n,).
        n_lam: number of multipliers, behind them.
        most: directions that are kept; the next one begins anew.

    Attributes:
        by_energy: whether scalar products are those of energy; to be changed before the first direction is added.

    Source: S. C. Eisenstat, H. C. Elman, M. H. Schultz, SIAM J. Numer. Anal. 20 (1983) 345-357, algorithm GCR.
    """

    def __init__(self, per_magnitude: Floats, n_lam: int, most: int) -> None:
        self._most, self._known, self._n = most, 0, len(per_magnitude)
        n = self._n + n_lam
        padded = -(-n // WIDTH) * WIDTH
        self._weights = np.zeros(padded)
        self._weights[: self._n] = per_magnitude**2
        self._z, self._left, self._force = np.zeros((3, padded))
        self._directions, self._images, self._forces = np.zeros((3, most * padded))
        self.left = self._left[:n]
        """What is left now, shape (n,)."""
        self.force = self._force[: self._n]
        """b - A z, of the unknowns alone, where scalar products are those of energy."""
        self._solution = self._z[:n]
        self._vectors = self._z, self._left, self._force, self._directions, self._images, self._forces, self._weights
        self.by_energy, self._whole, self._last = False, 0.0, 0.0

    def forget(self) -> None:
        """C is another one."""
        self._known = 0

    def begin(self, z: Floats | None, left: Floats, force: Floats) -> float:
        """Start from z, or from zero, with what is left there.

        Args:
            z, left: see above.
            force: b - A z of the unknowns; used where scalar products are those of energy.

        Returns:
            How much the solution will lack beside what is known: as a share of z, or by energy of what is left here.
        """
        if z is None:
            self._z[:] = 0.0
        else:
            self._solution[:] = z
        self.left[:] = left
        if self.by_energy:
            self.force[:] = force
        self._whole, of_magnitudes, energy = _begin(self._known, *self._vectors, self.by_energy)
        self._last = 0.0
        return self._lacking(of_magnitudes, energy)

    def improve(self, lacking: Floats, rest: Floats) -> float:
        """Add the direction ``left``, of which C left = -``lacking`` and A left = -``rest``.

        Returns:
            How much the solution will lack then; not a number where an energy is not positive.
        """
        if self._known == self._most:
            self._known = 0
        self._known += 1
        return self._lacking(*_improve(lacking, rest, self._known - 1, *self._vectors, self.by_energy))

    def _lacking(self, of_magnitudes: float, energy: float) -> float:
        """By energy each direction leaves a like share: what the last one has left is what the solution gains by ``left``."""
        if not self.by_energy or of_magnitudes <= LEAST:
            return of_magnitudes
        share = sqrt(energy / self._whole) if energy >= 0.0 and self._whole > 0.0 else np.nan
        left = min(1.0, max(share / self._last, AT_BEST)) if self._last else 1.0
        self._last = share
        return left * share

    def solution(self) -> Floats:
        """z with what is left, as if C were the identity, shape (n,)."""
        return self._solution + self.left


@kernel
def _begin(
    known: int, z: Floats, left: Floats, force: Floats, directions: Floats, images: Floats, forces: Floats, weights: Floats,
    by_energy: bool,
) -> tuple[float, float, float]:  # fmt: skip
    """Take what is known into z; the energy of what was left before, and the shares of what is left now."""
    whole = dot(left, 0, force, 0, len(left)) if by_energy else 0.0
    for k in range(known):
        _take(z, left, force, k, directions, images, forces, weights, by_energy)
    of_magnitudes, energy = _shares(z, left, force, weights)
    return whole, of_magnitudes, energy


@kernel
def _improve(
    lacking: Floats, rest: Floats, k: int, z: Floats, left: Floats, force: Floats, directions: Floats, images: Floats,
    forces: Floats, weights: Floats, by_energy: bool,
) -> tuple[float, float]:  # fmt: skip
    """Direction number k is made conjugate to those before, its image of length 1; the shares of what is left then."""
    n = len(left)
    at = k * n
    set_row(directions, at, 1.0, left, 0, n)
    for i in range(len(lacking)):
        put_at(images, at + i, -number_at(lacking, i))
    if by_energy:
        for i in range(len(rest)):
            put_at(forces, at + i, -number_at(rest, i))
    for before in range(0, at, n):
        share = _product(images, forces, before, images, at, weights, by_energy)
        add_row(directions, at, -share, directions, before, n)
        add_row(images, at, -share, images, before, n)
        if by_energy:
            add_row(forces, at, -share, forces, before, n)
    size = _product(images, forces, at, images, at, weights, by_energy)
    if not size > 0.0:
        return np.nan, np.nan
    factor = 1.0 / sqrt(size)
    set_row(directions, at, factor, directions, at, n)
    set_row(images, at, factor, images, at, n)
    if by_energy:
        set_row(forces, at, factor, forces, at, n)
    _take(z, left, force, k, directions, images, forces, weights, by_energy)
    return _shares(z, left, force, weights)


@inner
def _take(
    z: Floats, left: Floats, force: Floats, k: int, directions: Floats, images: Floats, forces: Floats, weights: Floats,
    by_energy: bool,
) -> None:  # fmt: skip
    """Take the share of a direction in what is left into z."""
    n = len(left)
    share = _product(images, forces, k * n, left, 0, weights, by_energy)
    add_row(z, 0, share, directions, k * n, n)
    add_row(left, 0, -share, images, k * n, n)
    if by_energy:
        add_row(force, 0, -share, forces, k * n, n)


@inner
def _product(images: Floats, forces: Floats, at: int, x: Floats, x_at: int, weights: Floats, by_energy: bool) -> float:
    """The scalar product of an image, whose force is known where it is by energy, with x."""
    if by_energy:
        return dot(forces, at, x, x_at, len(weights))
    return weighed_dot(images, at, x, x_at, weights)


@inner
def _shares(z: Floats, left: Floats, force: Floats, weights: Floats) -> tuple[float, float]:
    """What is left as a share of z, by magnitudes, and its energy."""
    size, rest = weighed_dot(z, 0, z, 0, weights), weighed_dot(left, 0, left, 0, weights)
    share = sqrt(rest / size) if size > 0.0 else np.inf if rest > 0.0 else 0.0
    return share, dot(left, 0, force, 0, len(left))
