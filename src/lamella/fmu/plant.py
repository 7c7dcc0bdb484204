"""What a unit carries in its resources, and the motion it makes of it where it is run."""

from __future__ import annotations

import base64
import json
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np

from lamella.errors import DeclarationError, ModelError
from lamella.io.analysis import Motion
from lamella.io.model_file import loads
from lamella.state import State
from lamella.stepping.run import Stepping, refuse_unusable
from lamella.stepping.saved import decoded, encoded

MODEL, INTERFACE, START = "model.yaml", "interface.json", "start.npz"
"""Files in the resources."""
ARRAYS = ("q", "v", "a", "lam", "reaction")
MEMORY = "memory"
"""Of the state at the start, in its file: its arrays, and what it remembers besides."""
APART = 1e-6
"""Share of a communication step by which its beginning may be off the present time: a master sums its steps."""


@dataclass(frozen=True)
class Variable:
    """An input or output.

    Args:
        name: its name.
        unit: its unit, ``1`` for a pure number.
        description: what it is, in words.
        start: value at the start.
    """

    name: str
    unit: str
    description: str
    start: float


@dataclass(frozen=True)
class Interface:
    """What a unit shows of its model.

    Args:
        name: name of the model, an identifier.
        description: title of the model.
        motion: name of the analysis with the integrator.
        step: communication step that is proposed [s].
        t_start, t_end: times of the motion [s].
        channels: what each input stands for, by the input's name.
        inputs, outputs: the variables.
    """

    name: str
    description: str
    motion: str
    step: float
    t_start: float
    t_end: float
    channels: dict[str, str]
    inputs: tuple[Variable, ...]
    outputs: tuple[Variable, ...]


class Plant:
    """The model of a unit at work.

    Inputs may be set at any time; they act from the present time on. Before :meth:`begin` there are only the values of the start.

    Args:
        resources: folder of the resources.
        interface: what it shows; read from the resources when left out.

    Raises:
        ModelError: the interface among the resources is missing or damaged.
    """

    def __init__(self, resources: str | Path, interface: Interface | None = None) -> None:
        self._folder = Path(resources)
        self.interface = interface or read_interface(self._folder)
        self._set = {item.name: item.start for item in self.interface.inputs}
        self._start = {item.name: item.start for item in self.interface.outputs}
        self._stepping: Stepping | None = None

    def begin(self, t: float) -> None:
        """Compile the model and start its motion at the time t [s]."""
        self._stepping = stepping(self._folder, self.interface, t)
        for name, value in self._set.items():
            self._stepping.set(name, value)

    def input(self, name: str) -> float:
        """An input as it is set."""
        return self._set[name]

    def set(self, name: str, value: float) -> None:
        """Set an input.

        Raises:
            DeclarationError: the variable is none, or the value is not finite, or too large.
        """
        if name not in self._set:
            inputs = ", ".join(self._set) or "it has none"
            raise DeclarationError(f"FMU '{self.interface.name}'", f"'{name}' is set", f"accepted is an input: {inputs}")
        refuse_unusable(f"FMU '{self.interface.name}'", name, value)
        if self._stepping is not None:
            self._stepping.set(name, value)
        self._set[name] = value

    def output(self, name: str) -> float:
        """An output at the present time."""
        return self._start[name] if self._stepping is None else float(self._stepping.get(name))

    @property
    def moves(self) -> bool:
        """Whether there is a motion yet."""
        return self._stepping is not None

    @property
    def t(self) -> float:
        """The present time [s]."""
        return self._running().t

    def advance(self, t: float, dt: float) -> bool:
        """Advance by a communication step dt from the time t [s]; False when an event has ended the motion before its end.

        Raises:
            DeclarationError: there is no motion yet, or the step begins at another time than the present one.
        """
        run = self._running()
        if run.ended is None and abs(t - run.t) > APART * abs(dt):
            raise DeclarationError(
                f"FMU '{self.interface.name}'",
                f"a step of {dt:g} s from {t:g} s",
                f"accepted is one from the present time, {run.t:g} s",
            )
        return run.advance_to(t + dt).reached >= t + dt

    def save(self) -> dict[str, Any]:
        """Everything that comes next depends on, as JSON."""
        run = None if self._stepping is None else base64.b64encode(self._stepping.save()).decode()
        return {"inputs": dict(self._set), "run": run}

    def restore(self, saved: Any) -> None:
        """Take back what :meth:`save` gave.

        Raises:
            DeclarationError: it is something else, or of another unit.
        """
        accepted = "accepted is one that this unit has given"
        try:
            inputs, run = dict(saved["inputs"]), saved["run"]
            state = None if run is None else base64.b64decode(run, validate=True)
        except (KeyError, TypeError, ValueError) as error:
            raise DeclarationError(f"FMU '{self.interface.name}'", "what is restored is no state", accepted) from error
        if inputs.keys() != self._set.keys():
            raise DeclarationError(f"FMU '{self.interface.name}'", "what is restored is the state of another unit", accepted)
        motion = self._stepping
        if state is None:
            motion = None
        else:
            motion = motion or stepping(self._folder, self.interface, self.interface.t_start)
            motion.restore(state)
        self._stepping, self._set = motion, inputs

    def _running(self) -> Stepping:
        if self._stepping is None:
            raise DeclarationError(f"FMU '{self.interface.name}'", "it has not been initialised", "initialise it before a step")
        return self._stepping


def as_state(written: bytes) -> Any:
    """What :meth:`Plant.save` gave, from its JSON; None where it is none, which :meth:`Plant.restore` then tells."""
    try:
        return json.loads(written)
    except ValueError:
        return None


def stepping(folder: Path, interface: Interface, t: float) -> Stepping:
    """The motion of a unit, from the files of its resources.

    Raises:
        ModelError: a file of the resources is missing or damaged.
    """
    with _read(folder / MODEL) as path:
        text = path.read_text(encoding="utf-8")
    model = loads(text, name=interface.name)
    with _read(folder / MODEL):
        motion = {item.name: item for item in model.analyses}[interface.motion]
    assert isinstance(motion, Motion)
    imperfection = initial = None
    if motion.start is not None:
        with _read(folder / START) as path, np.load(path) as arrays:
            memory = decoded(arrays[MEMORY].tobytes()) if MEMORY in arrays else None
            initial = State(t, *(arrays[name] for name in ARRAYS), memory=memory)
            imperfection = arrays.get("imperfection")
    system = model.system.compile(imperfection)
    outputs = [item.name for item in interface.outputs]
    return Stepping(system, motion.integrator, inputs=interface.channels, outputs=outputs, t_start=t, initial=initial)


def read_interface(folder: Path) -> Interface:
    """The interface among the resources.

    Raises:
        ModelError: the file is missing or damaged.
    """
    with _read(folder / INTERFACE) as path:
        data = json.loads(path.read_text(encoding="utf-8"))
        inputs, outputs = (tuple(Variable(**item) for item in data.pop(key)) for key in ("inputs", "outputs"))
        return Interface(**data, inputs=inputs, outputs=outputs)


@contextmanager
def _read(path: Path) -> Iterator[Path]:
    """Tell of a file of the resources that cannot be read."""
    try:
        yield path
    except (OSError, EOFError, KeyError, TypeError, ValueError, BadZipFile) as error:
        why = getattr(error, "strerror", None) or "it is damaged"
        raise ModelError(f"FMU: '{path}' cannot be read: {why}; accepted is the unit as it was written") from error


def write_resources(folder: Path, interface: Interface, model: str, state: State | None, imperfection: object) -> Sequence[Path]:
    """Write the files of the resources and return them."""
    written = [folder / MODEL, folder / INTERFACE]
    written[0].write_text(model, encoding="utf-8")
    written[1].write_text(json.dumps(asdict(interface), indent=2), encoding="utf-8")
    if state is not None:
        arrays = {name: getattr(state, name) for name in ARRAYS}
        if imperfection is not None:
            arrays["imperfection"] = np.asarray(imperfection)
        if state.memory is not None:
            arrays[MEMORY] = np.frombuffer(encoded(state.memory), np.uint8)
        np.savez(folder / START, **arrays)
        written.append(folder / START)
    return written
