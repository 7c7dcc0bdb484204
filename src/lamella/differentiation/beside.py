"""Signals of the models beside a parameter, and their differences."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from lamella.assembly.equations import Equations
from lamella.assembly.point import Point
from lamella.assembly.point_state import OF_POINT
from lamella.differentiation.alike import alike
from lamella.differentiation.neighbours import Neighbours
from lamella.dofs import Signal
from lamella.roles import Floats
from lamella.signals import signals_named
from lamella.state import LateState, State


class Beside:
    """Signals of the models beside a parameter.

    Args:
        equations: of the model in the middle.
        neighbours: of the parameter.
        own: the signals in the middle.
        reacting: whether reactions are asked for.

    Attributes:
        of_potential: what tells of the potential of all forces, if that is asked for and told.
        react: whether reactions are differenced between the neighbours.
        bends: whether signals are differenced along the change of the state.
        same: whether the state of each neighbour is that in the middle.
        differ: names of the signals whose differences between the neighbours belong to their derivatives.
        stacks: whether these can be told of several states at once.
    """

    def __init__(self, equations: Equations, neighbours: Neighbours, own: dict[str, Signal], reacting: bool) -> None:
        self.neighbours = neighbours
        self._weights = [side.weight for side in neighbours.sides]
        self.react = reacting and neighbours.parts is None
        self.same = [not self.react and side.equations.same_coordinates(equations) for side in neighbours.sides]
        self.of_potential = neighbours.of_potential if any(signal.potential for signal in own.values()) else None
        asked = [name for name, signal in own.items() if not (self.of_potential and signal.potential)]
        self._signals = [signals_named(side.equations, asked) for side in neighbours.sides]
        self.bends = not all(own[name].derivative for name in asked)
        potential_differs = not all(self.same) or neighbours.parts is None or neighbours.parts.forces_differ

        def differs(name: str) -> bool:
            if own[name].potential:
                return potential_differs
            return not all(self.same) or not _alike([one[name] for one in self._signals])

        self.differ = [name for name in asked if differs(name)]
        self.stacks = all(self.same) or neighbours.parts is not None
        self._shifts = [side.equations.held - equations.held for side in neighbours.sides]

    @property
    def reactions_stack(self) -> bool:
        """Whether reactions can be told of several states at once as well."""
        parts = self.neighbours.parts
        return parts is not None and parts.reactions_stack

    def states_at(self, point: Point, state: State) -> list[State]:
        """The states of the neighbours at a point, where the middle has the given one; their reactions are its own where the
        parts of the residual tell how these differ.
        """
        return [
            state if same else _state_of(side.equations, point, None if self.react else state)
            for side, same in zip(self.neighbours.sides, self.same, strict=True)
        ]

    def states_of_stack(self, state: State) -> list[State]:
        """The same of several states side by side, where unknowns change coordinates alike in all models."""
        return [
            state if same else LateState(state.t, state.factor, _OF_SHIFTED, (state, shift))
            for same, shift in zip(self.same, self._shifts, strict=True)
        ]

    def difference(self, name: str, here: Floats, states: Sequence[State]) -> Floats:
        """The weighed sum of a signal's changes from its values ``here`` (n, n_component), to those in the neighbours' states."""
        return weighed(here, self._weights, [one[name] for one in self._signals], states)


_OF_SIDE = {**OF_POINT, "reaction": lambda state: state.of[2].reaction}
"""Parts of the state of a side, with the reaction of the model in the middle."""
_OF_SHIFTED: dict[str, Callable[[Any], Floats]] = {
    "q": lambda side: side.of[0].q + side.of[1],
    "v": lambda side: side.of[0].v,
    "a": lambda side: side.of[0].a,
    "reaction": lambda side: side.of[0].reaction,
}


def _state_of(side: Equations, point: Point, reacting: State | None) -> State:
    """The state of a side, with its own reaction or that of another state."""
    if reacting is None:
        return side.late_state(point)
    return LateState(point.t, point.factor, _OF_SIDE, (side, point, reacting))


def _alike(signals: Sequence[Signal]) -> bool:
    first, *others = (signal.evaluate for signal in signals)
    return all(alike(first, other) for other in others)


def values_of(signal: Signal, state: State, n: int = 1) -> Floats:
    """The values of a signal in n states side by side, shape (n, n_component)."""
    return np.reshape(np.asarray(signal.evaluate(state), float), (n, -1))


def weighed(here: Floats, weights: Sequence[float], signals: Sequence[Signal], states: Sequence[State]) -> Floats:
    """Sum of weights, which are zero together, times changes of a signal from its values here, (n, n_component)."""
    total = np.zeros_like(here)
    for weight, signal, state in zip(weights, signals, states, strict=True):
        change = values_of(signal, state, len(here)) - here
        if signal.unit == "rad":  # an angle at the end of its range
            change -= 2.0 * np.pi * np.round(change / (2.0 * np.pi))
        total += weight * change
    return total
