"""The search: designs tried one after another, each with its gradient, and what was found."""

from __future__ import annotations

import time
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.optimize import NonlinearConstraint, minimize

from lamella.differentiation.gradient import Gradient
from lamella.errors import LamellaError
from lamella.optimisation.problem import Optimisation
from lamella.roles import Floats

MET = 1e-6
"""Violation of a constraint, relative to its limit, that counts as met."""


@dataclass(frozen=True)
class Design:
    """A design that was tried.

    Args:
        number: in the order tried, from 1.
        values: of the parameters, by name, in their units.
        outputs: by name; empty when the model failed.
        objective: what is minimised: the output, its negative, or its distance from the target; NaN when the model failed.
        violation: largest violation of a constraint, relative to its limit.
        status: ``ok`` or ``failed``.
        message: why it failed.
        seconds: time it took.
    """

    number: int
    values: Mapping[str, float]
    outputs: Mapping[str, float] = field(default_factory=dict)
    objective: float = np.nan
    violation: float = np.nan
    status: str = "ok"
    message: str = ""
    seconds: float = 0.0

    @property
    def meets(self) -> bool:
        """Whether all constraints are met."""
        return self.status == "ok" and self.violation <= MET


class FailedDesignError(Exception):
    """The model of a design cannot be made or solved."""


class Search:
    """Tries designs, and hands their objective and constraints to SciPy with derivatives by the shares of the ranges.

    Args:
        problem: what is looked for.
        evaluate: gives outputs and gradient at values of the parameters.
        target: of the objective, in the output's unit.
        limits: of each constraint, in the outputs' units.
        keep: takes each design when it is finished.
    """

    def __init__(
        self,
        problem: Optimisation,
        evaluate: Callable[[Mapping[str, float]], Gradient],
        target: float | None,
        limits: Mapping[str, tuple[float, float]],
        keep: Callable[[Design], None],
    ) -> None:
        self.problem, self.evaluate, self.target, self.limits, self.keep = problem, evaluate, target, limits, keep
        self.history: list[Design] = []
        self._known: dict[bytes, tuple[float, Floats, Floats, Floats]] = {}
        self._size = 0.0

    def run(self) -> tuple[bool, str]:
        """Search from the start of the problem; whether the method has converged, and what it says.

        Raises:
            FailedDesignError: the model of a design fails.
        """
        problem, x0 = self.problem, self.problem.first()
        bounds = [(0.0, 1.0)] * len(x0)
        options: dict[str, Any] = {"maxiter": problem.max_iterations}
        if problem.method == "trust-constr":
            options |= {"gtol": problem.tolerance, "xtol": problem.tolerance}
        else:
            options["ftol"] = problem.tolerance
        if problem.method == "l-bfgs-b":
            options["gtol"] = problem.tolerance
        with warnings.catch_warnings():
            warnings.filterwarnings("ignore", "delta_grad == 0.0")  # trust-constr, of an output that is linear
            found: Any = minimize(
                lambda x: self._at(x)[0],
                x0,
                jac=lambda x: self._at(x)[1],
                bounds=bounds,
                constraints=self._constraints(x0),
                method={"slsqp": "SLSQP", "l-bfgs-b": "L-BFGS-B", "trust-constr": "trust-constr"}[problem.method],
                options=options,
            )
        converged = bool(found.success) if problem.method != "trust-constr" else found.status in (1, 2)
        return converged, str(found.message)

    def _constraints(self, x0: Floats) -> list[Any]:
        """Outputs between their limits, each divided by its size."""
        if not self.limits:
            return []
        sizes = np.array([_size(*limits) for limits in self.limits.values()])
        low, high = (np.array(ends) / sizes for ends in zip(*self.limits.values(), strict=True))
        if self.problem.method == "trust-constr":
            slopes: Any = lambda x: self._at(x)[3] / sizes[:, None]  # noqa: E731  # SciPy's annotation knows words alone
            return [NonlinearConstraint(lambda x: self._at(x)[2] / sizes, low, high, jac=slopes)]
        rows = [(k, sign, end[k]) for sign, end in ((1.0, low), (-1.0, high)) for k in range(len(sizes)) if np.isfinite(end[k])]
        chosen, signs, ends = (
            np.array([k for k, _, _ in rows]),
            np.array([s for _, s, _ in rows]),
            np.array([e for _, _, e in rows]),
        )
        return [
            {
                "type": "ineq",
                "fun": lambda x: signs * ((self._at(x)[2] / sizes)[chosen] - ends),
                "jac": lambda x: signs[:, None] * (self._at(x)[3] / sizes[:, None])[chosen],
            }
        ]

    def _at(self, x: Floats) -> tuple[float, Floats, Floats, Floats]:
        """Objective and its gradient, in sizes of the first one, and constrained outputs and theirs, by shares."""
        x = np.clip(np.asarray(x, float), 0.0, 1.0)
        key = x.tobytes()
        if key not in self._known:
            self._known[key] = self._tried(x)
        return self._known[key]

    def _tried(self, x: Floats) -> tuple[float, Floats, Floats, Floats]:
        values, rates = self.problem.values(x)
        begun, number = time.perf_counter(), len(self.history) + 1
        try:
            found = self.evaluate(values)
        except LamellaError as error:
            message = " ".join(str(error).split())
            self._finish(Design(number, values, status="failed", message=message, seconds=time.perf_counter() - begun))
            raise FailedDesignError(message) from error
        objective, slope = self._objective(found)
        violation = max((_violation(found.values[name], *limits) for name, limits in self.limits.items()), default=0.0)
        seconds = time.perf_counter() - begun
        self._finish(Design(number, values, found.values, objective, violation, seconds=seconds))
        if not self._size:
            self._size = abs(objective) or 1.0
        value, gradient = objective / self._size, slope * rates / self._size
        if self.target is not None:  # a distance has a kink where it vanishes, its square has none
            value, gradient = value**2, 2.0 * value * gradient
        constrained = np.array([found.values[name] for name in self.limits])
        jacobian = np.array([found.derivatives[name] * rates for name in self.limits]).reshape(len(self.limits), len(x))
        return float(value), gradient, constrained, jacobian

    def _objective(self, found: Gradient) -> tuple[float, Floats]:
        objective = self.problem.objective
        value, slope = found.values[objective.output], found.derivatives[objective.output]
        if self.target is not None:
            sign = 1.0 if value >= self.target else -1.0
            return abs(value - self.target), sign * slope
        return (-value, -slope) if objective.goal == "maximize" else (value, slope)

    def _finish(self, design: Design) -> None:
        self.history.append(design)
        self.keep(design)


def best_of(history: Sequence[Design]) -> Design | None:
    """The best design that meets the constraints; the one that violates them least when none does."""
    tried = [design for design in history if design.status == "ok"]
    meeting = [design for design in tried if design.meets]
    if meeting:
        return min(meeting, key=lambda design: design.objective)
    return min(tried, key=lambda design: design.violation, default=None)


def _size(low: float, high: float) -> float:
    return max((abs(end) for end in (low, high) if np.isfinite(end)), default=0.0) or 1.0


def _violation(value: float, low: float, high: float) -> float:
    return max(low - value, value - high, 0.0) / _size(low, high)
