"""Derivatives of signals that few vectors tell, of several samples at once."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from lamella.assembly.equations import Equations
from lamella.assembly.point import Point
from lamella.assembly.point_state import PointStack, reaction_at
from lamella.differentiation.beside import Beside, values_of
from lamella.differentiation.reactions import Reactions
from lamella.differentiation.solution import PointDerivative
from lamella.dofs import Signal
from lamella.roles import Floats
from lamella.state import LateState

TOGETHER = 16
"""Samples that are evaluated at once: Python takes more time for one than the numbers of a small model do."""


def stack_of(
    equations: Equations, besides: Sequence[Beside], signals: Mapping[str, Signal], reactions: Reactions | None
) -> SignalStack | None:
    """A stack of those of the signals that suit one; None where none does, or where samples cannot wait.

    What remembers must be asked at each sample, and reactions must be told for several states at once.

    Args:
        equations: of the model.
        besides: the signals beside each parameter.
        signals: by name.
        reactions: derivatives of reactions, if any are asked for.
    """
    chosen = {name: own for name, own in signals.items() if own.derivative and own.of_vectors is not None}
    models = [equations, *(side.equations for each in besides for side in each.neighbours.sides)]
    if not chosen or equations.elimination.moves or any(each.model.remembers for each in models):
        return None
    if not all(each.stacks for each in besides):
        return None
    if reactions and not (all(each.holding.stack(TOGETHER) for each in models) and all(each.reactions_stack for each in besides)):
        return None
    return SignalStack(equations, besides, chosen, reactions)


class SignalStack:
    """Samples side by side, of which nothing but what signals need is kept.

    Args:
        equations, besides, reactions: see :func:`stack_of`.
        signals: by name; few vectors tell them and their derivatives (:attr:`lamella.dofs.Signal.of_vectors`).

    Attributes:
        waiting: samples that are not evaluated yet.
    """

    def __init__(
        self, equations: Equations, besides: Sequence[Beside], signals: Mapping[str, Signal], reactions: Reactions | None
    ) -> None:
        self.signals = signals
        self._equations, self._besides, self._reactions = equations, besides, reactions
        told = [signal.of_vectors for signal in signals.values() if signal.of_vectors is not None]
        vectors = np.concatenate([*told, equations.holding.vectors] if reactions else told)
        self._points = PointStack(equations, vectors, TOGETHER, held=True)
        self._changes = [PointStack(equations, vectors, TOGETHER, held=False) for _ in besides]
        self._first: Point | None = None
        self.waiting = 0

    @property
    def full(self) -> bool:
        """Whether no other sample can be taken before the next evaluation."""
        return self.waiting == TOGETHER

    def put(self, point: Point, derivatives: Sequence[PointDerivative]) -> None:
        """Take a sample."""
        k = self.waiting
        if not k:
            self._first = point
        self.waiting += 1
        self._points.put(k, point)
        for change, derivative in zip(self._changes, derivatives, strict=True):
            change.put(k, derivative)

    def evaluate(self) -> tuple[dict[str, Floats], dict[str, Floats]]:
        """Values of the signals, shape (n, n_component), and derivatives, shape (n, n_parameter, n_component), of the samples
        that wait, which are then forgotten.
        """
        n, point = self.waiting, self._first
        assert point is not None, "there is a sample"
        self.waiting = 0
        stacks = self._points, *self._changes
        for stack in stacks:
            stack.fill(n)
        state = self._points.state(point.t, point.factor, _OF_POINTS, self._equations, point)
        if self._reactions:
            self._reactions.look(point, state)
        here = {name: values_of(signal, state, TOGETHER) for name, signal in self.signals.items()}
        found: dict[str, list[Floats]] = {name: [] for name in self.signals}
        for beside, stack in zip(self._besides, self._changes, strict=True):
            change = stack.state(point.t, point.factor, _OF_CHANGES, beside.neighbours, self._reactions)
            for name, signal in self.signals.items():
                assert signal.derivative, "see stack_of"
                found[name].append(np.reshape(signal.derivative(state, change), (TOGETHER, -1)))
            differ = [name for name in beside.differ if name in here]
            if differ:
                states = beside.states_of_stack(state)
                for name in differ:
                    found[name][-1] = found[name][-1] + beside.difference(name, here[name], states)
        for stack in stacks:
            stack.clear()
        derivatives = {name: np.stack(parts, axis=1)[:n] for name, parts in found.items()}
        return {name: values[:n] for name, values in here.items()}, derivatives


def _reaction_of_points(state: LateState) -> Floats:
    _, equations, point = state.of
    return reaction_at(equations, point, state, TOGETHER)


def _reaction_of_changes(change: LateState) -> Floats:
    _, each, reactions = change.of
    return reactions.change(each, np.zeros(0), change)  # a stack has no multipliers


_OF_POINTS: Mapping[str, Callable[[LateState], Floats]] = {"reaction": _reaction_of_points}
_OF_CHANGES: Mapping[str, Callable[[LateState], Floats]] = {"reaction": _reaction_of_changes}
