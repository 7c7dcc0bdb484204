"""The contract of an integrator."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass

from lamella.assembly.equations import Equations
from lamella.assembly.point import Point
from lamella.result import Statistics
from lamella.solve.linear import Method
from lamella.solve.newton import NewtonReport


@dataclass(frozen=True)
class StepOutcome:
    """What a step gives.

    Args:
        report: how Newton's iteration ended.
        point: the new point, None when not converged.
        error: estimated local error relative to the tolerance (at most 1 is good), 0.0 when it was not asked for.
    """

    report: NewtonReport
    point: Point | None
    error: float = 0.0


class Stepper(ABC):
    """An integrator at work on one set of equations.

    1. ``restart`` forgets the past: the point given has consistent accelerations and multipliers.
    2. ``step`` tries to go from the last accepted point to t + dt; it changes nothing but what ``accept`` needs, so that a
       rejected step may be tried again with another dt.
    3. ``accept`` makes the last converged step final.
    """

    statistics: Statistics

    @abstractmethod
    def restart(self, point: Point) -> None:
        """Start from a consistent point."""

    @abstractmethod
    def step(self, dt: float) -> StepOutcome:
        """Try a step of dt [s]."""

    @abstractmethod
    def accept(self) -> Point:
        """Make the last converged step final and return its point."""


class Integrator(ABC):
    """A frozen description of an integrator; ``stepper`` puts it to work.

    ``dt`` [s] is the step (its first value under error control) and ``dt_min`` the smallest a rejected step is cut to;
    ``tolerance`` is the relative local error allowed in a step, None for fixed steps.
    """

    dt: float
    dt_min: float
    dt_max: float
    tolerance: float | None
    order: int

    @abstractmethod
    def stepper(self, equations: Equations, statistics: Statistics, solver: Method) -> Stepper:
        """A stepper for these equations with the linear solver of the given name."""
