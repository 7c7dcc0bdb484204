"""Sampling: controllers measure signals at equally spaced times."""

from __future__ import annotations

from collections.abc import Sequence
from math import floor

import numpy as np

from lamella.dofs import Signal
from lamella.errors import DeclarationError
from lamella.state import State
from lamella.trigger import Sampler

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

    def next(self, t: float, *stops: float) -> float:
        """The first sample time behind t, infinite when nothing samples.

        Args:
            t: time [s].
            stops: times of other stops; a sample time that is one of them but for rounding is taken as that, since no step is
                to be as short as what lies between.
        """
        found = [(self._start + sampler.period * (self._count(sampler, t) + 1), sampler.period) for sampler, _ in self._samplers]
        return min(
            (next((stop for stop in stops if abs(stop - time) < CLOSE * period), time) for time, period in found), default=np.inf
        )

    def due(self, t: float, before: float | None) -> bool:
        """Whether one has a sample time at t that it had not ``before`` [s], where the last stop was; None at the start."""
        return any(self._is_due(sampler, t, before) for sampler, _ in self._samplers)

    def act(self, t: float, before: float | None, state: State) -> None:
        """Let those whose time it is act on a state."""
        for sampler, measured in self._samplers:
            if self._is_due(sampler, t, before):
                sampler.sample(t, np.array([float(np.atleast_1d(signal.evaluate(state))[k]) for signal, k in measured]))

    def _is_due(self, sampler: Sampler, t: float, before: float | None) -> bool:
        return before is None or self._count(sampler, t) > self._count(sampler, before)

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
