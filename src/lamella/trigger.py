"""What happens between the steps of a run: events, and what acts at sample times."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

from lamella.roles import Floats
from lamella.state import State


@dataclass(frozen=True)
class Trigger:
    """An event: something happens when a function of the state passes through zero.

    Args:
        name: the declaration's name.
        evaluate: the function; None when it is a recorded signal less a level.
        direction: 1 for passing upwards, -1 downwards, 0 for both.
        text: what happens, for messages.
        act: called between two steps; None when the event is only noted.
        stops: whether the run ends there.
        once: whether it may happen only once in a run.
        watch, component, level: the signal, its component and the level, when ``evaluate`` is None.
    """

    name: str
    evaluate: Callable[[State], float] | None
    direction: int
    text: str
    act: Callable[[], None] | None = None
    stops: bool = False
    once: bool = True
    watch: str = ""
    component: str | None = None
    level: float = 0.0


class Sampler(Protocol):
    """Something with a memory that acts at sample times on measured signals; see :mod:`lamella.load.controller`."""

    name: str
    measures: tuple[str, ...]
    """Signals or components."""
    period: float

    def sample(self, t: float, y: Floats) -> None:
        """Act on the measured values."""
        ...

    def reset(self) -> None:
        """Begin again."""
        ...
