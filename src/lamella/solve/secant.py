"""Corrections with a kept factorisation of a symmetric matrix, improved by the secants of the iterates since (BFGS)."""

from __future__ import annotations

import numpy as np

from lamella._jit import kernel
from lamella.lane import WIDTH, load_at, store_at
from lamella.lane_rows import add_row, dot
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

    applied as products, without forming H. The update keeps H symmetric; for others see
    :class:`~lamella.solve.broyden.BroydenCorrections`.

    Args:
        linear: holds the factorisation.

    Source: J. Nocedal, Updating quasi-Newton matrices with limited storage, Mathematics of Computation 35 (1980) 773-782;
    for finite elements H. Matthies and G. Strang, Int. J. Numer. Meth. Engng 14 (1979) 1613-1626.
    """

    def __init__(self, linear: LinearSolver) -> None:
        self.linear, self._n_u = linear, linear.pattern.n
        self._n = n = linear.pattern.n + linear.pattern.n_lam
        padded = -(-n // WIDTH) * WIDTH
        self._s, self._y = np.zeros(MEMORY * padded), np.zeros(MEMORY * padded)
        self._sy, self._shares = np.ones(MEMORY), np.zeros(MEMORY)
        self._g, self._z, self._h = np.zeros(padded), np.zeros(padded), np.zeros(padded)
        self._h_u, self._h_lam = self._h[: self._n_u], self._h[self._n_u : n]
        self._du, self._dlam = self._z[: self._n_u], self._z[self._n_u : n]
        self.forget()

    def forget(self) -> None:
        """Start anew: the factorisation, or what is solved, is another one."""
        self._learnt, self._corrected = 0, False

    def __call__(self, r: Floats, phi: Floats) -> tuple[Floats, Floats]:
        """The correction du (n_u,), dlam (n_lam,), which is taken to be made before the next call, and is overwritten by that."""
        self._learnt = _before(
            r, phi, self._corrected, self._learnt, self._s, self._y, self._sy, self._shares, self._g, self._z, self._h
        )  # fmt: skip
        x, lam = self.linear.solve(self._h_u, self._h_lam)
        _after(x, lam, self._learnt, self._s, self._y, self._sy, self._shares, self._z)
        self._corrected = True
        return self._du, self._dlam


@kernel
def _before(
    r: Floats, phi: Floats, learns: bool, learnt: int,
    s: Floats, y: Floats, sy: Floats, shares: Floats, g: Floats, z: Floats, h: Floats,
) -> int:  # fmt: skip
    """h <- (I - y s^T / s.y) ... (r, phi), the latest first; ``shares`` keeps s.g / s.y of each.

    Before that the last correction z is remembered, if ``learns`` and unless it met too little stiffness. The factorised matrix
    A, with older secants, has the stiffness s.A s = -s.g at the last residual g. Secant number i lies in row i % MEMORY.

    Returns:
        The number of secants learnt, of which the last ``MEMORY`` are remembered.
    """
    n = len(h)
    for i in range(len(r)):  # assigning a slice would compile Numba's text functions, for a message
        h[i] = r[i]
    for i in range(len(phi)):
        h[len(r) + i] = phi[i]
    if learns:
        stiffness = -dot(z, 0, g, 0, n)
        product = dot(z, 0, h, 0, n) + stiffness
        if product * stiffness > LEAST_SHARE * stiffness**2:
            row = learnt % MEMORY
            for i in range(0, n, WIDTH):
                store_at(s, row * n + i, load_at(z, i))
                store_at(y, row * n + i, load_at(h, i) - load_at(g, i))
            sy[row] = product
            learnt += 1
    for i in range(n):
        g[i] = h[i]
    for i in range(learnt - 1, max(learnt - MEMORY, 0) - 1, -1):
        row = i % MEMORY
        shares[row] = dot(s, row * n, h, 0, n) / sy[row]
        add_row(h, 0, -shares[row], y, row * n, n)
    return learnt


@kernel
def _after(x: Floats, lam: Floats, learnt: int, s: Floats, y: Floats, sy: Floats, shares: Floats, z: Floats) -> None:
    """z <- minus (I - s y^T / s.y) (x, lam) + share s, the latest last."""
    n = len(z)
    for i in range(len(x)):
        z[i] = x[i]
    for i in range(len(lam)):
        z[len(x) + i] = lam[i]
    for i in range(max(learnt - MEMORY, 0), learnt):
        row = i % MEMORY
        add_row(z, 0, shares[row] - dot(y, row * n, z, 0, n) / sy[row], s, row * n, n)
    for i in range(n):
        z[i] = -z[i]
