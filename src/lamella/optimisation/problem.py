"""An optimisation as data, from Python or from a file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from lamella.declaration import declaration
from lamella.errors import DeclarationError, LamellaError, ModelFileError, UnitError
from lamella.io.document import Document, Place
from lamella.io.reader import suggestion
from lamella.roles import Floats
from lamella.sweep.file import read_declaration
from lamella.sweep.outputs import StudyOutput
from lamella.sweep.parameter import Bound, Parameter, check_names, check_paths, quantity_of
from lamella.units import to_si

Method = Literal["slsqp", "l-bfgs-b", "trust-constr"]
Goal = Literal["minimize", "maximize", "target"]


@declaration
class Objective:
    """What the best design is measured by.

    Args:
        output: name of an output.
        goal: ``minimize`` it, ``maximize`` it, or bring it to a ``target``.
        target: value it is brought to, in the output's unit or with one of its own.
    """

    output: str
    goal: Goal = "minimize"
    target: Bound | None = None

    def __post_init__(self) -> None:
        """Refuse a target without that goal, and the goal without a target."""
        if (self.goal == "target") != (self.target is not None):
            raise ValueError(f"goal = {self.goal} with target = {self.target}; accepted is a target with the goal 'target' alone")


@declaration
class Limits:
    """Bounds of an output, in its unit or with one of their own.

    Args:
        min: lowest value allowed.
        max: highest value allowed.
    """

    min: Bound | None = None
    max: Bound | None = None

    def __post_init__(self) -> None:
        """Refuse limits that are none."""
        if self.min is None and self.max is None:
            raise ValueError("neither min nor max is given; accepted is at least one")

    def of(self, unit: str) -> tuple[float, float]:
        """Lowest and highest value in a unit.

        Raises:
            UnitError: one is no number in such a unit.
            ValueError: they are reversed.
        """
        low = -np.inf if self.min is None else in_unit(self.min, unit)
        high = np.inf if self.max is None else in_unit(self.max, unit)
        if not low <= high:
            raise ValueError(f"min = {self.min} lies above max = {self.max}; accepted is a lower value before a higher one")
        return low, high


@declaration
class Optimisation:
    """A search for the values of parameters at which an output is best.

    Args:
        model: a model file, or the name of an example.
        parameters: what may change, by name, each with a ``path`` and the ``range`` it must stay in.
        outputs: numbers taken from what is computed, by name.
        objective: what is best.
        constraints: bounds of outputs, by their name.
        start: value of each parameter to begin with; the middle of its range when left out.
        method: of SciPy's ``minimize``: ``slsqp`` (sequential quadratic programming), ``l-bfgs-b`` (no constraints) or
            ``trust-constr`` (interior point).
        tolerance: of the method, for an objective of size one.
        max_iterations: of the method.
        title: a line for the head of the report.
        description: what it is about.
        set: ``key=value`` texts that replace values of the model in every design.
        optimize: version of the file's form.
    """

    model: str
    parameters: dict[str, Parameter]
    outputs: dict[str, StudyOutput]
    objective: Objective
    constraints: dict[str, Limits] = Field(default_factory=dict)
    start: dict[str, Bound] = Field(default_factory=dict)
    method: Method = "slsqp"
    tolerance: Annotated[float, Field(gt=0.0, lt=1.0)] = 1e-6
    max_iterations: Annotated[int, Field(ge=1)] = 50
    title: str = ""
    description: str = ""
    set: tuple[str, ...] = ()
    optimize: Literal[1] = 1

    def __post_init__(self) -> None:
        """Refuse unknown names, parameters without a range, a start outside of it, and constraints that a method ignores."""
        if not self.parameters or not self.outputs:
            raise ValueError(f"{'outputs' if self.parameters else 'parameters'} is empty; accepted is at least one")
        for name, parameter in self.parameters.items():
            if parameter.values is not None or parameter.count is not None:
                raise ValueError(f"{name}: values and count belong to grids; accepted is 'path' with 'range'")
            if parameter.range is None:
                raise ValueError(f"{name}: 'range' is missing; accepted are two values such as [1 mm, 3 mm]")
        check_paths(self.parameters)
        check_names(self.parameters, self.outputs, ("design", "objective", "violation", "status", "message", "seconds"))
        for key, names, known in (
            ("objective", [self.objective.output], self.outputs),
            ("constraints", [*self.constraints], self.outputs),
            ("start", [*self.start], self.parameters),
        ):
            for name in names:
                if name not in known:
                    what = "parameter" if key == "start" else "output"
                    raise ValueError(f"{key}: there is no {what} '{name}'{suggestion(name, known)}")
        if self.method == "l-bfgs-b" and self.constraints:
            raise ValueError("method = l-bfgs-b knows no constraints; accepted are slsqp and trust-constr")
        self.first()

    @property
    def units(self) -> dict[str, str]:
        """Unit of each parameter, that of its range."""
        return {name: parameter.bounds[2] for name, parameter in self.parameters.items()}

    def first(self) -> Floats:
        """Shares of the ranges at which the search begins.

        Raises:
            ValueError: a start has another unit than the range, or lies outside of it.
        """
        shares = []
        for name, parameter in self.parameters.items():
            low, high, unit = parameter.bounds
            given = quantity_of(self.start[name]) if name in self.start else None
            if name not in self.start:
                shares.append(0.5)
                continue
            if given is None or given[1] != unit or not low <= given[0] <= high:
                accepted = f"accepted is {low:g} to {high:g} {unit}".rstrip()
                raise ValueError(f"start: {name} = {self.start[name]}; {accepted}, with the unit of the range")
            place = np.array([given[0], low, high])
            value, low, high = np.log(place) if parameter.scale == "log" else place
            shares.append(float((value - low) / (high - low)))
        return np.array(shares)

    def values(self, shares: Floats) -> tuple[dict[str, float], Floats]:
        """Values of the parameters at shares of their ranges, and how fast each changes with its share."""
        values, rates = {}, []
        for (name, parameter), share in zip(self.parameters.items(), shares, strict=True):
            low, high, _ = parameter.bounds
            if parameter.scale == "log":
                values[name] = float(low * (high / low) ** share)
                rates.append(values[name] * np.log(high / low))
            else:
                values[name] = float(low + share * (high - low))
                rates.append(high - low)
        return values, np.array(rates)

    def sizes(self, values: Mapping[str, float]) -> dict[str, float]:
        """Size of a change of each parameter that matters, in its unit: that of its range, or of its value where this is smaller.

        A share of the range would lead from a small value of a wide range to one of the other sign, such as a negative thickness.
        """
        found = {}
        for name, parameter in self.parameters.items():
            low, high, _ = parameter.bounds
            found[name] = high - low if low <= 0.0 <= high else min(high - low, abs(values[name]))
        return found


@dataclass(frozen=True)
class OptimisationFile:
    """An optimisation with the file it was read from, for messages.

    Args:
        problem: what the file says.
        document: the file; None when it was made in Python.
    """

    problem: Optimisation
    document: Document | None = None

    def refused(self, place: Place, text: str) -> LamellaError:
        """An error that names file, line and key, or the item."""
        if self.document is None:
            return DeclarationError(f"optimisation: {' '.join(map(str, place))}".strip(), text)
        return ModelFileError(f"{self.document.name}, {self.document.where(place)}: {text}")

    def limits(self, units: Mapping[str, str]) -> tuple[float | None, dict[str, tuple[float, float]]]:
        """The target of the objective, and lowest and highest value of each constraint, in the units of the outputs.

        Raises:
            ModelFileError, DeclarationError: a number has another unit, or limits are reversed.
        """
        problem, found = self.problem, {}
        for name, limits in problem.constraints.items():
            try:
                found[name] = limits.of(units[name])
            except (UnitError, ValueError) as error:
                raise self.refused(("constraints", name), str(error)) from error
        if problem.objective.target is None:
            return None, found
        try:
            return in_unit(problem.objective.target, units[problem.objective.output]), found
        except UnitError as error:
            raise self.refused(("objective", "target"), str(error)) from error


def in_unit(value: float | str, unit: str) -> float:
    """A number in the unit of an output."""
    return to_si(value, "" if unit == "1" else unit)


def read_optimisation(path: str | Path) -> OptimisationFile:
    """Read an optimisation file.

    Raises:
        ModelFileError: it cannot be read, or does not describe an optimisation; all its problems are listed with their lines.
    """
    return OptimisationFile(*read_declaration(path, Optimisation, "optimize"))
