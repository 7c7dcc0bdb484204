"""Newton's method for one set of equations, with the factorisation kept while it converges well."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import isfinite
from typing import Annotated, Literal, NamedTuple, Protocol

import numpy as np
from pydantic import Field

from lamella._jit import njit
from lamella.assembly.point import Point, Weights
from lamella.declaration import declaration
from lamella.errors import SingularSystemError
from lamella.result import Cause, Statistics
from lamella.roles import Floats
from lamella.solve.base import LinearSolver
from lamella.solve.broyden import BroydenCorrections
from lamella.solve.secant import SecantCorrections
from lamella.solve.turned import Vectors
from lamella.solve.turned_nodes import turned_solver
from lamella.units import Positive

ROUNDING = 1e-9
"""A correction of this size that does not shrink any more is rounding."""
PATIENCE = 24
"""Iterations within which a kept factorisation must promise to reach the tolerance."""
SMALLEST = 1e-14
"""Errors below this need no correction."""
GROWTH = 3.0
"""Growth of a correction that is borne with where there is patience: secants make up for it. At 1.5 it takes as long."""
HALVINGS = 5
"""Halvings of a correction in one line search."""


@declaration
class Newton:
    """How equations are solved.

    An iterate is accepted when the estimated error theta / (1 - theta) |du| is below ``tolerance`` times the change of the
    solution since the start of the iteration, with theta the observed contraction and |.| the largest entry relative to the size
    of the body (positions) or to 1 (slopes). It is a relative error of what a step adds, whatever the size of load or step.
    Beyond that, the constraints must hold at the iterate itself to ``constraint_tolerance`` of the size of the bodies.

    Args:
        tolerance: relative error accepted [-].
        constraint_tolerance: violation of a constraint accepted, relative to what a change of its coordinates by their
            magnitudes (size of the body, 1 for slopes) adds to it [-].
        max_iterations: iterations before giving up.
        keep: contraction up to which a factorisation is used again, 0 for Newton's method proper.
        line_search: halve corrections that lead too far. True: once they grow, one that the next would outgrow (natural
            monotonicity test), for plates that bend far. ``residual``: one that does not lessen the residual, each row by its
            stiffness, sum r_i^2 / K_ii, for contact with friction, where iterates go to and fro between stick and slip.
        extrapolate: take the stress of the geometric stiffness from the previous iterate's linear extrapolation
            (Magisano, Leonetti and Garcea 2017); fewer iterations, same result.
    """

    tolerance: Positive = 1e-8
    constraint_tolerance: Positive = 1e-11
    max_iterations: Annotated[int, Field(ge=1, le=1000)] = 25
    keep: Annotated[float, Field(ge=0.0, lt=1.0)] = 0.1
    line_search: bool | Literal["residual"] = False
    extrapolate: bool = True


class Residual(Protocol):
    """What Newton's method asks of equations r(u, lam) = 0, Phi(u) = 0; see ``lamella.assembly.equations`` for each."""

    magnitude: Floats
    n_motion: int

    def residual(self, point: Point) -> tuple[Floats, Floats]: ...
    def linearise(
        self, point: Point, weights: Weights, previous: Floats | None = None
    ) -> tuple[Floats, Floats, Floats, Floats]: ...
    def coordinates(self, point: Point) -> Floats: ...
    def violation(self, point: Point) -> float: ...
    def free(self, unknown: int) -> str: ...


@dataclass(frozen=True)
class NewtonReport:
    """How an iteration ended: its cause, the number of iterations, and the last correction's size."""

    cause: Cause
    iterations: int
    size: float
    detail: str = ""

    @property
    def converged(self) -> bool:
        """True when the solution was accepted."""
        return self.cause is Cause.COMPLETED


class Evaluation(NamedTuple):
    """Residual r and Phi at a point, and the values K and J of the matrix there if it was asked for."""

    r: Floats
    phi: Floats
    matrix: tuple[Floats, Floats] | None


class NewtonSolver:
    """Solves r(u, lam) = 0, Phi(u) = 0 by corrections of a :class:`Point`.

    Args:
        equations: residual and matrix.
        linear: solver of the linear systems.
        options: tolerances.
        statistics: counts the work.
        vectors: where the coordinate vectors of the equations stand, so that a kept factorisation turns with the structure.

    Attributes:
        patience: slow iterations in a row that are borne with before a factorisation is given up.
    """

    def __init__(
        self, equations: Residual, linear: LinearSolver, options: Newton, statistics: Statistics, vectors: Vectors | None = None
    ) -> None:
        self.equations, self.options, self.statistics = equations, options, statistics
        self._turned = vectors and turned_solver(linear, vectors)
        self.linear = linear = self._turned or linear
        self._factored_for: Weights | None = None
        self._age, self._short_lived = 0, False
        self.patience, self._slow = 0, 0
        self._per_magnitude = 1.0 / equations.magnitude
        if linear.pattern.symmetric:
            self._corrections: SecantCorrections | BroydenCorrections = SecantCorrections(linear)
        else:
            self._corrections = BroydenCorrections(linear, self._per_magnitude)
        self._per_stiffness = np.zeros(0)

    def size(self, du: Floats) -> float:
        """Largest correction relative to the magnitude of its coordinate."""
        return float(np.max(np.abs(du * self._per_magnitude), initial=0.0))

    def forget(self) -> None:
        """Go on as a new solver: without the present factorisation, and without what earlier ones have told."""
        self._factored_for, self._short_lived = None, False

    def _drop(self) -> None:
        self._factored_for = None

    def solve(self, point: Point, weights: Weights, reference: Floats | None = None, *, held: bool = False) -> NewtonReport:
        """Correct ``point`` in place until it solves the equations.

        Args:
            point: the predicted point; changed in place, meaningless when not converged.
            weights: how the unknown moves q, v and a.
            reference: coordinates q of the last solution, from which stress is extrapolated at the first iteration.
            held: whether ``linear`` holds the factorisation of the matrix at ``point`` already.
        """
        before, start, known, n = None, point.u, None, self.equations.n_motion
        last = size = np.inf
        self._corrections.forget()
        self._age += 1
        self._slow = 0
        held = held and self.options.line_search != "residual"  # which asks for the diagonal of the matrix as well
        self.turn_to(point, weights)
        iteration, renewed = 0, False
        for iteration in range(self.options.max_iterations):
            fresh = held or self._factored_for != weights
            try:
                if known is None or (fresh and known.matrix is None):
                    known = self._evaluate(point, weights, reference, before, fresh=fresh and not held)
                r, phi, matrix = known
                if not isfinite(r.dot(r)):
                    return NewtonReport(Cause.NOT_FINITE, iteration, last, "the residual is not finite")
                if matrix is not None:
                    self._factorise(matrix, point, weights)
                elif held:
                    self._made(point, weights)
                du, dlam = self._corrections(r, phi)
            except SingularSystemError as error:
                self._drop()
                return NewtonReport(Cause.SINGULAR, iteration, last, self._free(error))
            self.statistics.solves += 1
            moved = u, ud, udd = np.empty_like(point.u), np.empty_like(point.u), np.empty_like(point.u)
            size, change = _corrected(point.u, point.ud, point.udd, du, start, self._per_magnitude, n, *weights, *moved)
            if not isfinite(size):
                self._drop()
                return NewtonReport(Cause.NOT_FINITE, iteration, last, "the correction is not finite")
            contraction = size / last if isfinite(last) else 0.5
            goal = max(self.options.tolerance * change, SMALLEST)
            promising, small = self._promising(size, contraction, goal), self._small_enough(size, contraction, goal)
            if renewed:
                self._short_lived = not small  # else the one before would have done as well
            elif not fresh and isfinite(last) and not promising:
                self._short_lived |= self._age == 1
                self._drop()  # a kept factorisation that converges slowly: evaluate the matrix here instead
                last = np.inf
                continue
            before = point.u
            # Of contact a tangent costs as much as several iterations: it is tried once more before it is given up. A plate far
            # from its solution diverges on it.
            untried = self.options.line_search == "residual" and self.options.keep > 0.0 and (renewed or not isfinite(last))
            step, known, renewed = 1.0, None, False
            if self.options.line_search == "residual" and not small:
                renewed = self._short_lived and not fresh and iteration == 0
                whole = replace(point, u=u, ud=ud, udd=udd, lam=point.lam + dlam)
                step, known = self._descending(point, weights, r, du, dlam, whole, renewed=renewed)
            elif self.options.line_search is True and contraction >= 1.0:
                step = self._searched(point, weights, du, dlam)
            if step == 1.0:
                point.u, point.ud, point.udd = moved
                if len(dlam):
                    point.lam = point.lam + dlam
            else:
                self._move(point, weights, step * du, step * dlam)
            self.statistics.newton_iterations += 1
            if step != 1.0:
                self._corrections.forget()
            if step == 1.0 and small and self._holds(point, size):
                return NewtonReport(Cause.COMPLETED, iteration + 1, size)
            if size > 1e6:
                break
            if renewed or (fresh and not untried and not promising):
                self._drop()
            last, held = size, False
        self._drop()
        return NewtonReport(Cause.NOT_CONVERGED, iteration + 1, size, f"correction {size:.1e} after {iteration + 1} iterations")

    def _promising(self, size: float, contraction: float, goal: float) -> bool:
        """Whether the present factorisation contracts well enough to end the iteration soon, or is given time."""
        well = contraction <= self.options.keep and size * contraction**PATIENCE <= goal
        self._slow = 0 if well else self._slow + 1
        return well or (self._slow <= self.patience and contraction < GROWTH)

    def _small_enough(self, size: float, contraction: float, goal: float) -> bool:
        """Whether the estimated error is within the tolerance, or the correction is rounding, which shrinks no further."""
        if contraction >= 1.0:
            return size < ROUNDING
        return size * contraction / (1.0 - contraction) <= goal

    def _holds(self, point: Point, size: float) -> bool:
        """Whether the constraints hold at ``point``, or the correction is too small to improve on that."""
        return size < SMALLEST or self.equations.violation(point) <= self.options.constraint_tolerance

    def _evaluate(
        self, point: Point, weights: Weights, reference: Floats | None, before: Floats | None, *, fresh: bool
    ) -> Evaluation:
        """Residual, and the matrix if ``fresh``; ``before`` are the independent coordinates of the last iterate."""
        self.statistics.residuals += 1
        if not fresh:
            return Evaluation(*self.equations.residual(point), None)
        previous = None
        if self.options.extrapolate:
            previous = reference if before is None else self.equations.coordinates(point.moved_to(before))
        r, phi, k, j = self.equations.linearise(point, weights, previous)
        self.statistics.tangents += 1
        return Evaluation(r, phi, (k, j))

    def _factorise(self, matrix: tuple[Floats, Floats], point: Point, weights: Weights) -> None:
        self.linear.factorise(*matrix)
        self.statistics.factorisations += 1
        self.adopt(matrix[0], point, weights)

    def adopt(self, k: Floats, point: Point, weights: Weights) -> None:
        """Go on with the factorisation of the matrix with the values ``k`` at ``point`` that ``linear`` holds now."""
        self._corrections.forget()
        if self.options.line_search == "residual":
            diagonal = self.linear.pattern.diagonal(k)
            self._per_stiffness = 1.0 / np.maximum(np.abs(diagonal), np.finfo(float).tiny)
        self._made(point, weights)

    def _made(self, point: Point, weights: Weights) -> None:
        self._factored_for, self._age = weights, 0
        if self._turned:
            self._turned.made_at(point.u)

    def turn_to(self, point: Point, weights: Weights) -> bool:
        """Whether ``linear`` holds a factorisation for these weights that contracts well; it is turned to ``point`` then."""
        held = self._factored_for == weights
        if held and self._turned:
            self._turned.turn(point.u)
        return held

    def _free(self, error: SingularSystemError) -> str:
        return str(error) if error.index is None else self.equations.free(error.index)

    def _move(self, point: Point, weights: Weights, du: Floats, dlam: Floats) -> None:
        moved = np.empty_like(du), np.empty_like(du), np.empty_like(du)
        n = self.equations.n_motion
        _corrected(point.u, point.ud, point.udd, du, point.u, self._per_magnitude, n, *weights, *moved)
        point.u, point.ud, point.udd = moved
        point.lam = point.lam + dlam

    def _descending(
        self, point: Point, weights: Weights, r: Floats, du: Floats, dlam: Floats, trial: Point, *, renewed: bool
    ) -> tuple[float, Evaluation | None]:
        """A step length s that lessens the sum of r_i^2 / K_ii by a tenth of s, or the shortest one; and the residual there,
        at the whole step, ``trial``, with the matrix if that is to be ``renewed``.
        """
        now, step = float(r**2 @ self._per_stiffness), 1.0
        for _ in range(HALVINGS):
            if step < 1.0:
                trial = point.copy()
                self._move(trial, weights, step * du, step * dlam)
            reached = self._evaluate(trial, weights, None, point.u, fresh=renewed and step == 1.0)
            if float(reached.r**2 @ self._per_stiffness) <= (1.0 - 0.1 * step) * now:
                return step, reached
            step *= 0.5
        return step, None

    def _searched(self, point: Point, weights: Weights, du: Floats, dlam: Floats) -> float:
        """A step length s that passes the natural monotonicity test (Deuflhard 2004, section 3.3).

        The correction that the same factorisation gives at the trial point must be smaller than ``du``. The residual itself is
        a poor judge: the membrane stress of a thin plate grows with the square of a rotation, so its residual rises by orders of
        magnitude along a step that leads straight to the solution.
        """
        step, allowed = 1.0, self.size(du)
        for _ in range(HALVINGS):
            trial = point.copy()
            self._move(trial, weights, step * du, step * dlam)
            r, phi = self.equations.residual(trial)
            self.statistics.residuals += 1
            if np.isfinite(r).all():
                next_du, _ = self.linear.solve(-r, -phi)
                self.statistics.solves += 1
                if self.size(next_du) <= (1.0 - 0.25 * step) * allowed:
                    break
            step *= 0.5
        return step


@njit
def _corrected(
    u: Floats, ud: Floats, udd: Floats, du: Floats, start: Floats, per_magnitude: Floats,
    n: int, alpha_q: float, alpha_v: float, alpha_a: float, rate: float,
    q: Floats, v: Floats, a: Floats,
) -> tuple[float, float]:  # fmt: skip
    """Coordinates q, velocities v and accelerations a after a correction du, of which ``n`` are of motion, the others of fields.

    Returns:
        Largest entry of the correction, not a number when one is none, and of the change q - start, relative to the magnitudes.
    """
    size = change = 0.0
    for i in range(len(u)):
        weight = alpha_v if i < n else rate
        q[i], v[i], a[i] = u[i] + alpha_q * du[i], ud[i] + weight * du[i], udd[i] + alpha_a * du[i] if i < n else 0.0
        one = abs(du[i] * per_magnitude[i])
        if not one <= size:
            size = one
            if one != one:
                break
        change = max(change, abs((q[i] - start[i]) * per_magnitude[i]))
    return size, change
