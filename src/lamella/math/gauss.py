"""Gauss-Legendre quadrature on the unit interval."""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray


@cache
def gauss_rule(n: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Points and weights of the n-point Gauss-Legendre rule: int_0^1 f(s) ds = sum_k w_k f(s_k), exact up to degree 2 n - 1.

    Args:
        n: number of points, at least 1.

    Returns:
        Points in (0, 1) in ascending order, shape (n,), and weights that sum to 1, shape (n,).

    Raises:
        ValueError: n is not positive.
    """
    if n < 1:
        raise ValueError(f"a Gauss rule needs at least 1 point, got {n}")
    points, weights = np.polynomial.legendre.leggauss(n)
    found = 0.5 * (points + 1.0), 0.5 * weights
    for part in found:
        part.flags.writeable = False  # all who ask for the rule share it
    return found
