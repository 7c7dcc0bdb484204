"""Displacement control: equilibrium paths by a stated displacement of one point."""

from __future__ import annotations

from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field

from lamella.assembly.equations import Equations
from lamella.assembly.point import Point
from lamella.body.base import Marker
from lamella.body.ground import Ground
from lamella.declaration import declaration
from lamella.errors import DeclarationError, SingularSystemError
from lamella.kinematics import VectorRows
from lamella.result import Cause, Outcome
from lamella.roles import Floats
from lamella.solve.bordered import Between, BorderedNewton, Record
from lamella.units import Length

ITERATIONS = 15
"""Newton's iterations allowed in a step; one that needs more is halved."""
EASY = 6
"""Iterations of a step up to which the next may be longer."""


@declaration
class DisplacementControl:
    """A component of a marker's displacement is stated, and the load factor that holds it is found.

    It passes limit points of the load. Where the displacement itself turns back (snap-back) it ends with an error: the arc
    length passes those.

    Args:
        marker: the point.
        axis: component of its displacement in the inertial frame.
        to: displacement at the end of the path, counted from the point where it begins [m].
        steps: number of equal steps; those that do not converge are halved.
        smallest: smallest step as a share of the way, below which the path is given up.
    """

    marker: Marker
    axis: Literal["x", "y", "z"]
    to: Length
    steps: Annotated[int, Field(ge=1)] = 20
    smallest: Annotated[float, Field(gt=0, lt=1)] = 1e-5

    def __post_init__(self) -> None:
        if self.to == 0.0 or not np.isfinite(self.to):
            raise DeclarationError("DisplacementControl", f"to = {self.to:g} m", "accepted is a displacement other than 0")
        if isinstance(self.marker.body, Ground):
            raise DeclarationError(
                "DisplacementControl", f"'{self.marker}' is fixed", "accepted is a marker of a body that moves"
            )

    def follow(self, newton: BorderedNewton, point: Point, record: Record) -> Outcome:
        """Follow the path from an equilibrium until the displacement is ``to``.

        Args:
            newton: solves the equations of a step.
            point: an equilibrium.
            record: receives every new equilibrium.
        """
        controlled = _Component(self, newton)
        start, done, largest = controlled.value(point), 0.0, 1.0 / self.steps
        while done < 1.0:
            share = min(largest, 1.0 - done)
            share = 1.0 - done if share >= 0.999 * (1.0 - done) else share
            try:
                direction, dlam = newton.tangent(point)
            except SingularSystemError as error:
                return Outcome(Cause.SINGULAR, point.factor, np.nan, str(error))
            target = start + (done + share) * self.to
            iterations, new = controlled.step(point, direction, dlam, target)
            if new is None:
                newton.statistics.rejected += 1
                largest = 0.5 * share
                if largest < self.smallest:
                    return Outcome(Cause.NOT_CONVERGED, point.factor, np.nan, self._given_up(controlled.value(point) - start))
                continue
            newton.statistics.steps += 1
            record(new, controlled.between(point, direction, dlam, target))
            point, done = new, done + share
            largest = min(2.0 * largest, 1.0 / self.steps) if iterations <= EASY else largest
        return Outcome(Cause.COMPLETED, point.factor, point.factor)

    def _given_up(self, reached: float) -> str:
        return (
            f"displacement {reached:.6g} m of {self.to:g} m along {self.axis} at '{self.marker}': it cannot grow from here. "
            "Where the path turns back (snap-back) follow it by the arc length instead: equilibrium_path without control"
        )


class _Component:
    """The controlled component as a function of the unknowns: c . u + c_f factor + constant."""

    def __init__(self, control: DisplacementControl, newton: BorderedNewton) -> None:
        equations, self.control, self.newton = newton.equations, control, newton
        model = equations.model
        compiled: dict[str, Any] = {body.name: body for body in (*model.plates, *model.rigid_bodies)}
        name = control.marker.body.name
        if name not in compiled:
            raise DeclarationError(
                "DisplacementControl",
                f"'{control.marker}' is on no body of the system",
                f"accepted is one on {', '.join(compiled)}",
            )
        rows: VectorRows = compiled[name].locate(control.marker.at).point
        self._row = np.zeros(model.n_q)
        self._row[3 * rows.vectors + "xyz".index(control.axis)] = rows.weights
        self._c = equations.elimination.T.T @ self._row
        if not np.any(np.abs(self._c) > 0.0):
            raise DeclarationError(
                "DisplacementControl",
                f"the supports hold {control.axis} of '{control.marker}'",
                "accepted is a component that is free",
            )

    def value(self, point: Point) -> float:
        """The component of the position, less the part that is constant [m]."""
        return float(self._row @ self.newton.equations.coordinates(point))

    def step(self, point: Point, direction: Floats, dlam: Floats, target: float) -> tuple[int, Point | None]:
        """The equilibrium at which the component is ``target``, predicted along the tangent."""
        by_factor = _by_factor(self.newton.equations, self._row, point)
        rate = float(self._c @ direction) + by_factor
        if rate == 0.0:
            return 0, None
        df = (target - self.value(point)) / rate
        new = point.copy()
        new.u, new.lam, new.factor = point.u + df * direction, point.lam + df * dlam, point.factor + df
        return self.newton.solve(new, point, lambda at: (self.value(at) - target, self._c, by_factor), ITERATIONS)

    def between(self, point: Point, direction: Floats, dlam: Floats, target: float) -> Between:
        """Points of a step by their share of its displacement."""
        first = self.value(point)
        return lambda share: self.step(point, direction, dlam, first + share * (target - first))[1]


def _by_factor(equations: Equations, row: Floats, point: Point) -> float:
    """Change of the component by the load factor alone: supports move in proportion to it."""
    ahead = point.copy()
    ahead.factor += 1.0
    return float(row @ (equations.coordinates(ahead) - equations.coordinates(point)))
