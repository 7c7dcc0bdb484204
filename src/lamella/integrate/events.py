"""Events: what happens when a function of the state passes through a value, and when exactly."""

from __future__ import annotations

import difflib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from lamella.assembly.equations import Equations
from lamella.dofs import Signal
from lamella.errors import DeclarationError
from lamella.integrate.base import StepOutcome, Stepper
from lamella.memory import Memory
from lamella.result import Happening
from lamella.state import State
from lamella.trigger import Trigger

CLOSE = 1e-6
"""Share of a step to which the time of an event is found."""


@dataclass
class _Watched:
    """A trigger at work.

    Args:
        trigger: the trigger.
        evaluate: its function.
        before: value at the last accepted state.
        open: whether it may still happen.
    """

    trigger: Trigger
    evaluate: Callable[[State], float]
    before: float = 0.0
    open: bool = True

    def crosses(self, value: float) -> bool:
        """Whether the function passed through zero, in the direction asked for, on its way to ``value``."""
        if not self.open or self.before == 0.0 or np.sign(value) == np.sign(self.before):
            return False
        return self.trigger.direction in (0, -int(np.sign(self.before)))

    def share(self, value: float) -> float:
        """Share of the step after which the function passed through zero, by linear interpolation."""
        return self.before / (self.before - value)

    def keep(self, value: float) -> None:
        """Take the value at an accepted state; a zero says nothing of the side it was reached from."""
        if value != 0.0:
            self.before = value


class EventWatch(Memory):
    """All triggers of a model during one run.

    Args:
        equations: make states from points.
        triggers: the triggers.
        signals: what is recorded; triggers name the signal they watch.

    Raises:
        DeclarationError: a trigger names a signal that is not recorded, or a component it does not have.
    """

    def __init__(self, equations: Equations, triggers: Sequence[Trigger], signals: Sequence[Signal]) -> None:
        self.equations = equations
        known = {signal.name: signal for signal in signals}
        self._watched = [_Watched(trigger, trigger.evaluate or _level(trigger, known)) for trigger in triggers]
        self.happened: list[Happening] = []

    def memory(self) -> dict[str, Any]:
        """What each trigger has seen, and what has happened."""
        return {"watched": [(item.before, item.open) for item in self._watched], "happened": list(self.happened)}

    def recall(self, memory: dict[str, Any]) -> None:
        """Take back what :meth:`memory` gave."""
        for item, seen in zip(self._watched, memory["watched"], strict=True):
            item.before, item.open = seen
        self.happened = list(memory["happened"])

    def begin(self, state: State) -> None:
        """Take the values at the start."""
        for item in self._watched:
            item.keep(item.evaluate(state))

    def locate(self, stepper: Stepper, outcome: StepOutcome, dt: float, t: float) -> tuple[StepOutcome, float, list[Trigger]]:
        """Cut a converged step short where the first event that changes something happens in it.

        The time is found by trying the step with other lengths; the step ends just behind the event. Events that are only noted
        do not cut the step; their time is interpolated.

        Returns:
            The step to accept, its length, and the triggers that act at its end.
        """
        if not self._watched or outcome.point is None:
            return outcome, dt, []
        acting = [item for item in self._crossed(outcome) if _changes(item[0].trigger)]
        if acting:
            outcome, dt = self._cut(stepper, min(acting, key=lambda item: item[0].share(item[1])), dt)
        return outcome, dt, self._accept(outcome, dt, t)

    def _cut(self, stepper: Stepper, crossed: tuple[_Watched, float], dt: float) -> tuple[StepOutcome, float]:
        """The step that ends just behind an event, by Brent's method on its length; the whole step where a trial fails."""
        from scipy.optimize import brentq  # imported late: some tenths of a second that most models never need

        item, end = crossed

        def value(length: float) -> float:
            tried = stepper.step(length)
            if tried.point is None:
                raise ArithmeticError
            return item.evaluate(self.equations.state(tried.point))

        try:
            found = brentq(lambda s: item.before if s == 0.0 else end if s == dt else value(s), 0.0, dt, xtol=0.5 * CLOSE * dt)
            inside = float(found)  # type: ignore[arg-type]  # a pair only with full_output
            length = min(inside + CLOSE * dt, dt)
            kept = stepper.step(length)
            if kept.point is not None:
                return kept, length
        except ArithmeticError:
            pass  # the event is then seen at the end of the whole step, which has converged before
        return stepper.step(dt), dt

    def _crossed(self, outcome: StepOutcome) -> list[tuple[_Watched, float]]:
        """What would happen in a step, with the values at its end."""
        return [(item, value) for item, value in zip(self._watched, self._values(outcome), strict=True) if item.crosses(value)]

    def _values(self, outcome: StepOutcome) -> list[float]:
        assert outcome.point is not None
        state = self.equations.state(outcome.point)
        return [item.evaluate(state) for item in self._watched]

    def _accept(self, outcome: StepOutcome, dt: float, t: float) -> list[Trigger]:
        """Note what happens in a step that will be accepted; returns the triggers that act at its end."""
        acting, noted = [], []
        for item, value in zip(self._watched, self._values(outcome), strict=True):
            if item.crosses(value):
                changes = _changes(item.trigger)
                share = 1.0 if changes else item.share(value)
                noted.append(Happening(t + share * dt, item.trigger.name, item.trigger.text))
                item.open = not item.trigger.once
                if changes:
                    acting.append(item.trigger)
            item.keep(value)
        self.happened += sorted(noted, key=lambda happening: happening.t)
        return acting


def _changes(trigger: Trigger) -> bool:
    return trigger.act is not None or trigger.stops


def _level(trigger: Trigger, known: Mapping[str, Signal]) -> Callable[[State], float]:
    """The signal that a trigger watches, less its level."""
    item = f"Event '{trigger.name}'"
    if trigger.watch not in known:
        near = difflib.get_close_matches(trigger.watch, known, 1, 0.5)
        meant = f"did you mean '{near[0]}'? " if near else ""
        raise DeclarationError(item, f"there is no signal '{trigger.watch}'", f"{meant}accepted are {', '.join(sorted(known))}")
    signal = known[trigger.watch]
    if (trigger.component or "") not in (signal.labels or ("",)):
        wanted = f"accepted is {', '.join(signal.labels)}" if signal.labels else "accepted is none: it is a single number"
        given = f"component = '{trigger.component}'" if trigger.component else "a component is needed"
        raise DeclarationError(item, f"{given} of '{trigger.watch}'", wanted)
    if not signal.labels:
        return lambda state: float(signal.evaluate(state)) - trigger.level
    k = signal.labels.index(trigger.component or "")
    return lambda state: float(np.asarray(signal.evaluate(state))[k]) - trigger.level
