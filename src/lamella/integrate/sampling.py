"""Sampling: controllers measure signals at equally spaced times."""

from __future__ import annotations

from collections.abc import Sequence
from math import floor

import numpy as np

from lamella.dofs import Sampler, Signal
from lamella.errors import DeclarationError
from lamella.state import State

CLOSE = 1e-9
"""Share of a period within which a time counts as a sample time."""


class Sampling:
    """All samplers of a model during one run that begins at ``start`` [s].

    Args:
        samplers: what acts.
        signals: what can be measured.
        start: time of the first samples.

    Raises:
        DeclarationError: a sampler measures what is not recorded.
    """

    def __init__(self, samplers: Sequence[Sampler], signals: Sequence[Signal], start: float) -> None:
        self._start = start
        known = {signal.name: signal for signal in signals}
        self._samplers = [(sampler, [_measured(sampler, name, known) for name in sampler.measures]) for sampler in samplers]

    def next(self, t: float) -> float:
        """The first sample time behind t, infinite when nothing samples."""
        return min(
            (self._start + sampler.period * (self._count(sampler, t) + 1) for sampler, _ in self._samplers), default=np.inf
        )

    def due(self, t: float) -> bool:
        """Whether it is the time of one."""
        return any(self._is_due(sampler, t) for sampler, _ in self._samplers)

    def act(self, t: float, state: State) -> None:
        """Let those whose time it is act on a state."""
        for sampler, measured in self._samplers:
            if self._is_due(sampler, t):
                sampler.sample(t, np.array([float(np.atleast_1d(signal.evaluate(state))[k]) for signal, k in measured]))

    def _is_due(self, sampler: Sampler, t: float) -> bool:
        return abs(t - self._start - sampler.period * self._count(sampler, t)) < CLOSE * sampler.period

    def _count(self, sampler: Sampler, t: float) -> int:
        return floor((t - self._start) / sampler.period + CLOSE)


def _measured(sampler: Sampler, name: str, known: dict[str, Signal]) -> tuple[Signal, int]:
    stem, _, label = name.rpartition(".")
    if name in known and not known[name].labels:
        return known[name], 0
    if stem in known and label in known[stem].labels:
        return known[stem], known[stem].labels.index(label)
    parts = [f"{key}.{part}" if part else key for key, signal in known.items() for part in (signal.labels or ("",))]
    raise DeclarationError(
        f"Controller '{sampler.name}'", f"there is no single value '{name}'", f"accepted are {', '.join(parts)}"
    )
