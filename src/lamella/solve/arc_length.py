"""Arc length: equilibrium paths through limit points."""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated

import numpy as np
from pydantic import Field

from lamella.assembly.equations import Equations
from lamella.assembly.point import STATIC, Point
from lamella.declaration import declaration
from lamella.errors import SingularSystemError
from lamella.result import Cause, Outcome, Statistics
from lamella.roles import Floats
from lamella.solve.newton import NewtonSolver
from lamella.units import Positive

LANDINGS = 30
"""Steps of regula falsi towards the last load factor."""
NEARLY = 1e-3
"""Share of the last step's change of load within which the load factor is held."""


@declaration
class ArcLength:
    """Spherical arc length (Riks 1979; Crisfield 1981) with consistent linearisation.

    Equilibrium r(u, factor) = 0 is solved together with g = |du|^2 + psi^2 dfactor^2 - s^2 = 0, du and dfactor counted from
    the last point, |du|^2 = sum (du_i / magnitude_i)^2 / n. The step s follows the number of iterations (Ramm 1981).

    Args:
        first: load factor of the first step.
        psi: weight of the load factor, 0 for a cylinder that only sees displacements.
        wanted: iterations aimed at; fewer lengthen the step, and one that needs twice as many is halved: an iteration that
            wanders may end on another branch.
        largest: largest step: root mean square change of positions relative to the size of the body and of slopes.
        smallest: smallest step relative to the first, below which the path is given up.
        max_steps: number of steps after which the path ends.
    """

    first: Positive = 0.05
    psi: Annotated[float, Field(ge=0.0)] = 0.0
    wanted: Annotated[int, Field(ge=2)] = 6
    largest: Positive = 0.05
    smallest: Positive = 1e-4
    max_steps: Annotated[int, Field(ge=1)] = 500

    def follow(
        self,
        equations: Equations,
        newton: NewtonSolver,
        point: Point,
        until: float,
        record: Callable[[Point], None],
        statistics: Statistics,
    ) -> Outcome:
        """Follow the path from an equilibrium until the load factor passes ``until``, which is then met exactly.

        Args:
            equations: residual and matrix.
            newton: linear solver, norms and tolerance.
            point: an equilibrium.
            until: load factor of the end.
            record: receives every new equilibrium.
            statistics: counts the work.
        """
        path = _Path(self, equations, newton, statistics)
        radius = start = np.nan
        for _ in range(self.max_steps):
            try:
                direction = path.tangent(point)
            except SingularSystemError as error:
                return Outcome(Cause.SINGULAR, point.factor, until, str(error))
            if np.isnan(radius):
                radius = start = min(self.first * path.length(direction, 1.0), self.largest)
            iterations, new = 0, None
            while new is None:
                iterations, new = path.step(point, direction, radius)
                if new is None:
                    statistics.rejected += 1
                    radius *= 0.5
                    if radius < self.smallest * start:
                        return Outcome(Cause.NOT_CONVERGED, point.factor, until, f"arc length {radius:.1e}")
            statistics.steps += 1
            if new.factor >= until:
                return self._finish(path, newton, point, direction, (radius, new), until, record)
            path.remember(point, new)
            point = new
            record(point)
            radius = min(radius * float(np.clip((self.wanted / iterations) ** 0.5, 0.5, 2.0)), self.largest)
        return Outcome(Cause.STEP_LIMIT, point.factor, until, f"{self.max_steps} steps")

    def _finish(
        self,
        path: _Path,
        newton: NewtonSolver,
        point: Point,
        direction: Floats,
        beyond: tuple[float, Point],
        until: float,
        record: Callable[[Point], None],
    ) -> Outcome:
        """Land on the load factor asked for, between the last two points.

        The arc length is shortened by regula falsi until the load factor nearly fits, and only then held: from afar, Newton's
        iteration at a fixed load may fall onto another branch.
        """
        (far, new), near, nearest = beyond, 0.0, point
        for _ in range(LANDINGS):
            share = np.clip((until - nearest.factor) / (new.factor - nearest.factor), 0.05, 0.95)
            radius = near + float(share) * (far - near)
            trial = path.step(point, direction, radius)[1]
            if trial is None:
                break
            if trial.factor < until:
                near, nearest = radius, trial
            else:
                far, new = radius, trial
            if abs(trial.factor - until) <= NEARLY * abs(beyond[1].factor - point.factor):
                nearest = trial
                break
        last = nearest.copy()
        last.factor = until
        newton.forget()
        report = newton.solve(last, STATIC, path.equations.coordinates(nearest))
        if not report.converged or path.length(last.u - nearest.u, 0.0) > beyond[0]:
            record(beyond[1])
            return Outcome(Cause.NOT_CONVERGED, beyond[1].factor, until, f"the path was passed beyond its end; {report.detail}")
        record(last)
        return Outcome(Cause.COMPLETED, until, until)


class _Path:
    """One path: tangent direction and corrected steps."""

    def __init__(self, options: ArcLength, equations: Equations, newton: NewtonSolver, statistics: Statistics) -> None:
        self.options, self.equations, self.newton, self.statistics = options, equations, newton, statistics
        self.metric = 1.0 / (equations.magnitude**2 * equations.n_u)
        self._last: tuple[Floats, float] | None = None

    def length(self, du: Floats, dfactor: float) -> float:
        """Arc length of an increment."""
        return float(np.sqrt(self.metric @ du**2 + (self.options.psi * dfactor) ** 2))

    def remember(self, old: Point, new: Point) -> None:
        """Keep the last increment, which decides the sense of the next."""
        self._last = new.u - old.u, new.factor - old.factor

    def tangent(self, point: Point) -> Floats:
        """du/dfactor along the path at an equilibrium."""
        self._linearise(point, point)
        return self._solve(-self.equations.load_direction(point))[0]

    def step(self, point: Point, direction: Floats, radius: float) -> tuple[int, Point | None]:
        """One step of the given arc length; (iterations, None) when it does not converge."""
        dfactor = radius / self.length(direction, 1.0)
        if self._last is not None:
            du, df = self._last
            dfactor *= float(np.sign(self.metric @ (du * direction) + self.options.psi**2 * df)) or 1.0
        new = point.copy()
        new.u, new.factor = point.u + dfactor * direction, point.factor + dfactor
        before, last, iteration = point, np.inf, 0
        for iteration in range(1, min(self.newton.options.max_iterations, 2 * self.options.wanted) + 1):
            try:
                r, phi = self._linearise(new, before)
                if not np.isfinite(r).all():
                    return iteration, None
                du_r, dlam_r = self._solve(-r, -phi)
                du_f, dlam_f = self._solve(-self.equations.load_direction(new))
            except SingularSystemError:
                return iteration, None
            moved, risen = new.u - point.u, new.factor - point.factor
            gap = self.length(moved, risen) ** 2 - radius**2
            slope = 2.0 * float(self.metric @ (moved * du_f) + self.options.psi**2 * risen)
            df = -float(gap + 2.0 * self.metric @ (moved * du_r)) / slope
            du = du_r + df * du_f
            size = self.newton.size(du)
            before = new.copy()
            new.u, new.lam, new.factor = new.u + du, new.lam + dlam_r + df * dlam_f, new.factor + df
            self.statistics.newton_iterations += 1
            contraction = size / last if np.isfinite(last) else 0.5
            if not np.isfinite(size) or size > 1e6:
                return iteration, None
            if contraction < 1 and size * contraction / (1 - contraction) <= self.newton.options.tolerance:
                return iteration, new if self._turns_gently(new.u - point.u, dfactor * direction) else None
            last = size
        return iteration, None

    def _turns_gently(self, moved: Floats, predicted: Floats) -> bool:
        """Whether a step keeps within 60 degrees of the tangent; a sharper turn is another branch, or a path cut short."""
        return float(self.metric @ (moved * predicted)) >= 0.5 * self.length(moved, 0.0) * self.length(predicted, 0.0)

    def _linearise(self, point: Point, before: Point) -> tuple[Floats, Floats]:
        previous = self.equations.coordinates(before) if self.newton.options.extrapolate else None
        r, phi, k, j = self.equations.linearise(point, STATIC, previous)
        self.newton.linear.factorise(k, j)
        self.newton.forget()
        self.statistics.tangents += 1
        self.statistics.factorisations += 1
        return r, phi

    def _solve(self, r: Floats, s: Floats | None = None) -> tuple[Floats, Floats]:
        self.statistics.solves += 1
        return self.newton.linear.solve(r, np.zeros(self.equations.n_lam) if s is None else s)
