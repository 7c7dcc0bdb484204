"""What a model file computes and writes: the motion and the output, as declarations; statics and modes stand beside it."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Annotated, ClassVar, Literal

from pydantic import Field

from lamella.assembly.equations import Equations
from lamella.declaration import declaration
from lamella.dofs import Signal
from lamella.errors import ModelError
from lamella.integrate.base import Integrator
from lamella.integrate.generalized_alpha import GeneralizedAlpha
from lamella.linear.state_space import StateSpace
from lamella.model import Model
from lamella.motion import simulate
from lamella.result import Result, Sink
from lamella.shapes import Shapes
from lamella.signals import system_signals
from lamella.state import State
from lamella.units import Number, Positive, Time, quantity

if TYPE_CHECKING:
    Interval = float
else:
    Interval = quantity("s", gt=0)

Computed = Result | Shapes | StateSpace
Count = Annotated[int, Field(ge=1)]


class Analysis(ABC):
    """Something computed with a system.

    1. It is frozen data with a ``name`` that is unique in its model file.
    2. ``axis`` and ``span`` say what its samples are taken over, for result file and progress bar; ``axis`` is empty when it
       records no samples.
    3. ``run`` returns what was computed also when the solution stopped early; the outcome says so.
    """

    name: str
    axis: ClassVar[str] = ""

    @property
    def span(self) -> tuple[float, float]:
        """Axis value at the start and at the end."""
        return 0.0, 1.0

    @property
    def target(self) -> float:
        """Time [s] or load factor asked for."""
        return self.span[1]

    def signals(self, equations: Equations) -> list[Signal]:
        """What it samples, in this order."""
        return system_signals(equations)

    def begins(self) -> dict[tuple[str, ...], str]:
        """The names of earlier analyses it goes on from, by the keys that say so."""
        named = {(key,): getattr(self, key, None) for key in ("start", "about")}
        named |= {(key, "of"): getattr(getattr(self, key, None), "of", None) for key in ("imperfection", "branch")}
        return {place: name for place, name in named.items() if name is not None}

    def check(self, equations: Equations) -> None:  # noqa: B027  # most name neither
        """Refuse names of inputs and outputs that the system does not have, before anything is computed.

        Raises:
            DeclarationError: there is no such input or output; those that there are are listed.
        """

    def prepared(self, model: Model, earlier: Mapping[str, Computed]) -> Model:
        """The model it computes with: that of the system, or of an earlier analysis it goes on from.

        Args:
            model: the compiled system.
            earlier: what the analyses before it gave, by name.
        """
        return model

    @abstractmethod
    def run(self, model: Model, earlier: Mapping[str, Computed], frames: int, sinks: Sequence[Sink]) -> Computed:
        """Compute it.

        Args:
            model: as prepared.
            earlier: what the analyses before it gave, by name.
            frames: number of configurations kept for pictures.
            sinks: receive the solution while it runs.
        """


@declaration
class Motion(Analysis):
    """The motion in time.

    Args:
        name: unique name.
        t_end: time at the end [s].
        integrator: method and step.
        t_start: time at the start [s].
        start: name of an earlier analysis whose last state is the initial one; the reference configuration when left out.
        every: interval at which is recorded too, besides the steps; the steps alone when left out.
        stride: every so manyth step is recorded, and the last; work and heat are summed over all.
    """

    axis: ClassVar[str] = "time"
    name: str
    t_end: Time
    integrator: Integrator = GeneralizedAlpha(1e-3)
    t_start: Time = 0.0
    start: str | None = None
    every: Interval | None = None
    stride: Annotated[int, Field(ge=1)] = 1

    def __post_init__(self) -> None:
        """Refuse an end before the start."""
        if not self.t_end > self.t_start:
            raise ValueError(f"t_end = {self.t_end:g} s; accepted is a time later than t_start = {self.t_start:g} s")

    @property
    def span(self) -> tuple[float, float]:
        return self.t_start, self.t_end

    def prepared(self, model: Model, earlier: Mapping[str, Computed]) -> Model:
        return model_of(self, self.start, earlier) or model

    def run(self, model: Model | Equations, earlier: Mapping[str, Computed], frames: int, sinks: Sequence[Sink]) -> Result:
        initial = state_of(self, self.start, earlier)
        return simulate(
            model,
            self.t_end,
            self.integrator,
            t_start=self.t_start,
            initial=initial,
            frames=frames,
            every=self.every,
            stride=self.stride,
            sinks=sinks,
            on_failure="return",
        )


@declaration
class Output:
    """What is written besides the result file.

    Args:
        frames: number of equally spaced configurations kept of a motion.
        signals: signals in the plots, such as ``tip.position.z``; positions, forces, and what joints move when left out.
        field: what colours the pictures, such as ``displacement`` or ``von_mises``.
        view: ``isometric``, ``front``, ``side``, ``top``, or the direction in which the camera looks.
        at: times, load factors, or points of a path, of the pictures; a few spread over the whole when left out.
        scale: factor on the displacements in pictures.
        csv: write all signals as a table.
        paraview: write the moving surface for ParaView.
        pictures: write plots and pictures.
        animation: write an animation of a motion.
        report: write the report page.
    """

    frames: Count = 100
    signals: tuple[str, ...] | None = None
    field: str = "displacement"
    view: Literal["isometric", "front", "side", "top"] | tuple[Number, Number, Number] = "isometric"
    at: tuple[Number, ...] | None = None
    scale: Positive = 1.0
    csv: bool = True
    paraview: bool = True
    pictures: bool = True
    animation: bool = True
    report: bool = True


def state_of(analysis: Analysis, name: str | None, earlier: Mapping[str, Computed]) -> State | None:
    """The last state of the earlier analysis ``name``; None without a name.

    Raises:
        ModelError: there is none of that name, or it has no state.
    """
    return None if name is None else result_of(analysis, name, earlier).final


def model_of(analysis: Analysis, name: str | None, earlier: Mapping[str, Computed]) -> Model | None:
    """The model of the earlier analysis ``name``, which may have an imperfection; None without a name.

    Raises:
        ModelError: as :func:`state_of`.
    """
    return None if name is None else result_of(analysis, name, earlier).model


def result_of(analysis: Analysis, name: str, earlier: Mapping[str, Computed]) -> Result:
    """The result of the earlier analysis ``name``.

    Raises:
        ModelError: there is none of that name, or it has no state.
    """
    found = earlier.get(name)
    if not isinstance(found, Result):
        known = ", ".join(key for key, item in earlier.items() if isinstance(item, Result)) or "none"
        raise ModelError(
            f"analysis '{analysis.name}' starts from '{name}', which is no earlier analysis with a state; there are: {known}"
        )
    return found


def shape_table(found: Shapes) -> list[tuple[int, float]]:
    """Numbers from 1 and frequencies [Hz] or load factors."""
    return [(number, float(value)) for number, value in enumerate(found.values, start=1)]
