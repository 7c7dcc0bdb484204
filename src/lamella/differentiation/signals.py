"""Derivatives of recorded signals, from those of the solution."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from lamella._jit import kernel
from lamella.assembly.equations import Equations
from lamella.assembly.point import Point
from lamella.assembly.point_state import OF_POINT
from lamella.differentiation.alike import alike
from lamella.differentiation.neighbours import Neighbours
from lamella.differentiation.reactions import Reactions
from lamella.differentiation.solution import PointDerivative
from lamella.dofs import Signal
from lamella.roles import Floats
from lamella.signals import LOAD_FACTOR, system_signals
from lamella.state import PARTS, LateState, State


class SignalDerivatives:
    """Some signals along a solution, with their derivatives by each parameter.

    The derivative of y(state(p), p) has two parts: a central difference of signals between the neighbours with the unknowns as
    they are, where their signals differ, and the derivative along the change of the state, which signals tell themselves or which
    is a central difference as well. They are at most quadratic in velocities and forces, and most are in positions: there
    differences are exact up to rounding. Differences of reactions and of the potential of all forces would lose digits: the parts
    of the residual tell their derivatives where they can. That of a reaction then belongs to the change of the state, and
    neighbours have the reaction of the model in the middle.

    Args:
        equations: of the model.
        neighbours: of each parameter.
        names: of the signals.

    Attributes:
        at: time or load factor of each sample.
        values: of each signal by name, a list with an entry (n_component,) for each sample.
        derivatives: the same, with entries (n_parameter, n_component).
    """

    def __init__(self, equations: Equations, neighbours: Sequence[Neighbours], names: Sequence[str]) -> None:
        self.equations, self.neighbours = equations, neighbours
        self._own = _chosen(equations, names)
        held = tuple(f"{support.name}." for support in equations.model.supports)
        self._reactions = Reactions(equations) if any(name.startswith(held) for name in names) else None
        self._per_size = 1.0 / equations.model.magnitude
        self._beside = [_Beside(equations, each, self._own, self._reactions is not None) for each in neighbours]
        self._recorded = bool(names)
        self.at: list[float] = []
        self.values: dict[str, list[Floats]] = {name: [] for name in names}
        self.derivatives: dict[str, list[Floats]] = {name: [] for name in names}

    def labels(self, name: str) -> tuple[str, ...]:
        """Names of a signal's components."""
        return self._own[name].labels

    def sample(self, point: Point, derivatives: Sequence[PointDerivative]) -> None:
        """Take note of a point of the solution."""
        if not self._recorded:
            return
        state = self.equations.late_state(point)
        if self._reactions is not None:
            self._reactions.look(point, state)
        here = {name: _value(signal, state) for name, signal in self._own.items()}
        found: dict[str, list[Floats]] = {name: [] for name in self._own}
        for beside, known in zip(self._beside, derivatives, strict=True):
            each = beside.neighbours
            change = self._change(each, state, known)
            ends, shares = self._along(each, state, change) if beside.bends else ((), ())
            for name, signal in self._own.items():
                if each.following and signal.potential:
                    found[name].append(np.array([each.following.energy(point, known.u)]))
                elif signal.derivative:
                    found[name].append(np.atleast_1d(signal.derivative(state, change)))
                else:
                    found[name].append(_weighed(here[name], shares, [signal] * len(ends), ends))
            if beside.differ:
                sides = [
                    state if same else _state_of(side.equations, point, None if beside.react else state)
                    for side, same in zip(each.sides, beside.same, strict=True)
                ]
                weights = [side.weight for side in each.sides]
                for name in beside.differ:
                    found[name][-1] += _weighed(here[name], weights, [one[name] for one in beside.signals], sides)
        self.at.append(point.t if not point.at_rest else point.factor)
        for name, value in here.items():
            self.values[name].append(value)
            self.derivatives[name].append(np.array(found[name]).reshape(len(derivatives), -1))

    def _change(self, each: Neighbours, state: State, known: PointDerivative) -> State:
        """Derivative of the state."""
        return LateState(state.t, state.factor, _OF_CHANGE, (self.equations, known, each, self._reactions))

    def _along(self, each: Neighbours, state: State, change: State) -> tuple[Sequence[State], Sequence[float]]:
        """States along a change, of a small share of the bodies' size, and their weights in a derivative."""
        share, rule = each.rule
        moved = _largest(change.q, self._per_size)
        if moved > 0.0:
            step = share / moved
        else:
            fastest = max(np.abs(part).max(initial=0.0) for part in (change.v, change.a, change.lam, change.reaction))
            step = 1.0 / fastest if fastest > 0.0 else 1.0
        ends = [LateState(state.t, state.factor, _OF_MOVED, (state, place * step, change)) for place, _ in rule]
        return ends, [weight / step for _, weight in rule]


class _Beside:
    """Signals of the models beside a parameter.

    Args:
        equations: of the model in the middle.
        neighbours: of the parameter.
        own: the signals in the middle.
        reacting: whether reactions are asked for.

    Attributes:
        signals: the same signals, of each neighbour by name.
        react: whether reactions are differenced between the neighbours.
        bends: whether signals are differenced along the change of the state.
        same: whether the state of each neighbour is that in the middle.
        differ: names of the signals whose differences between the neighbours belong to their derivatives.
    """

    def __init__(self, equations: Equations, neighbours: Neighbours, own: dict[str, Signal], reacting: bool) -> None:
        self.neighbours = neighbours
        self.signals = [_chosen(side.equations, [*own]) for side in neighbours.sides]
        self.react = reacting and neighbours.parts is None
        self.same = [not self.react and side.equations.same_coordinates(equations) for side in neighbours.sides]
        asked = [name for name, signal in own.items() if not (neighbours.following and signal.potential)]
        self.bends = not all(own[name].derivative for name in asked)
        potential_differs = not all(self.same) or neighbours.parts is None or neighbours.parts.forces_differ

        def differs(name: str) -> bool:
            if own[name].potential:
                return potential_differs
            return not all(self.same) or not _alike([one[name] for one in self.signals])

        self.differ = [name for name in asked if differs(name)]


_OF_SIDE = {**OF_POINT, "reaction": lambda state: state.of[2].reaction}
"""Parts of the state of a side, with the reaction of the model in the middle."""


def _state_of(side: Equations, point: Point, reacting: State | None) -> State:
    """The state of a side, with its own reaction or that of another state."""
    if reacting is None:
        return side.late_state(point)
    return LateState(point.t, point.factor, _OF_SIDE, (side, point, reacting))


def _part_of_moved(name: str) -> Callable[[LateState], Floats]:
    def made(moved: LateState) -> Floats:
        state, distance, change = moved.of
        return getattr(state, name) + distance * getattr(change, name)

    return made


_OF_MOVED = {name: _part_of_moved(name) for name in PARTS}
"""Parts of a state at a distance along a change."""


def _reaction_of_change(change: LateState) -> Floats:
    equations, known, each, reactions = change.of
    return np.zeros(equations.model.n_q) if reactions is None else reactions.change(each, known, change)


_OF_CHANGE: dict[str, Callable[[LateState], Floats]] = {
    "q": lambda change: change.of[0].expand(change.of[1].u),
    "v": lambda change: change.of[0].expand(change.of[1].ud),
    "a": lambda change: change.of[0].expand(change.of[1].udd),
    "lam": lambda change: change.of[0].constraints.full(change.of[1].lam),
    "reaction": _reaction_of_change,
}
"""Parts of the derivative of a state, of the unknowns alone; of a reaction all, where parts of the residual tell it."""


@kernel
def _largest(x: Floats, per_size: Floats) -> float:
    """The largest entry, relative to sizes; not a number when one is none."""
    largest = 0.0
    for i in range(len(x)):
        one = abs(x[i] * per_size[i])
        if not one <= largest:
            largest = one
    return largest


def _chosen(equations: Equations, names: Sequence[str]) -> dict[str, Signal]:
    known = {signal.name: signal for signal in (LOAD_FACTOR, *equations.model.signals)}
    if not known.keys() >= set(names):
        known |= {signal.name: signal for signal in system_signals(equations)}
    return {name: known[name] for name in names}


def _alike(signals: Sequence[Signal]) -> bool:
    first, *others = (signal.evaluate for signal in signals)
    return all(alike(first, other) for other in others)


def _value(signal: Signal, state: State) -> Floats:
    return np.atleast_1d(np.asarray(signal.evaluate(state), float))


def _weighed(here: Floats, weights: Sequence[float], signals: Sequence[Signal], states: Sequence[State]) -> Floats:
    """Sum of weights, which are zero together, times changes of a signal from its value here."""
    total = np.zeros_like(here)
    for weight, signal, state in zip(weights, signals, states, strict=True):
        change = _value(signal, state) - here
        if signal.unit == "rad":  # an angle at the end of its range
            change -= 2.0 * np.pi * np.round(change / (2.0 * np.pi))
        total += weight * change
    return total
