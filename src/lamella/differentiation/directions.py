"""What the two ways to solve by directions have in common."""

from __future__ import annotations

from abc import ABC, abstractmethod
from math import sqrt

import numpy as np

from lamella._jit import inner
from lamella.lane import WIDTH, number_at, put_at
from lamella.lane_rows import add_row, set_row, weighed_dot
from lamella.roles import Floats

LEAST = 1e-12
"""What a solution may lack in any case, as a share of it: below lies rounding."""


class Directions(ABC):
    """Solves A z = b for several b, with a matrix B near A: keeps directions p with their images from one b to the next.

    With ``left`` = B^-1 (b - A z) each direction that is added is ``left`` itself, made conjugate to those before.

    ``begin`` starts with a b, and takes what is known into z; a method's own ``improve`` adds a direction. Both tell how much the
    solution will lack then, in whatever way the method measures; not a number where it fails.

    Args:
        per_magnitude: 1 / magnitude of each unknown, shape (n,).
        n_lam: number of multipliers, behind them, which do not count.
        most: directions that are kept; the next one begins anew.

    Attributes:
        left: see above, shape (n + n_lam,).
        known: number of directions.
    """

    def __init__(self, per_magnitude: Floats, n_lam: int, most: int) -> None:
        self._most, self.known = most, 0
        n = len(per_magnitude) + n_lam
        self._padded = -(-n // WIDTH) * WIDTH
        self._weights = np.zeros(self._padded)
        self._weights[: len(per_magnitude)] = per_magnitude**2
        self._z, self._left = np.zeros((2, self._padded))
        self.left = self._left[:n]
        self._solution = self._z[:n]

    def forget(self) -> None:
        """A or B is another one."""
        self.known = 0

    def _start(self, z: Floats | None, left: Floats) -> None:
        if z is None:
            self._z[:] = 0.0
        else:
            self._solution[:] = z
        self.left[:] = left

    def _place(self) -> int:
        """Number of the direction that is added."""
        if self.known == self._most:
            self.known = 0
        self.known += 1
        return self.known - 1

    @abstractmethod
    def begin(self, z: Floats | None, left: Floats, force: Floats) -> float:
        """Start from z, or from zero, with what is left there.

        Args:
            z: see above.
            left, force: B^-1 (b - A z) and b - A z.
        """

    def solution(self) -> Floats:
        """z with what is left, as if A were B, shape (n + n_lam,)."""
        return self._solution + self.left


@inner
def set_direction(left: Floats, rest: Floats, at: int, directions: Floats, images: Floats) -> None:
    """The direction ``left`` with its image -``rest``, at a place of the rows of both."""
    set_row(directions, at, 1.0, left, 0, len(left))
    for i in range(len(rest)):
        put_at(images, at + i, -number_at(rest, i))


@inner
def add_direction(directions: Floats, images: Floats, at: int, factor: float, other: int, n: int) -> None:
    """Add another direction to one, and its image to that of the one."""
    add_row(directions, at, factor, directions, other, n)
    add_row(images, at, factor, images, other, n)


@inner
def share_of(z: Floats, left: Floats, weights: Floats) -> float:
    """What is left as a share of z, in magnitudes."""
    size, rest = weighed_dot(z, 0, z, 0, weights), weighed_dot(left, 0, left, 0, weights)
    return sqrt(rest / size) if size > 0.0 else np.inf if rest > 0.0 else 0.0
