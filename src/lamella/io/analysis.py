"""What a model file computes and writes: the analyses and the output, as declarations."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from typing import Annotated, ClassVar, Literal

from pydantic import Field

from lamella.assembly.equations import Equations
from lamella.declaration import declaration
from lamella.dofs import Signal
from lamella.errors import ModelError
from lamella.integrate.base import Integrator
from lamella.integrate.generalized_alpha import GeneralizedAlpha
from lamella.modal import Modes, modes
from lamella.model import Model
from lamella.motion import simulate
from lamella.result import Result, Sink
from lamella.roles import Floats
from lamella.signals import LOAD_FACTOR, system_signals
from lamella.solve.arc_length import ArcLength
from lamella.solve.newton import Newton
from lamella.state import State
from lamella.statics import STATIC_NEWTON, equilibrium, equilibrium_path
from lamella.units import Number, Positive, Time

Computed = Result | Modes
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

    @abstractmethod
    def run(self, model: Model, earlier: Mapping[str, Computed], frames: int, sinks: Sequence[Sink]) -> Computed:
        """Compute it.

        Args:
            model: the compiled system.
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
    """

    axis: ClassVar[str] = "time"
    name: str
    t_end: Time
    integrator: Integrator = GeneralizedAlpha(1e-3)
    t_start: Time = 0.0
    start: str | None = None

    def __post_init__(self) -> None:
        """Refuse an end before the start."""
        if not self.t_end > self.t_start:
            raise ValueError(f"t_end = {self.t_end:g} s; accepted is a time later than t_start = {self.t_start:g} s")

    @property
    def span(self) -> tuple[float, float]:
        return self.t_start, self.t_end

    def run(self, model: Model, earlier: Mapping[str, Computed], frames: int, sinks: Sequence[Sink]) -> Result:
        initial = state_of(self, self.start, earlier)
        return simulate(
            model,
            self.t_end,
            self.integrator,
            t_start=self.t_start,
            initial=initial,
            frames=frames,
            sinks=sinks,
            on_failure="return",
        )


@declaration
class Statics(Analysis):
    """Static equilibrium under the full load, reached in load steps.

    Args:
        name: unique name.
        steps: number of equal load steps, or ascending load factors to solve for; cut where needed.
        time: time at which loads and prescribed motions are taken [s].
        newton: how each step is solved.
        smallest_step: load step below which the solution is given up.
    """

    axis: ClassVar[str] = "load_factor"
    name: str
    steps: Count | tuple[Number, ...] = 1
    time: Time = 0.0
    newton: Newton = STATIC_NEWTON
    smallest_step: Annotated[float, Field(gt=0, lt=1)] = 1e-4

    @property
    def span(self) -> tuple[float, float]:
        return 0.0, self.steps[-1] if isinstance(self.steps, tuple) and self.steps else 1.0

    def signals(self, equations: Equations) -> list[Signal]:
        return [LOAD_FACTOR, *system_signals(equations)]

    def run(self, model: Model, earlier: Mapping[str, Computed], frames: int, sinks: Sequence[Sink]) -> Result:
        return equilibrium(
            model,
            t=self.time,
            steps=self.steps,
            newton=self.newton,
            smallest_step=self.smallest_step,
            sinks=sinks,
            on_failure="return",
        )


@declaration
class Path(Analysis):
    """The equilibrium path by its arc length, through limit points.

    Args:
        name: unique name.
        until: load factor at which the path ends.
        time: time at which loads and prescribed motions are taken [s].
        arc: control of the arc length.
        newton: how each step is solved.
    """

    axis: ClassVar[str] = "path"
    name: str
    until: Number = 1.0
    time: Time = 0.0
    arc: ArcLength = ArcLength()
    newton: Newton = STATIC_NEWTON

    @property
    def span(self) -> tuple[float, float]:
        return 0.0, float(self.arc.max_steps)

    @property
    def target(self) -> float:
        return self.until

    def signals(self, equations: Equations) -> list[Signal]:
        return [LOAD_FACTOR, *system_signals(equations)]

    def run(self, model: Model, earlier: Mapping[str, Computed], frames: int, sinks: Sequence[Sink]) -> Result:
        return equilibrium_path(
            model, t=self.time, until=self.until, arc=self.arc, newton=self.newton, sinks=sinks, on_failure="return"
        )


@declaration
class NaturalModes(Analysis):
    """Natural frequencies and shapes.

    Args:
        name: unique name.
        count: number of modes, from the lowest.
        about: name of an earlier analysis whose last state the modes are about; the reference configuration when left out.
    """

    name: str
    count: Count = 10
    about: str | None = None

    def run(self, model: Model, earlier: Mapping[str, Computed], frames: int, sinks: Sequence[Sink]) -> Modes:
        return modes(model, self.count, state=state_of(self, self.about, earlier))


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
    if name is None:
        return None
    found = earlier.get(name)
    if not isinstance(found, Result):
        known = ", ".join(key for key, item in earlier.items() if isinstance(item, Result)) or "none"
        raise ModelError(
            f"analysis '{analysis.name}' starts from '{name}', which is no earlier analysis with a state; there are: {known}"
        )
    return found.final


def mode_table(found: Modes) -> list[tuple[int, float]]:
    """Numbers from 1 and frequencies [Hz]."""
    frequencies: Floats = found.frequencies
    return [(number, float(frequency)) for number, frequency in enumerate(frequencies, start=1)]
