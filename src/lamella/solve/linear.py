"""Choice of the linear solver."""

from __future__ import annotations

from typing import Literal, get_args

from lamella.assembly.pattern import Pattern
from lamella.roles import Floats
from lamella.solve.band import BandCholesky
from lamella.solve.base import LinearSolver
from lamella.solve.schur import SchurSolver
from lamella.solve.superlu import SuperLUSolver

Method = Literal["auto", "band", "superlu"]

BAND_BYTES = 200e6
"""Band storage above which the sparse factorisation is used instead."""


class AutomaticSolver(LinearSolver):
    """Cholesky factorisation where the matrix is positive definite, SuperLU where it is not.

    A tangent loses definiteness under compression and far from equilibrium, usually for some iterations only, so each
    factorisation starts with Cholesky again. ``n_indefinite`` counts those that needed SuperLU.

    Args:
        definite: solver of positive definite matrices.
    """

    def __init__(self, definite: SchurSolver) -> None:
        self.pattern, self._definite = definite.pattern, definite
        self._general: SuperLUSolver | None = None
        self._active: LinearSolver = definite
        self.n_indefinite = 0

    @property
    def negative_pivots(self) -> int | None:
        """Of the solver that factorised last."""
        return self._active.negative_pivots

    def factorise(self, k: Floats, j: Floats) -> None:
        """Factorise by Cholesky, else by SuperLU, which names the coordinate of a singular matrix."""
        self._active = self._definite
        if self._definite.try_factorise(k, j) < 0:
            return
        if self._general is None:
            self._general = SuperLUSolver(self.pattern)
        self.n_indefinite += 1
        self._general.factorise(k, j)
        self._active = self._general

    def solve(self, r: Floats, s: Floats) -> tuple[Floats, Floats]:
        """Solve with the last factorisation."""
        return self._active.solve(r, s)


def linear_solver(pattern: Pattern, method: Method = "auto") -> LinearSolver:
    """The solver for a pattern.

    Args:
        pattern: sparsity pattern of K and J.
        method: ``band`` (Cholesky in a band: positive definite only), ``superlu`` (any matrix), or ``auto``: ``band`` with
            ``superlu`` for indefinite matrices; ``superlu`` alone when K is unsymmetric, the band is too wide, or the multipliers
            are so many that the Schur complement costs more than the factorisation by far.

    Raises:
        ValueError: an unknown method, or one that cannot take the pattern.
    """
    if method not in get_args(Method):
        raise ValueError(f"linear solver '{method}' is not known; choose one of {', '.join(get_args(Method))}")
    if method == "superlu":
        return SuperLUSolver(pattern)
    if not pattern.symmetric:
        if method == "auto":
            return SuperLUSolver(pattern)
        raise ValueError(f"linear solver '{method}' takes symmetric matrices only; choose 'superlu' or 'auto'")
    band = BandCholesky(pattern)
    if method == "band":
        return SchurSolver(band)
    width = band.bandwidth + 1
    too_wide = 8.0 * pattern.n * width > BAND_BYTES
    return SuperLUSolver(pattern) if too_wide or pattern.n_lam > 2 * width else AutomaticSolver(SchurSolver(band))
