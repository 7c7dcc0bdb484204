"""Corrections with a kept factorisation, improved by the secants of the iterates since (BFGS)."""

from __future__ import annotations

import numpy as np

from lamella._jit import njit
from lamella.roles import Floats
from lamella.solve.base import LinearSolver

MEMORY = 8
"""Secants remembered; 4 to 16 take the same iterations."""
LEAST_SHARE = 0.05
"""Share of the stiffness which the factorised matrix has along a correction, below which a secant is not used: the matrix may
have become indefinite, and the update divides by it."""


class SecantCorrections:
    """Corrections -H g of the unknowns z = (u, lam) for the residual g = (r, Phi); H is the inverse of the factorised matrix A,
    updated with the last corrections s and the changes y of the residual they made,

        H <- (I - s y^T / s.y) H (I - y s^T / s.y) + s s^T / s.y,      so that H y = s

    applied as products, without forming H. The update keeps H symmetric, so an unsymmetric matrix is left as it is.

    Args:
        linear: holds the factorisation.

    Source: J. Nocedal, Updating quasi-Newton matrices with limited storage, Mathematics of Computation 35 (1980) 773-782;
    for finite elements H. Matthies and G. Strang, Int. J. Numer. Meth. Engng 14 (1979) 1613-1626.
    """

    def __init__(self, linear: LinearSolver) -> None:
        self.linear, self._n_u = linear, linear.pattern.n
        n = self._n_u + linear.pattern.n_lam
        self._s, self._y, self._sy, self._shares = np.zeros((MEMORY, n)), np.zeros((MEMORY, n)), np.ones(MEMORY), np.zeros(MEMORY)
        self.forget()

    def forget(self) -> None:
        """Start anew: the factorisation, or what is solved, is another one."""
        self._count, self._last = 0, None

    def __call__(self, r: Floats, phi: Floats) -> tuple[Floats, Floats]:
        """The correction du (n_u,), dlam (n_lam,), which is taken to be made before the next call."""
        g = np.concatenate([r, phi]) if len(phi) else r
        if self._last is not None and self.linear.pattern.symmetric:
            self._count = _learn(g, *self._last, self._s, self._y, self._sy, self._count)
        h = g
        if self._count:
            h = np.empty_like(g)
            _before(g, self._s, self._y, self._sy, self._count, self._shares, h)
        x, lam = self.linear.solve(h[: self._n_u], h[self._n_u :])
        z = np.concatenate([x, lam]) if len(lam) else x
        _after(z, self._s, self._y, self._sy, self._count, self._shares)
        self._last = g, z
        return z[: self._n_u], z[self._n_u :]


@njit
def _learn(g: Floats, g_last: Floats, s_last: Floats, s: Floats, y: Floats, sy: Floats, count: int) -> int:
    """Remember the last correction, unless it met too little stiffness; the number of secants remembered.

    The factorised matrix A, with older secants, has the stiffness s.A s = -s.g at the last residual.
    """
    change = g - g_last
    product, expected = s_last @ change, -(s_last @ g_last)
    if not product * expected > LEAST_SHARE * expected**2:
        return count
    if count == MEMORY:
        count -= 1
        for i in range(count):
            s[i], y[i], sy[i] = s[i + 1], y[i + 1], sy[i + 1]
    s[count], y[count], sy[count] = s_last, change, product
    return count + 1


@njit
def _before(g: Floats, s: Floats, y: Floats, sy: Floats, count: int, shares: Floats, h: Floats) -> None:
    """h <- (I - y s^T / s.y) ... g, the latest first; ``shares`` keeps s.g / s.y of each."""
    h[:] = g
    for i in range(count - 1, -1, -1):
        shares[i] = (s[i] @ h) / sy[i]
        h -= shares[i] * y[i]


@njit
def _after(z: Floats, s: Floats, y: Floats, sy: Floats, count: int, shares: Floats) -> None:
    """z <- minus (I - s y^T / s.y) z + share s, the latest last."""
    for i in range(count):
        z += (shares[i] - (y[i] @ z) / sy[i]) * s[i]
    for i in range(len(z)):
        z[i] = -z[i]
