"""Signals of what a joint leaves free: the angle about its axis and the displacement along it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from lamella.dofs import Signal
from lamella.measure.measure import MeasureSet, Term
from lamella.memory import Memory
from lamella.state import State


class TurnCounter(Memory):
    """An angle without jumps: of all values that differ by full turns, the one nearest to the last of the run."""

    remembered = ("_angle",)

    def __init__(self) -> None:
        self._angle: float | None = None

    def __call__(self, angle: float) -> float:
        if self._angle is not None:
            angle += 2.0 * np.pi * float(np.round((self._angle - angle) / (2.0 * np.pi)))
        self._angle = angle
        return angle

    def reset(self) -> None:
        self._angle = None


def angle_signals(name: str, term: Term) -> list[Signal]:
    """A joint's angle, counting turns, and its rate."""
    found, counter = MeasureSet([(term,)]), TurnCounter()

    def angle(state: State) -> float:
        found.evaluate(state.q)
        return counter(float(found.values[0]))

    return [
        Signal(f"{name}.angle", "rad", (), angle, f"angle of {name}", cumulative=True, history=(counter,)),
        Signal(f"{name}.rate", "rad/s", (), _rate(found), f"angular velocity of {name}"),
    ]


def slide_signals(name: str, term: Term) -> list[Signal]:
    """A joint's displacement along its axis, and its rate."""
    found = MeasureSet([(term,)])

    def displacement(state: State) -> float:
        found.evaluate(state.q)
        return float(found.values[0])

    return [
        Signal(f"{name}.displacement", "m", (), displacement, f"displacement of {name}"),
        Signal(f"{name}.speed", "m/s", (), _rate(found), f"speed of {name}"),
    ]


def _rate(found: MeasureSet) -> Callable[[State], float]:
    def rate(state: State) -> float:
        found.evaluate(state.q)
        return float(found.rates(state.v)[0])

    return rate
