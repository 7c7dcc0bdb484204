"""A matrix with multipliers, reduced to the motions that its constraints allow."""

from __future__ import annotations

import numpy as np

from lamella.assembly.pattern import Pattern
from lamella.errors import SingularSystemError
from lamella.roles import Floats
from lamella.solve.base import BACKWARD_ERROR_LIMIT, CONDITION_LIMIT, REFINE_ABOVE, LinearSolver, not_finite
from lamella.solve.constraint_group import groups_of
from lamella.solve.lu import MultifrontalLU
from lamella.solve.null_space_kernels import Rows, gather, largest, residual, scaled, solve, spread
from lamella.solve.reduction import Reduction
from lamella.solve.saddle import probe


class NullSpaceSolver(LinearSolver):
    """Solves [[K, J^T], [J, 0]] [x, y] = [r, s] on the null space of J.

    Constraints touch few coordinates: the axes of a rigid body, the nodes at a joint. Those of a group of constraints that
    have coordinates in common are expressed by the group's motions w, see :class:`lamella.solve.constraint_group.Group`,

        x_g = N w + P s_g,      y_g = P^T (r - K x)_g

    and all others are motions themselves. What is left, N^T K N, has fewer rows than K and no multipliers, and where the
    unconstrained K is not, it may be positive definite. It is factorised as L U with pivots on the diagonal, which is checked.

    Args:
        pattern: pattern of K and J.

    Source: M. Benzi, G. H. Golub, J. Liesen, Acta Numerica 14 (2005) 1-137, section 6.
    """

    def __init__(self, pattern: Pattern) -> None:
        self.pattern = pattern
        self._groups = groups_of(pattern)
        self._map = Reduction(pattern, self._groups)
        self._lu = MultifrontalLU(self._map.reduced, self._map.sources)
        reduced, position = self._map.reduced, self._lu.position
        self._k = np.zeros(0)
        columns, sources = (x.astype(np.int32) for x in (position[reduced.indices], self._map.sources))
        self._rows = Rows(position, reduced.indptr, columns, sources)
        self._motions = self._map.motions(position)
        self._maps = *self._motions, *self._map.right, *self._map.down, *self._map.core
        # By position, with zeros where the factorisation has filled up:
        self._probe, self._b, self._z, self._off = (np.zeros(self._lu.n) for _ in range(4))
        self._probe[position] = probe(reduced.n)
        self._rest = np.zeros(pattern.n)
        self._usable = self._refine = False

    @property
    def negative_pivots(self) -> int | None:
        """Of K on the null space of J, known where K is symmetric."""
        return self._lu.negative_pivots if self._usable and self.pattern.symmetric else None

    def factorise(self, k: Floats, j: Floats) -> None:
        """Factorise; an error also when the matrix is regular but the pivots on the diagonal cannot be used."""
        free = self.try_factorise(k, j)
        if free >= 0:
            where = f"row {free} of {self.pattern.n + self.pattern.n_lam}"
            raise not_finite(self.pattern, k, j) or SingularSystemError(f"the system matrix has no usable pivot at {where}", free)

    def try_factorise(self, k: Floats, j: Floats) -> int:
        """Factorise; -1, or the coordinate or multiplier without a usable pivot."""
        self._usable = False
        stiffness = self.pattern.diagonal(k)
        for group in self._groups:
            repeated = group.decompose(j, stiffness)
            if repeated >= 0:
                return self.pattern.n + repeated
        self._map.reduce(k)
        free = self._lu.factorise(k, self._map.mixed)
        if free < 0:
            error, worst = self._backward_error(k)
            self._refine = error > REFINE_ABOVE
            if self._refine:
                self._k = k.copy()
            self._usable = error <= BACKWARD_ERROR_LIMIT
            free = -1 if self._usable else worst
        return -1 if free < 0 else self._map.coordinate_of(free)

    def _backward_error(self, k: Floats) -> tuple[float, int]:
        """Largest |A z - b| / (|z| + |b|) of a known system, scaled to a diagonal of 1, and where it is.

        It is infinite when the matrix is singular; then the motion is told in which z is largest.
        """
        b, z, off, magnitude = self._b, self._z, self._off, self._lu.magnitude
        scaled(magnitude, self._probe, b, z)
        self._lu.solve(z)
        residual(self._rows, k, self._map.mixed, b, z, off)
        error, worst, size, softest = largest(magnitude, off, z)
        if not size < CONDITION_LIMIT:
            return np.inf, self._lu.coordinate_at(softest)
        return error / (size + 1.0), self._lu.coordinate_at(worst)

    def shorten(self, singles: bool = True) -> None:
        """Solve to single precision from now on; constraints hold to rounding all the same."""
        self._lu.shorten()

    def solve(self, r: Floats, s: Floats) -> tuple[Floats, Floats]:
        """Solve by one reduced solution; the multipliers follow from the rows of the constrained coordinates."""
        if not self._usable:
            raise SingularSystemError("there is no factorisation to solve with; factorise a regular matrix first")
        x, y, z, rest = np.empty(self.pattern.n), np.zeros(self.pattern.n_lam), self._z, self._rest
        if not self._refine:
            solve(r, s, x, y, z, rest, *self._maps, *self._lu.arrays)
            return x, y
        gather(r, s, self._motions, self._map.right, self._map.core, x, rest, z)
        self._b[:] = z
        self._lu.solve(z)
        residual(self._rows, self._k, self._map.mixed, self._b, z, self._off)
        self._lu.solve(self._off)
        z += self._off
        spread(r, z, self._motions, self._map.down, self._map.core, rest, x, y)
        return x, y
