"""Outputs of a study: the numbers kept of each run."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from lamella.assembly.equations import Equations
from lamella.declaration import declaration
from lamella.dofs import Signal
from lamella.errors import DeclarationError
from lamella.io.analysis import Analysis, Computed
from lamella.io.linear_analysis import Linear
from lamella.io.reader import suggestion
from lamella.io.static_analysis import Buckling, NaturalModes
from lamella.linear.state_space import StateSpace
from lamella.model import Model
from lamella.result import Result
from lamella.roles import Floats
from lamella.shapes import Shapes
from lamella.study.measures import least_squares_slope, time_average
from lamella.units import Time

Statistic = Literal["last", "max", "min", "largest", "mean", "rms", "std", "slope"]
NORM = "norm"


class StudyOutput(ABC):
    """A number taken from what a run computed.

    1. It is frozen data; ``analysis`` names the analysis it is taken from, and may be left out where only one can be meant.
    2. ``check`` refuses, before anything is run, what the model does not have.
    3. ``value`` returns a finite number or raises a ``DeclarationError``.
    """

    analysis: str | None

    @abstractmethod
    def check(self, analysis: Analysis, signals: Mapping[str, Signal], model: Model) -> str:
        """Refuse what the analysis does not give; returns the unit.

        Args:
            analysis: from which it is taken.
            signals: that the analysis records, by name.
            model: that the analysis computes with.

        Raises:
            DeclarationError: the message says what there is.
        """

    @abstractmethod
    def value(self, computed: Computed) -> float:
        """The number."""

    @abstractmethod
    def fits(self, analysis: Analysis) -> bool:
        """Whether an analysis gives numbers of this kind."""

    def chosen(self, analyses: Mapping[str, Analysis]) -> Analysis:
        """The analysis meant.

        Raises:
            DeclarationError: there is none of that name, or several may be meant.
        """
        fitting = [name for name, analysis in analyses.items() if self.fits(analysis)]
        kind = {SignalOutput: "signals", MassOutput: "a mass"}.get(type(self), "frequencies or load factors")
        if self.analysis is None and len(fitting) == 1:
            return analyses[fitting[0]]
        known = ", ".join(fitting) or "none"
        if self.analysis is None:
            raise DeclarationError("output", "'analysis' is missing", f"analyses with {kind} are {known}")
        if self.analysis not in fitting:
            problem = f"no analysis '{self.analysis}' with {kind}{suggestion(self.analysis, fitting)}"
            raise DeclarationError("output", f"analysis: {problem}")
        return analyses[self.analysis]


@declaration
class SignalOutput(StudyOutput):
    """A number that describes a recorded signal.

    Args:
        signal: such as ``tip.position`` or ``root.force``.
        statistic: ``last`` value, ``max``, ``min``, ``largest`` magnitude, ``mean``, ``rms`` or ``std``, which are averages
            over time by the trapezoidal rule, or ``slope``, that of the straight line of least squares [unit/s].
        component: of a vector, such as ``z``, or ``norm`` for its length.
        start: from this time [s] or load factor on; from the beginning when left out.
        end: up to this time [s] or load factor; to the end when left out.
        analysis: which motion or statics, where there are several.
    """

    signal: str
    statistic: Statistic = "last"
    component: str | None = None
    start: Time | None = None
    end: Time | None = None
    analysis: str | None = None
    kind: Literal["signal"] = "signal"

    @property
    def of_end(self) -> bool:
        """Whether it is the value in the last state."""
        return self.statistic == "last" and self.end is None

    def fits(self, analysis: Analysis) -> bool:
        return bool(analysis.axis)

    def check(self, analysis: Analysis, signals: Mapping[str, Signal], model: Model) -> str:
        if self.signal not in signals:
            raise DeclarationError("output", f"signal: there is no signal '{self.signal}'{suggestion(self.signal, signals)}")
        found = signals[self.signal]
        labels = tuple(found.labels or ())
        accepted = ", ".join((*labels, NORM)) if labels else "no component"
        if labels and self.component is None:
            raise DeclarationError(
                "output", f"signal: '{self.signal}' is a vector, 'component' is missing", f"accepted is {accepted}"
            )
        if self.component is not None and self.component not in ((*labels, NORM) if labels else ()):
            problem = f"component: '{self.signal}' has no component '{self.component}'"
            raise DeclarationError("output", problem, f"accepted is {accepted}")
        first, last = sorted(analysis.span)
        start, end = self._window(first, last)
        if not (first <= start < end <= last) and analysis.axis != "path":
            unit = "s" if analysis.axis == "time" else ""
            raise DeclarationError(
                "output",
                f"{'start' if self.start is not None else 'end'}: the window from {start:g} to {end:g} {unit}".rstrip(),
                f"analysis '{analysis.name}' goes from {first:g} to {last:g} {unit}".rstrip(),
            )
        if self.statistic == "slope" and analysis.axis == "path":
            raise DeclarationError("output", "statistic: a slope over the points of a path", "accepted are the other statistics")
        return f"{found.unit}/s" if self.statistic == "slope" and analysis.axis == "time" else found.unit

    def value(self, computed: Computed) -> float:
        assert isinstance(computed, Result)
        values = computed.samples(self.signal)
        return self.number(computed.at, values.reshape(len(values), -1), tuple(computed.signals[self.signal].labels))

    def number(self, at: Floats, values: Floats, labels: tuple[str, ...]) -> float:
        """The number from samples of the signal.

        Args:
            at: times [s] or load factors, shape (n,).
            values: shape (n, n_component).
            labels: of the components.
        """
        if self.component == NORM:
            z = np.linalg.norm(values, axis=1)
        else:
            z = values[:, 0 if self.component is None else labels.index(self.component)]
        at, z = self.within(at, np.asarray(z, float))
        return float(STATISTICS[self.statistic](at, z))

    def _window(self, first: float, last: float) -> tuple[float, float]:
        return (first if self.start is None else self.start), (last if self.end is None else self.end)

    def within(self, at: Floats, z: Floats) -> tuple[Floats, Floats]:
        """Samples in the window, with interpolated ones at its ends."""
        if self.start is None and self.end is None:
            return at, z
        start, end = self._window(at[0], at[-1])
        if end > at[-1] + 1e-9 * abs(at[-1]):  # an event ended the run
            raise DeclarationError("output", f"the window ends at {end:g}", f"the run ended at {at[-1]:g}")
        inner = (at > start) & (at < end)
        ends = np.interp([start, end], at, z)
        return np.array([start, *at[inner], end]), np.array([ends[0], *z[inner], ends[1]])


@declaration
class ShapeOutput(StudyOutput):
    """A natural frequency [Hz] or a buckling load factor.

    Args:
        number: which, from 1.
        analysis: which natural modes or buckling, where there are several.
    """

    number: Annotated[int, Field(ge=1)] = 1
    analysis: str | None = None
    kind: Literal["shape"] = "shape"

    def fits(self, analysis: Analysis) -> bool:
        return isinstance(analysis, (NaturalModes, Buckling))

    def check(self, analysis: Analysis, signals: Mapping[str, Signal], model: Model) -> str:
        assert isinstance(analysis, (NaturalModes, Buckling))
        if self.number > analysis.count:
            raise DeclarationError("output", f"number = {self.number}", f"analysis '{analysis.name}' computes {analysis.count}")
        return "Hz" if isinstance(analysis, NaturalModes) else "1"

    def value(self, computed: Computed) -> float:
        assert isinstance(computed, Shapes)
        if self.number > len(computed.values):
            raise DeclarationError("output", f"number = {self.number}", f"found were {len(computed.values)} shapes")
        return float(computed.values[self.number - 1])


@declaration
class MassOutput(StudyOutput):
    """The mass of all bodies, or of one [kg].

    Args:
        body: name of a body; all when left out.
        analysis: any; not needed.
    """

    body: str | None = None
    analysis: str | None = None
    kind: Literal["mass"] = "mass"

    def fits(self, analysis: Analysis) -> bool:
        return not isinstance(analysis, Linear)

    def chosen(self, analyses: Mapping[str, Analysis]) -> Analysis:
        fitting = [analysis for analysis in analyses.values() if self.fits(analysis)]
        return super().chosen(analyses) if self.analysis is not None or not fitting else fitting[0]

    def check(self, analysis: Analysis, signals: Mapping[str, Signal], model: Model) -> str:
        self.of_model(model)
        return "kg"

    def value(self, computed: Computed) -> float:
        assert not isinstance(computed, StateSpace)
        return self.of_model(computed.model)

    def of_model(self, model: Model) -> float:
        """The mass in a model: what accelerates against a force when all positions move alike.

        Raises:
            DeclarationError: there is no such body.
        """
        owners = np.array(model.owners)
        if self.body is not None and self.body not in model.owners:
            problem = f"body: there is no body '{self.body}' with mass{suggestion(self.body, dict.fromkeys(model.owners))}"
            raise DeclarationError("output", problem)
        chosen = model.is_position & ((owners == self.body) if self.body is not None else True)
        moved = np.zeros(model.n_q)
        moved[: model.n_motion : 3] = chosen
        return float(moved @ (model.mass @ moved))


STATISTICS: dict[str, Callable[[Floats, Floats], float]] = {
    "last": lambda at, z: z[-1],
    "max": lambda at, z: z.max(),
    "min": lambda at, z: z.min(),
    "largest": lambda at, z: np.abs(z).max(),
    "mean": time_average,
    "rms": lambda at, z: np.sqrt(time_average(at, z**2)),
    "std": lambda at, z: np.sqrt(time_average(at, (z - time_average(at, z)) ** 2)),
    "slope": least_squares_slope,
}


def recorded(analyses: Iterable[Analysis], equations: Equations) -> dict[str, dict[str, Signal]]:
    """The signals that each analysis records, by the analysis's name and theirs."""
    return {each.name: {signal.name: signal for signal in each.signals(equations)} if each.axis else {} for each in analyses}
