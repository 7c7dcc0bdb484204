"""Steps that solve for temperatures and for motion one after the other."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from lamella.assembly.equations import Equations
from lamella.assembly.pattern import Pattern
from lamella.assembly.point import Point, Weights
from lamella.integrate.stabilised import StabilisedEquations
from lamella.result import Statistics
from lamella.roles import Floats
from lamella.solve.linear import Method, linear_solver
from lamella.solve.newton import Newton, NewtonReport, NewtonSolver
from lamella.solve.turned import Vectors


class PartialEquations:
    """The equations of some unknowns while the others stay as they are in a point that is given.

    Its points hold the chosen unknowns only. Its matrix is that part of the whole one, the symmetric part where only tangents
    that couple it to the rest stand in the way of symmetry.

    Args:
        equations: the equations of the model, or their stabilised form.
        whole: the equations of the model.
        first, last: the independent coordinates from ``first`` up to but not ``last``.
        multipliers: whether the multipliers belong to this part.
    """

    def __init__(
        self, equations: Equations | StabilisedEquations, whole: Equations, first: int, last: int, *, multipliers: bool
    ) -> None:
        self.equations, self.whole, self.first, self.last, self.multipliers = equations, whole, first, last, multipliers
        self.magnitude = whole.magnitude[first:last]
        self.n_motion = min(max(whole.n_motion - first, 0), last - first)
        pattern = whole.matrix.pattern
        inside = (pattern.rows >= first) & (pattern.rows < last) & (pattern.indices >= first) & (pattern.indices < last)
        symmetric = pattern.symmetric or self._allows_symmetry()
        chosen = np.flatnonzero(inside & (pattern.indices >= pattern.rows) if symmetric else inside)
        rows, cols = pattern.rows[chosen], pattern.indices[chosen]
        self._entries = self._mirrored = chosen
        if symmetric and not pattern.symmetric:
            keys = pattern.rows * pattern.n + pattern.indices
            self._mirrored = np.searchsorted(keys, cols * pattern.n + rows)
        indptr = np.searchsorted(rows, np.arange(first, last + 1))
        j_indptr, j_indices = (pattern.j_indptr, pattern.j_indices) if multipliers else (np.zeros(1, int), np.zeros(0, int))
        self.pattern = Pattern(last - first, indptr, cols - first, symmetric, len(j_indptr) - 1, j_indptr, j_indices)

    def _allows_symmetry(self) -> bool:
        """Whether no tangent within this part needs an unsymmetric solver."""
        model, chosen = self.whole.model, self.whole.elimination.independent[self.first : self.last]
        fields = bool(chosen[0] >= model.n_motion)
        for block in (*model.forces, *model.loads):
            if block.symmetry == "none":
                rows, cols = (coords[block.k_rows >= 0] >= model.n_motion for coords in (block.k_rows, block.k_cols))
                if np.any((rows == fields) & (cols == fields)):
                    return False
        return True

    def begin(self, point: Point) -> Point:
        """Take what stays as it is from a whole point; gives the point of this part."""
        self._base, own = point, slice(self.first, self.last)
        lam = point.lam if self.multipliers else np.zeros(0)
        return replace(point, u=point.u[own], ud=point.ud[own], udd=point.udd[own], lam=lam)

    def completed(self, part: Point) -> Point:
        """A whole point from one of this part."""
        own, found = slice(self.first, self.last), self._base.copy()
        found.u[own], found.ud[own], found.udd[own] = part.u, part.ud, part.udd
        if self.multipliers:
            found.lam = part.lam
        return found

    def residual(self, point: Point) -> tuple[Floats, Floats]:
        """r of the part, and Phi when the multipliers belong to it."""
        r, phi = self.equations.residual(self.completed(point))
        return r[self.first : self.last], phi if self.multipliers else np.zeros(0)

    def linearise(self, point: Point, weights: Weights, previous: Floats | None = None) -> tuple[Floats, Floats, Floats, Floats]:
        """r, Phi and the values of the part's matrix and Jacobian; see :class:`lamella.assembly.equations.Equations`."""
        r, phi, k, j = self.equations.linearise(self.completed(point), weights, previous)
        own = 0.5 * (k[self._entries] + k[self._mirrored])
        if not self.multipliers:
            phi = j = np.zeros(0)
        return r[self.first : self.last], phi, own, j

    def coordinates(self, point: Point) -> Floats:
        """All coordinates q, shape (n_q,)."""
        return self.equations.coordinates(self.completed(point))

    def violation(self, point: Point) -> float:
        """Largest violation of a constraint; none where the multipliers do not belong to the part."""
        return self.equations.violation(self.completed(point)) if self.multipliers else 0.0

    def free(self, unknown: int) -> str:
        """An unknown of this part that nothing determines, in words."""
        n = self.last - self.first
        return self.equations.free(self.first + unknown if unknown < n else self.whole.n_u + unknown - n)


class StaggeredNewton:
    """Temperatures with the predicted motion, and then motion with the new temperatures, one pass each.

    It stands in the place of a :class:`NewtonSolver`. Where only the coupling makes the whole matrix unsymmetric, those of the
    passes are symmetric.

    Args:
        equations: the equations of the model, or their stabilised form.
        whole: the equations of the model, with both motion and fields.
        options: tolerances.
        statistics: counts the work of both passes.
        solver: linear solver.
    """

    def __init__(
        self,
        equations: Equations | StabilisedEquations,
        whole: Equations,
        options: Newton,
        statistics: Statistics,
        solver: Method,
    ) -> None:
        n = whole.n_motion
        heat = PartialEquations(whole, whole, n, whole.n_u, multipliers=False)
        motion = PartialEquations(equations, whole, 0, n, multipliers=True)
        self._heat, self._heat_newton = heat, NewtonSolver(heat, linear_solver(heat.pattern, solver), options, statistics)
        self._motion, vectors = motion, Vectors(whole)
        self._motion_newton = NewtonSolver(motion, linear_solver(motion.pattern, solver), options, statistics, vectors)
        self.linear = self._motion_newton.linear

    def forget(self) -> None:
        """Do not use the present factorisations again."""
        self._heat_newton.forget()
        self._motion_newton.forget()

    def solve(self, point: Point, weights: Weights, reference: Floats | None = None) -> NewtonReport:
        """Correct ``point`` in place; see :class:`NewtonSolver`."""
        warmed = _solved(self._heat, self._heat_newton, point, weights, reference)
        if not warmed.converged:
            return warmed
        moved = _solved(self._motion, self._motion_newton, point, weights, reference)
        return replace(moved, iterations=warmed.iterations + moved.iterations)


def _solved(
    part: PartialEquations, newton: NewtonSolver, point: Point, weights: Weights, reference: Floats | None
) -> NewtonReport:
    """Correct a part of ``point`` in place."""
    own = part.begin(point)
    report = newton.solve(own, weights, reference)
    found = part.completed(own)
    point.u, point.ud, point.udd, point.lam = found.u, found.ud, found.udd, found.lam
    return report
