"""What a solution leaves: recorded signals, frames of the motion, statistics, and how it ended."""

from __future__ import annotations

import enum
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

import numpy as np

from lamella.arguments import TEXT, WHOLE, accepts, optional
from lamella.critical import CriticalPoint
from lamella.dofs import Signal
from lamella.errors import DeclarationError, FunctionError
from lamella.roles import Floats
from lamella.state import State

if TYPE_CHECKING:
    import xarray

    from lamella.body.sample import PlateSample
    from lamella.model import Model


class Cause(enum.Enum):
    """Why a solution ended."""

    COMPLETED = "completed"
    EVENT = "an event ended the run"
    NOT_CONVERGED = "Newton's iteration did not converge at the smallest step allowed"
    NOT_FINITE = "a force or coordinate is not a finite number"
    INACCURATE = "the local error exceeds its tolerance at the smallest step allowed"
    SINGULAR = "the system matrix is singular"
    STEP_LIMIT = "the largest number of steps was reached"
    INTERRUPTED = "interrupted by the user"
    WRITE_FAILED = "the result file cannot be written"
    FUNCTION_FAILED = "a function of the model failed"


@dataclass(frozen=True)
class Happening:
    """An event that happened.

    Args:
        t: when [s].
        name: name of the event or latch.
        text: what happened.
    """

    t: float
    name: str
    text: str

    def __str__(self) -> str:
        return f"{self.t:.6g} s: {self.name}: {self.text}"


@dataclass(frozen=True)
class Start:
    """What had to be changed in the initial state so that it obeys supports and joints.

    Args:
        displacement: largest change of a position [m].
        turn: largest change of a direction, a slope or an axis [rad].
        velocity: largest change of the velocity of a position [m/s].
        spin: largest change of the rate of a direction [rad/s].
        where: what changed by these four, in words; empty where the change is rounding.
        left_out: what was left out as redundant, and notes on the system such as edges that cannot grow, in words.
    """

    displacement: float = 0.0
    turn: float = 0.0
    velocity: float = 0.0
    spin: float = 0.0
    where: tuple[str, str, str, str] = ("", "", "", "")
    left_out: tuple[str, ...] = ()

    @property
    def notes(self) -> tuple[str, ...]:
        """What the user should know, in sentences; empty when the state was consistent as given."""
        numbers = (self.displacement, self.turn, self.velocity, self.spin)
        units = ("m", "rad", "m/s", "rad/s")
        said = [f"{x:.2g} {unit} ({place})" if place else "" for x, unit, place in zip(numbers, units, self.where, strict=True)]
        found = []
        for kind, parts in (("positions", said[:2]), ("velocities", said[2:])):
            if any(parts):
                changes = " and ".join(part for part in parts if part)
                found.append(f"the initial {kind} were changed to obey supports and joints, by up to {changes}")
        return (*found, *self.left_out)


@dataclass(frozen=True)
class Outcome:
    """How a solution ended, with its numbers.

    Args:
        cause: why it ended.
        reached: last time [s] or load factor solved for.
        target: time or load factor asked for.
        detail: a sentence with numbers; on completion empty, or a warning.
        events: what happened on the way, in time order.
        start: what was changed in the initial state.
        critical_points: where the stiffness became singular, in the order met; in statics.
        error: of the function that failed.
        final: the last state, with what it remembers.
    """

    cause: Cause
    reached: float
    target: float
    detail: str = ""
    events: tuple[Happening, ...] = ()
    start: Start = Start()
    critical_points: tuple[CriticalPoint, ...] = ()
    error: FunctionError | None = field(default=None, compare=False)
    final: State | None = field(default=None, compare=False, repr=False)

    @property
    def completed(self) -> bool:
        """Whether it went as far as it should: to its end, or to an event that ends it."""
        return self.cause in (Cause.COMPLETED, Cause.EVENT)

    def __str__(self) -> str:
        if self.completed:
            return f"completed at {self.reached:g}" + (f" ({self.detail})" if self.detail else "")
        of = f" of {self.target:g}" if self.target == self.target else ""  # a path to a displacement has no load factor to reach
        return f"stopped at {self.reached:g}{of}: {self.cause.value}" + (f" ({self.detail})" if self.detail else "")


STEPS_OF_ORDER = "steps_of_order_"
"""Begin of the name of the count of steps with one order."""


@dataclass
class Statistics:
    """Counts of the work done; none but the times depends on the machine."""

    steps: int = 0
    rejected: int = 0
    newton_iterations: int = 0
    residuals: int = 0
    tangents: int = 0
    factorisations: int = 0
    solves: int = 0
    negative_pivots: int = 0
    """Negative eigenvalues of the stiffness at a static solution: above 0 the equilibrium is unstable."""
    steps_of_order: dict[int, int] = field(default_factory=dict)
    """Steps taken with each order of a method whose order varies."""
    seconds_compile: float = 0.0
    seconds_run: float = 0.0

    def as_dict(self) -> dict[str, float]:
        """All counts, with one for each order."""
        counts = asdict(self)
        orders = counts.pop("steps_of_order")
        return counts | {f"{STEPS_OF_ORDER}{order}": orders[order] for order in sorted(orders)}


class Sink(Protocol):
    """Receives a solution while it runs, for example a result file or a progress bar."""

    def sample(self, at: float, values: Sequence[Floats]) -> None:
        """One sample of all signals, in the order of ``Recorder.signals``."""
        ...

    def frame(self, at: float, state: State) -> None:
        """One frame of all coordinates."""
        ...

    def close(self, outcome: Outcome, statistics: Statistics) -> None:
        """The solution has ended; called exactly once, whatever the cause."""
        ...


@dataclass
class Recorder:
    """Samples the signals of a model and keeps frames of its motion.

    Args:
        signals: what to sample.
        axis: ``time`` [s], ``load_factor``, or ``path`` (number of the point on an equilibrium path).
        frames: number of equally spaced frames kept over the whole solution.
        sinks: receive every sample and frame at once.

    Attributes:
        values: of each sample all components of all signals, side by side, shape (n_components,).
    """

    signals: Sequence[Signal]
    axis: str
    start: float
    end: float
    frames: int = 100
    sinks: Sequence[Sink] = ()
    at: list[float] = field(default_factory=list)
    values: list[Floats] = field(default_factory=list)
    frame_at: list[float] = field(default_factory=list)
    frame_q: list[Floats] = field(default_factory=list)
    frame_v: list[Floats] = field(default_factory=list)

    def __post_init__(self) -> None:
        ends = np.cumsum([0, *(max(len(signal.labels), 1) for signal in self.signals)]).tolist()
        self._parts, self._width = [slice(*pair) for pair in pairwise(ends)], ends[-1]
        # A single number goes to a place of its own, for which a slice takes four times as long.
        places = [part if signal.labels else part.start for signal, part in zip(self.signals, self._parts, strict=True)]
        self._evaluated = [(signal.evaluate, place) for signal, place in zip(self.signals, places, strict=True)]

    def sample(self, at: float, state: State) -> None:
        """Record ``state`` at axis value ``at``."""
        row = np.empty(self._width)
        for evaluate, place in self._evaluated:
            row[place] = evaluate(state)
        self.at.append(at)
        self.values.append(row)
        if self.sinks:
            values = [row[part] for part in self._parts]
            for sink in self.sinks:
                sink.sample(at, values)
        spacing = (self.end - self.start) / max(self.frames, 1)
        due = self.start + len(self.frame_at) * spacing
        if not self.frame_at or (self.axis != "time") or at >= due - 1e-9 * abs(spacing):
            self._keep(at, state)

    def finish(self, at: float, state: State) -> None:
        """Keep the last state as a frame: a run that ends early ends between two."""
        if self.frame_at and self.frame_at[-1] < at:
            self._keep(at, state)

    def _keep(self, at: float, state: State) -> None:
        self.frame_at.append(at)
        self.frame_q.append(state.q.copy())
        self.frame_v.append(state.v.copy())
        for sink in self.sinks:
            sink.frame(at, state)

    def samples(self) -> dict[str, Floats]:
        """All samples of each signal by its name, shape (n, n_label), with one column where it has no labels."""
        rows = np.array(self.values).reshape(len(self.values), self._width)
        return {signal.name: rows[:, part].copy() for signal, part in zip(self.signals, self._parts, strict=True)}

    def pass_over(self, state: State) -> None:
        """Take note of a state that is not recorded, where signals are summed over all."""
        for signal in self.signals:
            if signal.cumulative:
                signal.evaluate(state)

    def close(self, outcome: Outcome, statistics: Statistics) -> None:
        """Tell every sink that the solution has ended."""
        for sink in self.sinks:
            sink.close(outcome, statistics)


class Result:
    """Recorded signals, frames, statistics and outcome of one solution.

    ``result["tip.position"]`` is a labelled array (xarray) with the unit in its attributes. A static solution
    (``axis == "load_factor"``) returns the last state's value; :meth:`history` gives it over all load steps.

    Args:
        model: the compiled model that was solved.
        recorder: what was recorded.
        final: the last state.
        outcome: how it ended.
        statistics: the work done.
    """

    def __init__(self, model: Model, recorder: Recorder, final: State, outcome: Outcome, statistics: Statistics) -> None:
        self.model, self.final, self.outcome, self.statistics = model, final, outcome, statistics
        self.axis = recorder.axis
        self.at = np.asarray(recorder.at)
        self.signals = {signal.name: signal for signal in recorder.signals}
        self.frame_at = np.asarray(recorder.frame_at)
        self.frame_q, self.frame_v = np.asarray(recorder.frame_q), np.asarray(recorder.frame_v)
        self._values = recorder.samples()

    @property
    def events(self) -> tuple[Happening, ...]:
        """What happened on the way, each with ``t`` [s], ``name`` and ``text``, in time order."""
        return self.outcome.events

    @property
    def critical_points(self) -> tuple[CriticalPoint, ...]:
        """Where the stiffness became singular on the way, in the order met; found in statics."""
        return self.outcome.critical_points

    @property
    def imperfection(self) -> Floats | None:
        """What was added to the stress-free geometry, shape (n_q,); None when it was perfect."""
        return self.model.imperfection

    @property
    def start(self) -> Start:
        """What was changed in the initial state so that it obeys supports and joints."""
        return self.outcome.start

    def __contains__(self, name: str) -> bool:
        return name in self.signals

    def __getitem__(self, name: str) -> xarray.DataArray:
        history = self.history(name)
        return history[-1] if self.axis == "load_factor" else history

    def samples(self, name: str) -> Floats:
        """The values of :meth:`history` alone, shape (n,), or (n, n_label) where the signal has labels."""
        if not isinstance(name, str) or name not in self.signals:
            raise DeclarationError("result", f"no signal '{name}'", f"recorded are {', '.join(self.signals)}")
        return self._values[name] if self.signals[name].labels else self._values[name][:, 0]

    def history(self, name: str) -> xarray.DataArray:
        """A signal over time, or over all load steps."""
        import xarray  # imported late, as it takes half a second

        values = self.samples(name)
        signal, dims, coords = self.signals[name], [self.axis], {self.axis: self.at}
        if signal.labels:
            dims.append("component")
            coords["component"] = np.asarray(signal.labels)
        attributes = {"units": signal.unit, "long_name": signal.description or name}
        array = xarray.DataArray(values, dims=dims, coords=coords, name=name, attrs=attributes)
        array[self.axis].attrs["units"] = "s" if self.axis == "time" else "1"
        return array

    @accepts(name=TEXT, frame=optional(WHOLE), per_element=WHOLE)
    def plate(self, name: str, frame: int | None = None, per_element: int = 4) -> PlateSample:
        """Positions, normals, strains and stresses of a plate on a grid of points.

        Args:
            name: the plate's name.
            frame: number of a kept frame; the last state when left out.
            per_element: grid intervals along each side of an element.
        """
        meshes = {mesh.name: mesh for mesh in self.model.plates}
        if name not in meshes:
            raise DeclarationError("result", f"no plate '{name}'", f"accepted is {', '.join(meshes)}")
        if frame is not None and not -len(self.frame_q) <= frame < len(self.frame_q):
            raise DeclarationError(
                "result", f"frame = {frame}", f"accepted is 0 to {len(self.frame_q) - 1}, or None for the last state"
            )
        if per_element < 1:
            raise DeclarationError("result", f"per_element = {per_element}", "accepted is a number of intervals, 1 or more")
        return meshes[name].sample(self.final.q if frame is None else self.frame_q[frame], per_element)

    def save(self, path: str | Path) -> Path:
        """Write everything to one HDF5 file; an existing file is replaced only when the new one is whole."""
        from lamella.io.results import write_result

        return write_result(self, path)
