"""The contract of a linear solver."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence

import numpy as np

from lamella.assembly.pattern import Pattern
from lamella.errors import SingularSystemError
from lamella.roles import Floats


class LinearSolver(ABC):
    """Solver of the linear system of one Newton iteration, whose sparsity pattern never changes,

        [ K  J^T ] [ x ]   [ r ]
        [ J   0  ] [ y ] = [ s ]

    1. The constructor does everything that depends on the pattern alone; ``factorise`` and ``solve`` do the rest.
    2. ``factorise`` takes the values of K and J in the order of the pattern and keeps no reference to them.
    3. ``factorise`` raises :class:`SingularSystemError` with the coordinate that is free in ``index`` (multiplier i counts as
       n + i) when the matrix is singular or not finite. After an error there is no factorisation.
    4. ``solve`` may be called any number of times for one factorisation, changes nothing, and returns new arrays.
    5. A solution is right to rounding, or an error is raised: a solver without safe pivoting checks its residual. After
       ``shorten`` it may be rough, until ``factorise`` is called again.
    6. ``negative_pivots`` is the number of negative eigenvalues of K (of K on the null space of J, with multipliers) of the
       last factorisation, None where it is not known. An equilibrium is stable when it is 0.
    """

    pattern: Pattern

    @property
    def negative_pivots(self) -> int | None:
        """Number of negative eigenvalues (rule 6)."""
        return None

    @property
    def work_per_entry(self) -> float:
        """Multiplications of a factorisation for each entry of the factor; a solution takes two for each. Where ``shorten`` makes
        integers of the entries it takes as long as 1.25 would, and 1.6 times as many are told.

        That of 6x6 elements where it is not known.
        """
        return 30.0

    @abstractmethod
    def factorise(self, k: Floats, j: Floats) -> None:
        """Factorise the matrix with values ``k`` (nnz,) and ``j`` (j_nnz,)."""

    @abstractmethod
    def solve(self, r: Floats, s: Floats) -> tuple[Floats, Floats]:
        """Solution x (n,), y (n_lam,) for the right-hand side r (n,), s (n_lam,)."""

    def shorten(self, singles: bool = True) -> None:  # noqa: B027 - those that gain nothing by it leave it out
        """From now on the factorisation serves for matrices near the one that it is of: solve roughly if faster.

        Args:
            singles: whether substitutions may compute in single precision too, so that they are linear but for its rounding.
        """

    def solve_each(self, rights: Sequence[tuple[Floats, Floats]]) -> list[tuple[Floats, Floats]]:
        """Solutions for several right-hand sides, which may cost less together."""
        return [self.solve(r, s) for r, s in rights]


class SymmetricFactor(ABC):
    """Factorisation of a symmetric matrix K of fixed pattern, without multipliers.

    1. ``factorise`` returns -1 on success, else a coordinate whose pivot it cannot use.
    2. ``negative_pivots`` is the number of negative pivots of the last factorisation. Pivots are not chosen for accuracy, and
       the caller checks the result.
    3. ``solve`` takes one right-hand side (n,) or several as columns (n, m).
    """

    pattern: Pattern
    negative_pivots: int = 0
    cost: float
    """Multiplications, each with an addition, of one factorisation."""
    size: int
    """Entries of the factor."""
    shortens: bool = False
    """Whether ``shorten`` makes integers of them, as far as pivots allow."""

    @abstractmethod
    def factorise(self, k: Floats) -> int:
        """Factorise; -1, or the coordinate where it failed."""

    @abstractmethod
    def solve(self, r: Floats) -> Floats:
        """K^-1 r for the last successful factorisation."""

    def shorten(self, singles: bool = True) -> None:  # noqa: B027
        """As :meth:`LinearSolver.shorten`."""


PIVOT_TOLERANCE = 64 * np.finfo(float).eps
"""A pivot below this fraction of its diagonal entry is rounding error: some tens of updates of one rounding each."""

CONDITION_LIMIT = 1e14
"""Estimated condition of the equilibrated matrix above which it counts as singular: rounding makes a singular matrix appear
with 1e15 and more."""

BACKWARD_ERROR_LIMIT = 1e-10
"""Largest |A z - b| / (|z| + |b|), equilibrated, of a factorisation that is used; pivots on the diagonal alone may exceed it."""


def singular(pattern: Pattern, index: int) -> SingularSystemError:
    """The error for a matrix in which coordinate or multiplier ``index`` is free."""
    if index < pattern.n:
        problem = f"independent coordinate {index} of {pattern.n} is not held: a body or mechanism can move freely"
    else:
        problem = f"multiplier {index - pattern.n} of {pattern.n_lam} is not determined: a constraint is redundant"
    return SingularSystemError(f"the system matrix is singular; {problem}", index)


def not_finite(pattern: Pattern, k: Floats, j: Floats) -> SingularSystemError | None:
    """The error for a matrix that holds NaN or infinity, None when all values are finite."""
    bad = np.flatnonzero(~np.isfinite(k))
    if bad.size:
        index = int(pattern.rows[bad[0]])
        return SingularSystemError(f"the system matrix is not finite in the row of independent coordinate {index}", index)
    bad = np.flatnonzero(~np.isfinite(j))
    if bad.size:
        index = int(pattern.j_rows[bad[0]])
        return SingularSystemError(f"the constraint Jacobian is not finite in row {index}", pattern.n + index)
    return None


REFINE_ABOVE = 1e-13
"""Backward error of a factorisation above which each solution is refined once."""
