"""Derivatives of recorded signals, from those of the solution."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from lamella._jit import kernel
from lamella.assembly.equations import Equations
from lamella.assembly.point import Point
from lamella.differentiation.beside import Beside, values_of, weighed
from lamella.differentiation.neighbours import Neighbours
from lamella.differentiation.reactions import Reactions
from lamella.differentiation.signal_stack import stack_of
from lamella.differentiation.solution import PointDerivative
from lamella.roles import Floats
from lamella.signals import signals_named
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
        many: whether samples of a motion are to be evaluated several at once where that is possible.

    Attributes:
        at: time or load factor of each sample.
        values: of each signal by name, a list with an entry (n_component,) for each sample.
        derivatives: the same, with entries (n_parameter, n_component).
    """

    def __init__(
        self, equations: Equations, neighbours: Sequence[Neighbours], names: Sequence[str], *, many: bool = False
    ) -> None:
        self.equations, self.neighbours = equations, neighbours
        self._own = signals_named(equations, names)
        held = tuple(f"{support.name}." for support in equations.model.supports)
        self._reactions = Reactions(equations) if any(name.startswith(held) for name in names) else None
        self._per_size = 1.0 / equations.model.magnitude
        self._beside = [Beside(equations, each, self._own, self._reactions is not None) for each in neighbours]
        self._stack = stack_of(equations, self._beside, self._own, self._reactions) if many else None
        self._one_by_one = {name: own for name, own in self._own.items() if not (self._stack and name in self._stack.signals)}
        self.at: list[float] = []
        self.values: dict[str, list[Floats]] = {name: [] for name in names}
        self.derivatives: dict[str, list[Floats]] = {name: [] for name in names}

    def labels(self, name: str) -> tuple[str, ...]:
        """Names of a signal's components."""
        return self._own[name].labels

    def sample(self, point: Point, derivatives: Sequence[PointDerivative]) -> None:
        """Take note of a point of the solution."""
        self.at.append(point.t if not point.at_rest else point.factor)
        if self._stack:
            self._stack.put(point, derivatives)
            if self._stack.full:
                self.finish()
        if self._one_by_one:
            self._sample(point, derivatives)

    def finish(self) -> None:
        """Evaluate samples that wait for others."""
        if self._stack and self._stack.waiting:
            for known, more in zip((self.values, self.derivatives), self._stack.evaluate(), strict=True):
                for name, rows in more.items():
                    known[name] += [*rows]

    def _sample(self, point: Point, derivatives: Sequence[PointDerivative]) -> None:
        state = self.equations.late_state(point)
        if self._reactions is not None:
            self._reactions.look(point, state)
        changes = [self._change(each, state, known) for each, known in zip(self.neighbours, derivatives, strict=True)]
        potentials = [
            beside.of_potential.potential(point.t, state, change) if beside.of_potential else None
            for beside, change in zip(self._beside, changes, strict=True)
        ]
        known = next((whole for whole, _ in filter(None, potentials)), None)
        here = {
            name: values_of(signal, state) if known is None or not signal.potential else np.array([[known]])
            for name, signal in self._one_by_one.items()
        }
        found: dict[str, list[Floats]] = {name: [] for name in here}
        for beside, change, potential in zip(self._beside, changes, potentials, strict=True):
            ends, shares = self._along(beside.neighbours, state, change) if beside.bends else ((), ())
            for name, signal in self._one_by_one.items():
                if signal.potential and potential:
                    found[name].append(np.array([[potential[1]]]))
                elif signal.derivative:
                    found[name].append(np.reshape(signal.derivative(state, change), (1, -1)))
                else:
                    found[name].append(weighed(here[name], shares, [signal] * len(ends), ends))
            differ = [name for name in beside.differ if name in here]
            if differ:
                states = beside.states_at(point, state)
                for name in differ:
                    found[name][-1] += beside.difference(name, here[name], states)
        for name, value in here.items():
            self.values[name].append(value[0])
            self.derivatives[name].append(np.concatenate(found[name]))

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


def _part_of_moved(name: str) -> Callable[[LateState], Floats]:
    def made(moved: LateState) -> Floats:
        state, distance, change = moved.of
        return getattr(state, name) + distance * getattr(change, name)

    return made


_OF_MOVED = {name: _part_of_moved(name) for name in PARTS}
"""Parts of a state at a distance along a change."""


def _reaction_of_change(change: LateState) -> Floats:
    equations, known, each, reactions = change.of
    return np.zeros(equations.model.n_q) if reactions is None else reactions.change(each, known.lam, change)


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
