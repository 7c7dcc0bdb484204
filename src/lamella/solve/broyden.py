"""Corrections with a kept factorisation of an unsymmetric matrix, improved by the steps since (Broyden)."""

from __future__ import annotations

import numpy as np

from lamella._jit import kernel
from lamella.lane import WIDTH
from lamella.lane_rows import add_row, weighed_dot
from lamella.roles import Floats
from lamella.solve.base import LinearSolver

MEMORY = 8
"""Steps remembered, after which the updates begin anew."""
MOST_SHARE = 0.8
"""Share of the last step that comes back as the next, above which the update would stretch it more than five times."""


class BroydenCorrections:
    """Corrections -H g of the unknowns z = (u, lam) for the residual g = (r, Phi); H is the inverse of the factorised matrix A,
    updated with the steps s_k that were made since,

        H_k+1 = (I + s_k+1 s_k^T W / (s_k^T W s_k)) H_k,      so that H_k+1 y_k = s_k

    which is Broyden's first update in the norm of W: that of the matrix nearest to the one before that meets the last secant.
    W weighs a coordinate by its magnitude, and multipliers not at all.

    Args:
        linear: holds the factorisation.
        per_magnitude: one over the magnitude of each unknown u, shape (n,).

    Source: C. T. Kelley, Iterative Methods for Linear and Nonlinear Equations, SIAM 1995, section 7.3.
    """

    def __init__(self, linear: LinearSolver, per_magnitude: Floats) -> None:
        self.linear = linear
        n_u, n = linear.pattern.n, linear.pattern.n + linear.pattern.n_lam
        padded = -(-n // WIDTH) * WIDTH
        self._s, self._squares = np.zeros(MEMORY * padded), np.ones(MEMORY)
        self._z, self._weights = np.zeros(padded), np.zeros(padded)
        self._weights[:n_u] = per_magnitude**2
        self._du, self._dlam = self._z[:n_u], self._z[n_u:n]
        self.forget()

    def forget(self) -> None:
        """Start anew: the factorisation, or what is solved, is another one, or a step was not made as given."""
        self._made = 0

    def __call__(self, r: Floats, phi: Floats) -> tuple[Floats, Floats]:
        """The correction du (n_u,), dlam (n_lam,), which is taken to be made before the next call, and is overwritten by that."""
        x, lam = self.linear.solve(r, phi)
        self._made = _next_step(x, lam, self._made, self._s, self._squares, self._weights, self._z)
        return self._du, self._dlam


@kernel
def _next_step(x: Floats, lam: Floats, made: int, s: Floats, squares: Floats, weights: Floats, z: Floats) -> int:
    """z <- -H (r, phi) from A^-1 (r, phi) = (x, lam) and the ``made`` steps in the rows of ``s``, and store it as the next.

    Returns:
        The number of steps stored; one where the updates began anew.
    """
    n = len(z)
    for i in range(len(x)):
        z[i] = -x[i]
    for i in range(len(lam)):
        z[len(x) + i] = -lam[i]
    if made == MEMORY:
        made = 0
    for k in range(made - 1):
        add_row(z, 0, weighed_dot(s, k * n, z, 0, weights) / squares[k], s, (k + 1) * n, n)
    if made > 0:
        share = weighed_dot(s, (made - 1) * n, z, 0, weights) / squares[made - 1]
        if share < MOST_SHARE:
            for i in range(n):
                z[i] /= 1.0 - share
        else:  # hardly any progress, or no number
            made = 0
    for i in range(n):
        s[made * n + i] = z[i]
    squares[made] = weighed_dot(z, 0, z, 0, weights)
    return made + 1
