"""A motion that is advanced from outside, as a co-simulation does."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from hashlib import sha256
from typing import Any

import numpy as np

from lamella.accepted import SOLVER, STATE, SYSTEM
from lamella.arguments import NAMED, NAMES, REAL, TEXT, accepts, instance
from lamella.assembly.equations import Equations
from lamella.errors import ConvergenceError, DeclarationError, ModelError
from lamella.integrate.base import Integrator
from lamella.linear.inputs import Inputs
from lamella.linear.outputs import components
from lamella.model import Model
from lamella.motion import March, consistent_start, refuse_spin
from lamella.result import Cause, Happening, Outcome, Recorder, Statistics
from lamella.roles import Floats
from lamella.signals import system_signals
from lamella.solve.linear import Method, linear_solver
from lamella.state import State
from lamella.stepping.inputs import ITEM, Input, refuse_jumps, with_inputs
from lamella.stepping.saved import decoded, encoded
from lamella.system import System
from lamella.units import LARGEST

CLOSE = 1e-9
"""Share of the integrator's step within which two times are the same."""
SHORTEST = 1e-30
"""Shortest communication step [s]; powers of its inverse are computed with."""
SUMMED = ("energy.", "work.")
"""Signals of which the energy balance is the sum."""


@dataclass
class _Follower(Recorder):
    """Keeps nothing, but lets signals that depend on the way see every state."""

    def sample(self, at: float, state: State) -> None:
        self.at = [at]
        self.pass_over(state)


class Stepping:
    """A motion with inputs that are held and outputs that are asked for between its steps.

    A communication step of :meth:`advance` takes as many steps of the integrator as it needs. An input that is set acts from the
    present time on and is held until it is set again; where it jumps, velocities go on and accelerations jump with it, and
    otherwise the integrator goes on as in :func:`~lamella.motion.simulate`. Each communication step begins with a new
    factorisation, so that what comes next depends on the saved state alone, to the bit.

    Args:
        system: the system, or a model compiled from one.
        integrator: for example ``GeneralizedAlpha(dt=1e-3)``.
        inputs: loads, drives and supports that follow a function of time, named as in :func:`~lamella.linear.model.linearise`;
            each begins with the value of that function at the start, and that is replaced. Of what moves a place the
            acceleration is the input, ``drive.acceleration``.
        outputs: recorded signals, or components such as ``tip.position.z``, that :attr:`outputs` gives.
        t_start: time at the start [s].
        initial: state to start from; the reference configuration when left out.
        solver: name of the linear solver, see :func:`lamella.solve.linear.linear_solver`.

    Attributes:
        units: of inputs and outputs, by name.
        descriptions: of inputs and outputs, by name.
        start: what had to be changed in the initial state.
        ended: the outcome when an event has ended the motion, else None.

    Raises:
        DeclarationError: an input or output does not exist, is given twice, or would make a place jump.
        ModelError: joints lock the system, or it is described in a frame that spins.
    """

    @accepts(
        system=SYSTEM,
        integrator=instance("an integrator such as GeneralizedAlpha(dt=1e-3)", Integrator),
        inputs=NAMED,
        outputs=NAMES,
        t_start=REAL,
        initial=STATE,
        solver=SOLVER,
    )
    def __init__(
        self,
        system: System | Model,
        integrator: Integrator,
        *,
        inputs: Inputs = (),
        outputs: Sequence[str] = (),
        t_start: float = 0.0,
        initial: State | None = None,
        solver: Method = "auto",
    ) -> None:
        whole = system.compile() if isinstance(system, System) else system
        refuse_spin(whole, ITEM)
        self.model, held = with_inputs(whole, inputs, t_start)
        self._inputs: dict[str, Input] = {item.name: item for item in held}
        self._at_start = {item.name: item.held.memory() for item in held}
        self._integrator, self._t_start, self._initial = integrator, t_start, initial
        self._solver: Method = solver
        self._equations = Equations(self.model)
        self._linear = linear_solver(self._equations.matrix.pattern, solver)
        refuse_jumps(self._equations, held, t_start)
        self.reset()
        self._outputs: dict[str, tuple[str, int]] = {}
        self.units = {item.name: item.unit for item in held}
        self.descriptions = {item.name: item.of for item in held}
        for name in outputs:
            for signal, number in components(ITEM, name, self._known):
                label = f"{signal.name}.{signal.labels[number]}" if signal.labels else signal.name
                if label in self.units:
                    raise DeclarationError(ITEM, f"the output '{label}' is given twice, or is an input", "accepted is each once")
                self._outputs[label] = signal.name, number
                self.units[label] = signal.unit
                component = f", {signal.labels[number]}" if signal.labels else ""
                self.descriptions[label] = f"{signal.description}{component}"

    def reset(self) -> None:
        """Go back to the start, inputs as well."""
        for name, item in self._inputs.items():
            item.held.recall(self._at_start[name])
        self._wanted = {name: item.start for name, item in self._inputs.items()}
        self.model.begin(self._initial)
        self._equations.forget()
        point, self.start = consistent_start(self._equations, self._linear, self._t_start, self._initial)
        self._signals = system_signals(self._equations)
        self._known = {signal.name: signal for signal in self._signals}
        self.statistics = Statistics()
        follower = _Follower(self._signals, "time", self._t_start, np.inf, at=[self._t_start])
        self._march = March(
            self._equations, self._integrator, follower, self.statistics, np.inf, self._linear, self._solver, stride=1
        )
        self._march.begin(point)
        self._remembering = [part for signal in self._signals for part in signal.history]
        self.ended: Outcome | None = None
        for signal in self._signals:  # all that count from the first state begin here
            signal.evaluate(self._march.state)
        self._march.control(None)

    @property
    def t(self) -> float:
        """The present time [s]."""
        return self._march.t

    @property
    def state(self) -> State:
        """The present state, with the inputs that are set."""
        self._take()
        return self.model.remembering(self._march.state)

    @property
    def inputs(self) -> dict[str, float]:
        """All inputs as they are set."""
        return dict(self._wanted)

    @property
    def outputs(self) -> dict[str, float]:
        """All outputs at the present time."""
        return {label: float(np.atleast_1d(self.get(name))[number]) for label, (name, number) in self._outputs.items()}

    @property
    def events(self) -> list[Happening]:
        """What happened so far."""
        return list(self._march.watch.happened)

    @accepts(name=TEXT, value=REAL)
    def set(self, name: str, value: float) -> None:
        """Set an input, which acts from the present time on.

        Raises:
            DeclarationError: there is no such input, or the value is no number that can be computed with.
        """
        if name not in self._wanted:
            raise DeclarationError(ITEM, f"there is no input '{name}'", f"there are: {', '.join(self._wanted) or 'none'}")
        refuse_unusable(ITEM, name, value)
        self._wanted[name] = float(value)

    @accepts(name=TEXT)
    def get(self, name: str) -> float | Floats:
        """A recorded signal at the present time, or one of its components.

        Raises:
            DeclarationError: there is no such signal; those recorded are listed.
        """
        found = components(ITEM, name, self._known)
        signal = found[0][0]
        self._take()
        if signal.name == "energy.balance":
            for part in self._signals:
                if part.name.startswith(SUMMED):
                    part.evaluate(self._march.state)
        value = np.array(signal.evaluate(self._march.state), float)
        return float(np.atleast_1d(value)[found[0][1]]) if name != signal.name or not signal.labels else value

    @accepts(dt=REAL)
    def advance(self, dt: float) -> Outcome:
        """Advance by a communication step of dt [s]; see :meth:`advance_to`."""
        if not dt > 0.0:
            raise DeclarationError(ITEM, f"a communication step of {dt} s", "accepted is a positive number")
        return self.advance_to(self.t + dt)

    @accepts(t=REAL)
    def advance_to(self, t: float) -> Outcome:
        """Advance to the time t [s].

        Returns:
            The outcome: completed, at the time asked for, or before it when an event ends the motion.

        Raises:
            ConvergenceError: the smallest step did not converge; the motion stands at the last step that did.
            ModelError: an event has ended the motion before.
        """
        march = self._march
        if self.ended is not None:
            raise ModelError(
                f"{ITEM}: an event has ended the motion at {self.ended.reached:g} s ({self.ended.detail}); reset() it"
            )
        if not np.isfinite(t) or t <= march.t:
            raise DeclarationError(ITEM, f"advance to {t} s", f"accepted is a time later than the present one, {march.t:g} s")
        if t - march.t < SHORTEST:
            raise DeclarationError(
                ITEM, f"a communication step of {t - march.t:g} s", f"accepted is one of {SHORTEST:g} s or more"
            )
        self._take()
        march.stepper.forget()
        march.t_end = t
        close = CLOSE * min(self._integrator.dt, t - self._t_start)
        while march.t < t - close:
            stops = [s for s in self.model.breakpoints if march.t < s <= t + close]
            jump = stops[0] if stops else np.inf
            stop = min(jump, march.sampling.next(march.t, jump, t), t)
            if abs(jump - stop) <= close:
                stop = jump
            before = march.t
            failure = march.advance(stop, stop == jump)
            if failure is not None and failure.cause is Cause.EVENT:
                self.ended = failure
                return failure
            if failure is not None:
                raise ConvergenceError(f"the motion {failure}", failure)
            if stop == jump:
                self._equations.forget()
                march.restart()
            march.control(before)
        return Outcome(Cause.COMPLETED, march.t, t, events=tuple(march.watch.happened))

    def save(self) -> bytes:
        """All that the rest of the motion depends on; the same system with the same integrator goes on from it to the bit."""
        self._take()
        march = self._march
        memory = {
            "of": self._fingerprint(),
            "t": march.t,
            "dt": march.dt,
            "state": march.state,
            "ended": None if self.ended is None else (self.ended.reached, self.ended.target, self.ended.detail),
            "inputs": {name: item.held.memory() for name, item in self._inputs.items()},
            "wanted": dict(self._wanted),
            "blocks": [block.memory() for block in self._blocks()],
            "stepper": march.stepper.memory(),
            "watch": march.watch.memory(),
            "signals": [part.memory() for part in self._remembering],
        }
        return encoded(memory)

    def restore(self, saved: bytes) -> None:
        """Go back, or on, to a state that was saved.

        Raises:
            DeclarationError: these are no bytes of :meth:`save`, or those of another system, integrator or version.
        """
        accepted = "accepted is what save() gave"
        try:
            memory: dict[str, Any] = decoded(saved)
            of = memory["of"]
        except (ValueError, KeyError, TypeError) as error:
            raise DeclarationError(ITEM, "what is to be restored is no saved state", accepted) from error
        if of != self._fingerprint():
            raise DeclarationError(ITEM, "the saved state is that of another system, integrator or inputs", accepted)
        march = self._march
        march.t, march.dt, march.state = memory["t"], memory["dt"], memory["state"]
        ended = memory["ended"]
        self.ended = None if ended is None else Outcome(Cause.EVENT, *ended)
        for name, item in self._inputs.items():
            item.held.recall(memory["inputs"][name])
        self._wanted = memory["wanted"]
        for part, found in zip(self._blocks(), memory["blocks"], strict=True):
            part.recall(found)
        for part, found in zip(self._remembering, memory["signals"], strict=True):
            part.recall(found)
        march.watch.recall(memory["watch"])
        self._equations.forget()
        march.stepper.recall(memory["stepper"])

    def _blocks(self) -> list[Any]:
        """Everything in the model that has a memory."""
        model = self.model
        return [*model.forces, *model.loads, *model.constraints, *model.samplers]

    def _take(self) -> None:
        """Let inputs that were set act."""
        changed = [item for name, item in self._inputs.items() if item.held.now != self._wanted[name]]

        def hold() -> None:
            for item in changed:
                item.held.hold(self.t, self._wanted[item.name])
            self._equations.forget()

        if changed:
            self._march.jump(hold)

    def _fingerprint(self) -> str:
        """What a saved state must have in common with the run that takes it."""
        model = self.model
        parts = (repr(self._integrator), model.n_q, model.n_lam, list(self._inputs), [signal.name for signal in self._signals])
        return sha256(repr(parts).encode()).hexdigest()


def refuse_unusable(item: str, name: str, value: float) -> None:
    """Refuse a value of an input that is no number that can be computed with; ``item`` is who is asked.

    Raises:
        DeclarationError: it is none.
    """
    if not abs(value) <= LARGEST[""]:
        raise DeclarationError(item, f"the input '{name}' is set to {value}", f"accepted is a number of up to {LARGEST['']:g}")
