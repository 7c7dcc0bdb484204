"""Parameters of a study: which values of the model file they replace, and the values they take."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Collection, Mapping, Sequence
from typing import TYPE_CHECKING, Annotated, Any, Literal

import numpy as np
from pydantic import Field

from lamella.arguments import FINITE
from lamella.declaration import declaration
from lamella.errors import DeclarationError
from lamella.roles import Floats

if TYPE_CHECKING:
    Bound = float | str
else:
    Bound = Annotated[float, Field(strict=True)] | str

QUANTITY = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)(?:\s*(|[^\W\d_].*|[%°µ].*)|\s+(1\s*/.*))")
"""A number and its unit, which may be the inverse of one."""
Scale = Literal["linear", "log"]


@declaration
class Parameter:
    """Something a study varies.

    Args:
        path: the value of the model file it replaces, as in ``--set``: ``system.plate.mesh``; several paths as a list, or as a
            mapping from path to a factor: ``{'laminates.panel.angles[0]': 1, 'laminates.panel.angles[1]': -1}``.
        values: the values it takes in a grid: numbers, text with a unit such as ``1.5 mm``, lists, words.
        range: its lowest and highest value, both with the same unit or none.
        count: number of values in a grid over ``range``.
        scale: how values are spread over ``range``: ``linear``, or ``log`` for equal ratios.
    """

    path: str | tuple[str, ...] | dict[str, float]
    values: tuple[Any, ...] | None = None
    range: tuple[Bound, Bound] | None = None
    count: Annotated[int, Field(ge=2)] | None = None
    scale: Scale = "linear"

    def __post_init__(self) -> None:
        """Refuse values beside a range, no path, and a range that is none."""
        if not all(self.factors) or not self.factors:
            raise ValueError("path is empty; accepted is the path of a value of the model file, such as system.plate.mesh")
        for path, factor in self.factors.items():
            if "=" in path:
                raise ValueError(f"path = {path}; accepted is the path of a value, without '='")
            if not math.isfinite(factor):
                raise ValueError(f"path: the factor of {path} is {factor}; accepted is a finite number")
        if self.values is not None and (self.range is not None or self.count is not None):
            raise ValueError("values and range are both given; accepted is one of them")
        if self.values is not None and not self.values:
            raise ValueError("values is empty; accepted is a list of at least one value")
        for value in self.values or ():
            check_value(value)
        if self.range is not None:
            low, high, _ = self.bounds
            if not math.isfinite(high - low):
                raise ValueError(f"range = {list(self.range)}; accepted are finite numbers")
            if not low < high:
                raise ValueError(f"range = {list(self.range)}; accepted is a lower value before a higher one")
            if self.scale == "log" and low <= 0.0:
                raise ValueError(f"range = {list(self.range)} has no logarithms; accepted are values above zero")

    @property
    def factors(self) -> dict[str, float]:
        """The paths, each with its factor."""
        if isinstance(self.path, dict):
            return {path.strip(): factor for path, factor in self.path.items()}
        return dict.fromkeys(map(str.strip, (self.path,) if isinstance(self.path, str) else self.path), 1.0)

    @property
    def bounds(self) -> tuple[float, float, str]:
        """Lowest and highest value, and their unit.

        Raises:
            ValueError: there is no range, or its ends are not numbers with one unit.
        """
        if self.range is None:
            raise ValueError("'range' is missing; accepted are two values such as [1 mm, 3 mm]")
        low, high = (quantity_of(end) for end in self.range)
        if low is None or high is None or low[1] != high[1]:
            raise ValueError(f"range = {list(self.range)}; accepted are two numbers with the same unit, such as [1 mm, 3 mm]")
        return low[0], high[0], low[1]

    def at(self, shares: Floats) -> list[Any]:
        """Values at shares of the range, from 0, the lowest, to 1, the highest."""
        low, high, unit = self.bounds
        if self.scale == "log":
            found = np.exp(np.log(low) + shares * (np.log(high) - np.log(low)))
        else:
            found = low + shares * (high - low)
        return [with_unit(float(value), unit) for value in found]

    def grid_size(self) -> int:
        """Number of values in a grid.

        Raises:
            ValueError: neither values nor a range with a count are given.
        """
        if self.values is not None:
            return len(self.values)
        if self.range is None or self.count is None:
            raise ValueError("a grid needs 'values', or 'range' and 'count'")
        return self.count

    def grid(self) -> Sequence[Any]:
        """The values in a grid.

        Raises:
            ValueError: neither values nor a range with a count are given.
        """
        return self.at(np.linspace(0.0, 1.0, self.grid_size())) if self.values is None else self.values

    def settings(self, value: Any) -> list[str]:
        """The ``key=value`` texts that give the model a value."""
        return [f"{path}={json.dumps(_times(value, factor), ensure_ascii=False)}" for path, factor in self.factors.items()]


def check_value(value: Any, item: str = "values") -> None:
    """Refuse what a model file cannot hold; the message begins with ``item``.

    Raises:
        ValueError: it is no number, text, truth value or list of such.
    """
    try:
        json.dumps(value, allow_nan=False)
    except (TypeError, ValueError) as error:
        raise ValueError(
            f"{item}: {value!r} of type {type(value).__name__}; accepted are numbers, text, true, false, lists"
        ) from error


def quantity_of(value: Any) -> tuple[float, str] | None:
    """Number and unit of a value; None when it is no number."""
    if isinstance(value, bool) or not isinstance(value, (int, float, str)):
        return None
    if not isinstance(value, str):
        return (float(value), "") if FINITE.accepts(value) or isinstance(value, float) else None
    found = QUANTITY.fullmatch(value)
    return (float(found[1]), (found[2] or found[3] or "").strip()) if found else None


def with_unit(value: float, unit: str) -> float | str:
    """A number as a model file has it; its text gives the same number back."""
    return f"{value!r} {unit}" if unit else value


def _times(value: Any, factor: float) -> Any:
    if factor == 1.0:
        return value
    if isinstance(value, (list, tuple)):
        return [_times(item, factor) for item in value]
    found = quantity_of(value)
    if found is None:
        raise DeclarationError("parameter", f"the value {value!r} times the factor {factor:g}", "accepted are numbers")
    return with_unit(found[0] * factor, found[1])


def check_names(parameters: Collection[str], outputs: Collection[str], columns: Collection[str]) -> None:
    """Refuse names that two columns of the table would have; ``columns`` are those it has in any case."""
    if twice := {*parameters} & {*outputs}:
        raise ValueError(f"outputs and parameters are both called {', '.join(sorted(twice))}; accepted are different names")
    for kind, names in (("parameters", parameters), ("outputs", outputs)):
        if not all(name.strip() for name in names):
            raise ValueError(f"{kind}: a name is empty; accepted is one that heads a column of the table")
        if taken := [name for name in names if name in columns]:
            raise ValueError(f"{kind}: the table has a column '{taken[0]}' of its own; accepted is another name")


def check_paths(parameters: Mapping[str, Parameter]) -> None:
    """Refuse a path that two parameters replace: the value of one would count for nothing."""
    taken: dict[str, str] = {}
    for name, parameter in parameters.items():
        for path in parameter.factors:
            if path in taken:
                raise ValueError(f"{name}: the path {path} is that of the parameter '{taken[path]}' already")
            taken[path] = name


def label_of(name: str, unit: str) -> str:
    """The head of a column: a name with its unit in brackets, where it has one."""
    return f"{name} [{unit}]" if unit not in ("", "1") else name


def label_twice(parameters: Mapping[str, str], outputs: Mapping[str, str]) -> tuple[str, str] | None:
    """The first parameter or output whose column has the head of another, with that head; from the unit of each."""
    labels = [(name, label_of(name, unit)) for units in (parameters, outputs) for name, unit in units.items()]
    heads = [head for _, head in labels]
    return next((pair for k, pair in enumerate(labels) if pair[1] in heads[:k]), None)


def columns_of(rows: Sequence[Mapping[str, Any]], names: Sequence[str]) -> dict[str, tuple[str, list[Any]]]:
    """Unit and values of each parameter over all runs: numbers where all are numbers with one unit, else text.

    Args:
        rows: value of each parameter, run by run.
        names: of the parameters.
    """
    found: dict[str, tuple[str, list[Any]]] = {}
    for name in names:
        values = [row[name] for row in rows]
        split = [quantity_of(value) for value in values]
        units = {pair[1] if pair else None for pair in split}
        if len(units) == 1 and None not in units:
            numbers = [pair[0] for pair in split if pair]
            found[name] = (str(units.pop()), numbers)
        else:
            found[name] = ("", [value if isinstance(value, str) else json.dumps(value) for value in values])
    return found
