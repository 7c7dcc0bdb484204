"""The changing part of a simulation, as plain arrays."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Generic, TypeVar

from lamella.roles import Floats

T = TypeVar("T")


@dataclass(frozen=True)
class State:
    """A state of a model.

    Args:
        t: time [s].
        q: coordinates, shape (n_q,); three to a vector, see :mod:`lamella.roles`.
        v: their velocities, shape (n_q,).
        a: their accelerations, shape (n_q,).
        lam: Lagrange multipliers of the constraints that are not eliminated, shape (n_lam,).
        reaction: M a + f + Phi_q^T lam, shape (n_q,): it vanishes but for the eliminated constraints C q = c, and is C^T mu with
            the force mu of each; see :meth:`lamella.assembly.elimination.Elimination.row_forces`.
        factor: load factor in statics, 1 in motion.
        memory: what the next state depends on beside these, of the last state of a solution, see
            :meth:`lamella.model.Model.remembering`; None for none, as at the start of a run.
    """

    t: float
    q: Floats
    v: Floats
    a: Floats
    lam: Floats
    reaction: Floats
    factor: float = 1.0
    memory: dict[str, Any] | None = field(default=None, compare=False, repr=False)


PARTS = ("q", "v", "a", "lam", "reaction")
"""What a state consists of beside time and load factor."""


class LateState(State):
    """A state whose parts are made when they are first asked for; most signals ask for one.

    Args:
        t: time [s].
        factor: load factor.
        made: makes each part from the state itself, by name.
        of: what they are made of, which must stay as it is.
    """

    def __init__(self, t: float, factor: float, made: Mapping[str, Callable[[Any], Floats]], of: Any) -> None:
        self.__dict__.update(t=t, factor=factor, made=made, of=of)

    def __getattr__(self, name: str) -> Floats:
        """A part that was not asked for yet."""
        if name not in PARTS:
            raise AttributeError(name)
        part = self.__dict__[name] = self.__dict__["made"][name](self)
        return part


class OncePerState(Generic[T]):
    """A function of the state that several signals share: evaluated once while they are recorded for one state.

    Args:
        evaluate: the function.
    """

    def __init__(self, evaluate: Callable[[State], T]) -> None:
        self.evaluate = evaluate
        self._last: tuple[State, T] | None = None

    def __call__(self, state: State) -> T:
        if self._last is None or self._last[0] is not state:
            self._last = state, self.evaluate(state)
        return self._last[1]
