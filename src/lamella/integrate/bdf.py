"""Backward differentiation formulas of variable order and step for constrained systems."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Any, Literal

import numpy as np
from pydantic import Field

from lamella.assembly.equations import Equations
from lamella.assembly.point import Point, Weights
from lamella.declaration import declaration
from lamella.integrate.base import Integrator, StepOutcome, Stepper
from lamella.integrate.change import ChangeSize, refuse_folding
from lamella.integrate.differences import Differences, next_order, polynomial_weights
from lamella.integrate.stabilised import StabilisedEquations
from lamella.result import Statistics
from lamella.roles import Floats
from lamella.solve.linear import Method, linear_solver
from lamella.solve.newton import Newton, NewtonSolver
from lamella.solve.turned import Vectors
from lamella.units import quantity

if TYPE_CHECKING:
    Step = Longest = Tolerance = float
else:
    Step = quantity("s", gt=0)
    Longest = quantity("s", gt=0, unlimited=True)
    Tolerance = Annotated[float, Field(gt=0, lt=1)]

BDF_NEWTON = Newton(tolerance=1e-3, max_iterations=50, keep=0.6)
"""The tolerance is relative to what Newton's method changes in the prediction, and that is a few times the local error."""
FAILURES = 3
"""Failures of one step after which the past is not trusted and the order falls to 1."""
START = 4.0
"""Fixed steps begin with dt divided by this to the power of the highest order: the first step, of order 1, leaves an error of its
square, which must not be seen beside that of the highest order."""
CUT = (0.25, 0.9)
"""Smallest and largest change of a step whose error is too large."""
SHRINK = (0.5, 0.9)
"""Smallest and largest change of the next step where the error asks for a shorter one."""
FIRST_ERROR = 0.25
"""Error, relative to the tolerance, expected of the first step."""


@declaration
class BDF(Integrator):
    """Backward differentiation formulas of order 1 to 5 in steps of variable size, with fixed leading coefficient, as in DASSL
    and IDA, for the stabilised index-2 form of Gear, Gupta and Leimkuhler (1985):

        u' = v - B^T mu,   M v' + f(t, q, v) + Phi_q^T lam = 0,   Phi(t, q) = 0,   Phi_q v + Phi_t = 0

    Each derivative follows from the new value and a polynomial P through the past, y' = P' + alpha (y - P)
    (:class:`~.differences.Differences`); temperatures obey the same formulas with their rates. Constraints of positions and of
    velocities hold to rounding. Order and step follow from the difference of new values and their prediction.

    Formulas of order 1 and 2 are stable for all vibrations, 3 to 5 are not: a vibration with little damping grows when omega dt
    is between about 0.1 to 0.4 (depending on the order) and 2 to 5, until error control shortens the step to resolve it.
    Orders above 2 are for motion without such vibrations: mechanisms of rigid bodies, heat, strongly damped structures.

    Sources: K. E. Brenan, S. L. Campbell, L. R. Petzold (SIAM 1996); A. C. Hindmarsh and others, ACM Trans. Math. Softw. 31
    (2005) 363-396.

    Args:
        dt: longest first step, at the start and after jumps [s]; without a tolerance the size of all steps.
        tolerance: root mean square of the local error of displacements allowed in a step, relative to the size of the body (of
            temperatures relative to theirs); None for steps of fixed size, which begin with ever longer ones from
            dt / 4^max_order on.
        max_order: highest order, 1 to 5.
        dt_min: smallest step a rejected one is cut to [s]; dt / 2^16 when left out.
        dt_max: largest step under error control [s]; unlimited when left out.
        newton: how each step is solved.
    """

    dt: Step
    tolerance: Tolerance | None = 1e-5
    max_order: Annotated[int, Field(ge=1, le=5)] = 2
    dt_min: Step = 0.0
    dt_max: Longest = np.inf
    newton: Newton = BDF_NEWTON
    type: Literal["bdf"] = "bdf"

    def __post_init__(self) -> None:
        if self.dt_min == 0.0:
            object.__setattr__(self, "dt_min", self.dt / 2**16)

    def stepper(self, equations: Equations, statistics: Statistics, solver: Method = "auto") -> BDFStepper:
        """A stepper for these equations."""
        return BDFStepper(self, equations, statistics, solver)


class BDFStepper(Stepper):
    """Steps of :class:`BDF` in independent coordinates; moving supports enter through q, v and vdot exactly."""

    remembered = ("past", "order", "_equal", "_failures", "_starting", "_last")

    def __init__(self, options: BDF, equations: Equations, statistics: Statistics, solver: Method) -> None:
        self.options, self.equations, self.statistics = options, equations, statistics
        self.stabilised = StabilisedEquations(equations) if equations.n_lam else None
        self.linear = linear_solver(equations.matrix.pattern, solver)
        self.newton = NewtonSolver(self.stabilised or equations, self.linear, options.newton, statistics, Vectors(equations))
        self.change = ChangeSize(equations)

    def restart(self, point: Point) -> None:
        """Start from a consistent point, with order 1."""
        self.past = [point]
        self.order = 1
        self._equal = self._failures = 0
        self._starting = True
        self._last = 0.0, 1  # dt and order of the last step
        self._new: tuple[list[Point], tuple[float, int], int, int] | None = None
        self.newton.forget()

    def first_step(self, dt: float) -> float:
        """Without a tolerance a small share of dt; else what the error of the first step, dt^2 a / 2, allows."""
        if self.options.tolerance is None:
            return dt / START**self.options.max_order if self.options.max_order > 1 else dt
        curved = self.change.error(self.past[0].udd)
        allowed = np.sqrt(2.0 * FIRST_ERROR * self.options.tolerance / max(curved, 1e-300))
        return float(max(min(dt, allowed), self.options.dt_min))

    def step(self, dt: float) -> StepOutcome:
        """Predict by the polynomial through the past, then solve."""
        past = self.past if len(self.past) > 1 else [self.past[0], _earlier(self.past[0], dt)]
        order = 1 if self._failures >= FAILURES else self.order
        formula = Differences(np.array([point.t for point in past]), past[0].t + dt, order)
        alpha, n = formula.alpha, self.change.n
        used = past[: order + 1]
        values, rates = np.array([point.u for point in used]), np.array([point.ud for point in used])
        predicted, ud = formula.value @ values, formula.slope @ values
        udd = formula.slope @ rates + alpha * (ud - formula.value @ rates)
        udd[n:] = 0.0
        weights = Weights(1.0, alpha, alpha**2, alpha if n < len(udd) else 0.0)
        new = Point(formula.t, predicted, ud, udd, past[0].lam.copy())
        if self.stabilised:
            self.stabilised.begin(past[0], weights)
        report = self.newton.solve(new, weights, self.equations.coordinates(past[0]))
        if self.stabilised and report.converged:
            new = self.stabilised.finished(new)
        report = refuse_folding(report, self.change.turn(new.u - past[0].u))
        self._new = None
        if not report.converged:
            self._failures += 1
            return StepOutcome(report, None)
        equal = self._equal + 1 if (dt, order) == self._last else 1
        outcome = StepOutcome(report, new)
        if self.options.tolerance is None:
            chosen = min(order + 1, self.options.max_order)
            outcome = replace(outcome, growth=2.0 if equal > order == chosen else 1.0)
        else:
            outcome, chosen = self._judged(
                outcome, formula, np.array([point.u for point in past]), new, predicted, settled=equal > order
            )
        if outcome.error <= 1.0:
            self._new = [new, *past], (dt, order), equal, chosen
        else:
            self._failures += 1
        return outcome

    def _judged(
        self, outcome: StepOutcome, formula: Differences, past: Floats, new: Point, predicted: Floats, *, settled: bool
    ) -> tuple[StepOutcome, int]:
        """The outcome with its error and what that allows, and the order for the next step."""
        order, tolerance = formula.order, self.options.tolerance or 1.0
        difference = self.change.error(new.u - predicted) / tolerance
        errors = {order: formula.error_of(order) * difference}
        for other in formula.neighbours():
            found = formula.predictor(other) @ past[: other + 1]
            errors[other] = formula.error_of(other) * self.change.error(new.u - found) / tolerance
        error = formula.error_constant * difference
        if error > 1.0:
            growth = np.clip(_growth(errors[order], order), *CUT) if self._failures == 0 else CUT[0]
            return replace(outcome, error=error, growth=float(growth)), order
        starting = self._starting and self._failures == 0
        chosen = next_order(order, errors, self.options.max_order, settled=settled, starting=starting)
        if starting and chosen > order:
            growth = 2.0  # nothing is known yet of the error of the higher order
        else:
            wanted = _growth(errors[chosen], chosen)
            growth = 2.0 if wanted >= 2.0 else 1.0 if wanted > 1.0 else np.clip(wanted, *SHRINK)
        return replace(outcome, error=error, growth=float(growth)), chosen

    def accept(self) -> Point:
        """Make the step final; as many points are kept as the next order needs."""
        assert self._new is not None, "accept follows a converged step"
        past, self._last, self._equal, self.order = self._new
        order = self._last[1]
        self._starting = self._starting and self._failures == 0 and self.order > order
        self._failures = 0
        self.past = past[: self.options.max_order + 2]
        counts = self.statistics.steps_of_order
        counts[order] = counts.get(order, 0) + 1
        return self.past[0]

    def forget(self) -> None:
        """Drop the factorisation."""
        self.newton.forget()

    def recall(self, memory: dict[str, Any]) -> None:
        """Go on from what was remembered."""
        super().recall(memory)
        self._new = None
        self.forget()

    def between(self, t: float) -> Point:
        """By the polynomial through the new point and as many before it as its order."""
        used = self.past[: self._last[1] + 1]
        weights, _ = polynomial_weights(np.array([point.t for point in used]), t)
        u, ud, udd, lam = (weights @ np.array([getattr(point, name) for point in used]) for name in ("u", "ud", "udd", "lam"))
        return Point(t, u, ud, udd, lam)


def _earlier(point: Point, dt: float) -> Point:
    """Where a point came from, by the Taylor series backwards: a past for the first step."""
    return Point(point.t - dt, point.u - dt * point.ud + 0.5 * dt**2 * point.udd, point.ud - dt * point.udd, point.udd, point.lam)


def _growth(error: float, order: int) -> float:
    """Change of the step that would bring a local error to half the tolerance (Brenan, Campbell and Petzold 1996)."""
    return float((2.0 * error + 1e-4) ** (-1.0 / (order + 1)))
