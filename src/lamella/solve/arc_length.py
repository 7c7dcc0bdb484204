"""Arc length: equilibrium paths through limit points."""

from __future__ import annotations

from typing import Annotated

import numpy as np
from pydantic import Field

from lamella.assembly.point import Point
from lamella.declaration import declaration
from lamella.errors import SingularSystemError
from lamella.result import Cause, Outcome
from lamella.roles import Floats
from lamella.solve.bordered import Between, BorderedNewton, Record
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
        self, newton: BorderedNewton, point: Point, until: float, record: Record, *, leaving: Point | None = None
    ) -> Outcome:
        """Follow the path from an equilibrium until the load factor passes ``until``, which is then met exactly.

        Args:
            newton: solves the equations of a step.
            point: an equilibrium.
            until: load factor of the end; below that of ``point`` the load falls at first.
            record: receives every new equilibrium; a step to another path is repeated with half its length.
            leaving: the point of the path before ``point``, which decides the sense at the start.
        """
        path = _Path(self, newton, upwards=until >= (point if leaving is None else leaving).factor)
        if leaving is not None:
            path.remember(leaving, point)
        radius = start = np.nan
        for _ in range(self.max_steps):
            try:
                direction, _lam = newton.tangent(point)
            except SingularSystemError as error:
                return Outcome(Cause.SINGULAR, point.factor, until, str(error))
            if np.isnan(radius):
                radius = start = min(self.first * path.length(direction, 1.0), self.largest)
                if leaving is not None:
                    radius = start = min(self.largest, 2.0 * path.length(point.u - leaving.u, point.factor - leaving.factor))
            while True:
                iterations, new = path.step(point, direction, radius)
                if new is not None and (path.beyond(new.factor, until) or new.factor == until):
                    end = self._finish(path, point, direction, (radius, new), until, record)
                    if end is not None:
                        newton.statistics.steps += 1
                        return end
                elif new is not None and record(new, path.between(point, direction, radius)):
                    break
                newton.statistics.rejected += 1
                radius *= 0.5
                if radius < self.smallest * start:
                    return Outcome(Cause.NOT_CONVERGED, point.factor, until, self._given_up(radius, start))
            newton.statistics.steps += 1
            path.remember(point, new)
            point = new
            radius = min(radius * float(np.clip((self.wanted / iterations) ** 0.5, 0.5, 2.0)), self.largest)
        detail = f"{self.max_steps} steps; raise max_steps of the arc length, or largest, {self.largest:g}, for longer steps"
        return Outcome(Cause.STEP_LIMIT, point.factor, until, detail)

    def _given_up(self, radius: float, start: float) -> str:
        return (
            f"the arc length cannot go on: its step fell to {radius:.1e}, below {self.smallest:g} of the first, {start:.1e}; "
            "the points up to here are kept. Where the path bends sharply an imperfection rounds the corner; "
            "a smaller first or smallest step may pass it"
        )

    def _finish(
        self,
        path: _Path,
        point: Point,
        direction: Floats,
        beyond: tuple[float, Point],
        until: float,
        record: Record,
    ) -> Outcome | None:
        """Land on the load factor asked for, between the last two points; None where that lies on another path.

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
            if path.beyond(trial.factor, until):
                far, new = radius, trial
            else:
                near, nearest = radius, trial
            if abs(trial.factor - until) <= NEARLY * abs(beyond[1].factor - point.factor):
                nearest = trial
                break
        none = np.zeros(len(nearest.u))
        predicted, most = nearest.copy(), path.newton.newton.options.max_iterations
        iterations, last = path.newton.solve(predicted, nearest, lambda at: (at.factor - until, none, 1.0), most)
        if last is None or path.length(last.u - nearest.u, 0.0) > beyond[0]:
            if not record(beyond[1], path.between(point, direction, beyond[0])):
                return None
            detail = f"the path was passed beyond its end, where Newton's method found nothing in {iterations} iterations"
            return Outcome(Cause.NOT_CONVERGED, beyond[1].factor, until, detail)
        last.factor = until
        if not record(last, path.between(point, direction, path.length(last.u - point.u, last.factor - point.factor))):
            return None
        return Outcome(Cause.COMPLETED, until, until)


class _Path:
    """Steps along one path: their sense, the arc of a step, and what counts as the same path."""

    def __init__(self, options: ArcLength, newton: BorderedNewton, *, upwards: bool) -> None:
        self.options, self.newton, self.metric = options, newton, newton.metric
        self._sense = 1.0 if upwards else -1.0
        self._last: tuple[Floats, float] | None = None

    def beyond(self, factor: float, until: float) -> bool:
        """Whether a load factor lies beyond the one at the end of the path."""
        return self._sense * (factor - until) > 0.0

    def length(self, du: Floats, dfactor: float) -> float:
        """Arc length of an increment."""
        return float(np.sqrt(self.metric @ du**2 + (self.options.psi * dfactor) ** 2))

    def remember(self, old: Point, new: Point) -> None:
        """Keep the last increment, which decides the sense of the next."""
        self._last = new.u - old.u, new.factor - old.factor

    def between(self, point: Point, direction: Floats, radius: float) -> Between:
        """Points of the step, by their share of its length; the sense is the one the step had."""
        last = self._last

        def at(share: float) -> Point | None:
            kept, self._last = self._last, last
            try:
                return self.step(point, direction, share * radius)[1]
            finally:
                self._last = kept

        return at

    def step(self, point: Point, direction: Floats, radius: float) -> tuple[int, Point | None]:
        """One step of the given arc length; (iterations, None) when it does not converge."""
        dfactor = radius / self.length(direction, 1.0)
        if self._last is not None:
            du, df = self._last
            dfactor *= float(np.sign(self.metric @ (du * direction) + self.options.psi**2 * df)) or 1.0
        else:
            dfactor *= self._sense
        new = point.copy()
        new.u, new.factor = point.u + dfactor * direction, point.factor + dfactor

        def condition(at: Point) -> tuple[float, Floats, float]:
            moved, risen = at.u - point.u, at.factor - point.factor
            gap = self.length(moved, risen) ** 2 - radius**2
            return gap, 2.0 * self.metric * moved, 2.0 * self.options.psi**2 * risen

        iterations, new = self.newton.solve(new, point, condition, 2 * self.options.wanted)
        return iterations, new if new is not None and self._turns_gently(new.u - point.u, dfactor * direction) else None

    def _turns_gently(self, moved: Floats, predicted: Floats) -> bool:
        """Whether a step keeps within 60 degrees of the tangent; a sharper turn is another branch, or a path cut short."""
        return float(self.metric @ (moved * predicted)) >= 0.5 * self.length(moved, 0.0) * self.length(predicted, 0.0)
