"""Choice of the linear solver."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, get_args

from lamella.assembly.pattern import Pattern
from lamella.errors import ModelError
from lamella.roles import Floats
from lamella.solve.band import BandCholesky
from lamella.solve.base import LinearSolver
from lamella.solve.constraint_group import groups_of, reduction_cost
from lamella.solve.multifrontal import Multifrontal
from lamella.solve.null_space import NullSpaceSolver
from lamella.solve.pardiso import PardisoSolver, library
from lamella.solve.schur import SchurSolver
from lamella.solve.superlu import SuperLUSolver

Method = Literal["auto", "multifrontal", "band", "superlu", "pardiso"]

PARDISO_FROM = 300
"""Coordinates and multipliers from which PARDISO, when installed, takes the place of SuperLU in ``auto``."""

LU_COST = 2.0
"""Time of a factorisation L U on the null space of the constraints, in symmetric ones of K by fronts."""

REDUCTION_COST = 2e4
"""Operations per unknown that finding the null space of the constraints may take; a general factorisation takes some 10 us."""


class AutomaticSolver(LinearSolver):
    """Factorisation with pivots on the diagonal where that is accurate, a general solver where it is not.

    A positive definite matrix needs no exchange of rows. A tangent loses definiteness under compression and far from
    equilibrium; its factorisation is then checked, and given up for a general solver when it fails. The next factorisation
    starts with the diagonal again. ``n_general`` counts those that needed the general solver.

    Args:
        fixed: solver with pivots on the diagonal.
    """

    def __init__(self, fixed: SchurSolver | NullSpaceSolver) -> None:
        self.pattern, self._fixed = fixed.pattern, fixed
        self._general: LinearSolver | None = None
        self._active: LinearSolver = fixed
        self.n_general = 0

    @property
    def negative_pivots(self) -> int | None:
        """Of the solver that factorised last."""
        return self._active.negative_pivots

    @property
    def work_per_entry(self) -> float:
        """Of the solver with pivots on the diagonal."""
        return self._fixed.work_per_entry

    def factorise(self, k: Floats, j: Floats) -> None:
        """Factorise with pivots on the diagonal, else by a general solver, which names the coordinate of a singular matrix."""
        self._active = self._fixed
        if self._fixed.try_factorise(k, j) < 0:
            return
        if self._general is None:
            self._general = general_solver(self.pattern)
        self.n_general += 1
        self._general.factorise(k, j)
        self._active = self._general

    def shorten(self, singles: bool = True) -> None:
        """Solve roughly from now on."""
        self._active.shorten(singles)

    def solve(self, r: Floats, s: Floats) -> tuple[Floats, Floats]:
        """Solve with the last factorisation."""
        return self._active.solve(r, s)

    def solve_each(self, rights: Sequence[tuple[Floats, Floats]]) -> list[tuple[Floats, Floats]]:
        """Solve several with the last factorisation."""
        return self._active.solve_each(rights)


def general_solver(pattern: Pattern) -> LinearSolver:
    """The fastest installed solver that takes any regular matrix."""
    if pattern.n + pattern.n_lam >= PARDISO_FROM and library() is not None:
        return PardisoSolver(pattern)
    return SuperLUSolver(pattern)


def linear_solver(pattern: Pattern, method: Method = "auto") -> LinearSolver:
    """The solver for a pattern.

    Args:
        pattern: sparsity pattern of K and J.
        method: ``multifrontal`` (pivots on the diagonal), ``band`` (LAPACK, positive definite only), ``superlu`` (any
            matrix), ``pardiso`` (any matrix; needs the extra ``mkl``), or ``auto``: ``multifrontal``, and ``pardiso`` when
            installed, else ``superlu``, for the matrices it cannot factorise.

    Raises:
        ValueError: an unknown method, or one that cannot take the pattern.
        MissingExtraError: ``pardiso`` without the package ``mkl``.
        ModelError: there is nothing to solve for.
    """
    if pattern.n == 0:
        raise ModelError("supports and joints hold every coordinate of the system, so nothing can move; leave something free")
    if method not in get_args(Method):
        raise ValueError(f"linear solver '{method}' is not known; choose one of {', '.join(get_args(Method))}")
    if method == "superlu":
        return SuperLUSolver(pattern)
    if method == "pardiso":
        return PardisoSolver(pattern)
    if method == "band":
        if not pattern.symmetric:
            raise ValueError("linear solver 'band' takes symmetric matrices only; choose 'auto'")
        return SchurSolver(BandCholesky(pattern))
    if pattern.n <= pattern.n_lam:
        return general_solver(pattern)
    if method == "multifrontal":
        return _few_multipliers(pattern) or NullSpaceSolver(pattern)
    fixed = _few_multipliers(pattern) or _short_null_space(pattern)
    return AutomaticSolver(fixed) if fixed else general_solver(pattern)


def _few_multipliers(pattern: Pattern) -> SchurSolver | None:
    """The solver for symmetric matrices, unless their many multipliers make the Schur complement cost too much."""
    if not pattern.symmetric:
        return None
    factor = Multifrontal(pattern)
    return SchurSolver(factor) if 2.0 * pattern.n_lam * factor.size <= LU_COST * factor.cost else None


def _short_null_space(pattern: Pattern) -> NullSpaceSolver | None:
    """The solver on the null space, unless constraints hang together in such numbers that the null space costs too much."""
    cost = reduction_cost(pattern, groups_of(pattern))
    return NullSpaceSolver(pattern) if cost <= REDUCTION_COST * (pattern.n + pattern.n_lam) else None
