"""The contract of an integrator."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np

from lamella.assembly.equations import Equations
from lamella.assembly.point import Point
from lamella.memory import Memory
from lamella.result import Statistics
from lamella.solve.linear import Method
from lamella.solve.newton import NewtonReport

SAFETY = 0.9
"""Share of the step that the error estimate would allow."""
GROWTH = (0.2, 2.0)
"""Smallest and largest change of the step from one to the next."""


@dataclass(frozen=True)
class StepOutcome:
    """What a step gives.

    Args:
        report: how Newton's iteration ended.
        point: the new point, None when not converged.
        error: estimated local error relative to the tolerance (at most 1 is good), 0.0 when it was not asked for.
        growth: change of the step that the error allows: for the next one, or for another try of one with an error above 1.
            Without an error estimate it tells how fast a step that was cut grows back.
    """

    report: NewtonReport
    point: Point | None
    error: float = 0.0
    growth: float = GROWTH[1]


def allowed_growth(error: float, order: int) -> float:
    """Change of the step that brings a local error of order dt^(order + 1), relative to the tolerance, just below 1."""
    wanted = SAFETY * max(error, 1e-10) ** (-1.0 / (order + 1))
    return float(np.clip(wanted, *GROWTH))


class Stepper(Memory, ABC):
    """An integrator at work on one set of equations.

    1. ``restart`` forgets the past: the point given has consistent accelerations and multipliers.
    2. ``jump`` goes on from the last point after its accelerations, rates of fields and multipliers have jumped.
    3. ``step`` tries to go from the last accepted point to t + dt; it changes nothing but what ``accept`` needs, so that a
       rejected step may be tried again with another dt.
    4. ``accept`` makes the last converged step final.
    5. ``between`` interpolates within the last accepted step.
    6. What it remembers (:class:`lamella.memory.Memory`) and the state of the model are all that the next step depends on, once
       ``forget`` has dropped what only saves time, a factorisation.
    """

    statistics: Statistics

    @abstractmethod
    def restart(self, point: Point) -> None:
        """Start from a consistent point."""

    def jump(self, point: Point) -> bool:
        """Go on from the last point with what an input has added to its accelerations, rates of fields and multipliers.

        Returns:
            Whether this was a restart, the only way for a method that goes by past points.
        """
        self.restart(point)
        return True

    def first_step(self, dt: float) -> float:
        """The step to begin with after a restart [s], where dt is the one meant for the long run."""
        return dt

    @abstractmethod
    def step(self, dt: float) -> StepOutcome:
        """Try a step of dt [s]."""

    @abstractmethod
    def accept(self) -> Point:
        """Make the last converged step final and return its point."""

    @abstractmethod
    def forget(self) -> None:
        """Drop what only saves time."""

    @abstractmethod
    def between(self, t: float) -> Point:
        """The point at a time within the last accepted step, by interpolation with the order of the method."""


class Integrator(ABC):
    """A frozen description of an integrator; ``stepper`` puts it to work.

    ``dt`` [s] is the step (its first value under error control) and ``dt_min`` the smallest a rejected step is cut to;
    ``tolerance`` is the relative local error allowed in a step, None for fixed steps.
    """

    dt: float
    dt_min: float
    dt_max: float
    tolerance: float | None

    @abstractmethod
    def stepper(self, equations: Equations, statistics: Statistics, solver: Method) -> Stepper:
        """A stepper for these equations with the linear solver of the given name."""
