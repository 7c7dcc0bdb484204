"""Which poles of a linear system lie on the imaginary axis, or at zero, as far as rounding lets that be known."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from lamella.roles import Floats

MARGINAL = 1e-10
"""Real part, as a share of the fastest pole, below which it is asked how well the pole is known."""
CERTAIN = 1e5
"""Roundings of the matrix's entries by which a pole lies off the axis when it decays for certain; undamped ones reach 1e3."""
ZERO, MIRRORED = 1e-8, 1e-2
"""Size of a pole, as a share of the fastest vibration, and the part of it by which another differs from its mirror image, below
which both are what rounding of the stiffness makes of a rigid-body motion: two poles at zero."""
DROWNED = 1e-15
"""Size of a pole, as a share of the fastest, below which it is zero: what rounding leaves of the damping of a rigid-body motion
without any stiffness decays for certain by its own digits."""


def marginal(A: Floats) -> tuple[NDArray[np.complex128], NDArray[np.bool_], NDArray[np.bool_]]:
    """The poles of x' = A x, whether each is not known to decay, and whether it is zero but for rounding; each of shape (n,).

    With the vectors y^H A = p y^H and A x = p x an error of each entry of A by its rounding eps moves a pole by at most

        eps |y|^T |A| |x| / |y^H x|

    which is small for temperatures beside stiff vibrations that are millions of times faster: a bound that knows the fastest
    pole alone takes them for rigid-body motions. Vectors are those of the balanced matrix.
    """
    if not len(A):
        return np.zeros(0, complex), np.zeros(0, bool), np.zeros(0, bool)
    balanced: Any = linalg.matrix_balance(A, permute=False)[0]
    found: Any = linalg.eig(balanced, left=True, right=True)
    poles, left, right = (np.asarray(part, complex) for part in found)
    decay, fastest = -np.real(poles), np.abs(poles).max()
    along = np.abs(np.sum(left.conj() * right, axis=0))
    rounding = np.finfo(float).eps * np.sum(np.abs(left) * (np.abs(balanced) @ np.abs(right)), axis=0)
    certain = decay * along > CERTAIN * rounding
    small = np.flatnonzero(np.abs(poles) <= max(MARGINAL * fastest, ZERO * np.abs(np.imag(poles)).max()))
    sums = np.abs(poles[small][:, None] + poles[small]) + np.diag(np.full(len(small), np.inf))
    mirrored = np.abs(poles) <= DROWNED * fastest
    mirrored[small] |= (sums <= MIRRORED * np.abs(poles[small])[:, None]).any(axis=1)
    kept = mirrored | ((decay < MARGINAL * fastest) & ~certain)
    return poles, kept, mirrored | (kept & (np.abs(poles) <= MARGINAL * fastest))
