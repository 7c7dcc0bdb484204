"""Cubic Hermite polynomials on the unit interval."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray


def cubic_hermite(s: ArrayLike) -> NDArray[np.float64]:
    """The four cubic Hermite polynomials with their first and second derivatives.

    phi_0 = 1 - 3 s^2 + 2 s^3,  phi_1 = s - 2 s^2 + s^3,  phi_2 = 3 s^2 - 2 s^3,  phi_3 = s^3 - s^2

    interpolate value and slope at s = 0 (phi_0, phi_1) and at s = 1 (phi_2, phi_3).

    Args:
        s: coordinates in [0, 1], shape (...).

    Returns:
        Derivatives 0, 1, 2 of the four functions, shape (3, 4, ...).
    """
    s = np.asarray(s, float)
    one = np.ones_like(s)
    return np.array(
        [
            [1 - s**2 * (3 - 2 * s), s * (1 - s) ** 2, s**2 * (3 - 2 * s), s**2 * (s - 1)],
            [6 * s * (s - 1), (1 - s) * (1 - 3 * s), 6 * s * (1 - s), s * (3 * s - 2)],
            [12 * s - 6, 6 * s - 4, 6 - 12 * s, 6 * s - 2 * one],
        ]
    )
