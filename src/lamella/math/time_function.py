"""The contract of every function of time."""

from __future__ import annotations

from abc import ABC, abstractmethod


class TimeFunction(ABC):
    """A function of time with its first two derivatives.

    1. It is frozen data: the same time gives the same value.
    2. It is defined for every finite time, before its start and after its end too.
    3. Where the value or a derivative jumps, the one just after the jump is given; the jump itself has no impulse.
    4. ``breakpoints`` lists, ascending, every time at which the value, rate or acceleration jumps. An integrator that wants its
       full order starts a new step there.
    """

    @abstractmethod
    def value(self, t: float) -> float:
        """Value at the time t [s]."""

    @abstractmethod
    def rate(self, t: float) -> float:
        """First derivative by time [1/s]."""

    @abstractmethod
    def acceleration(self, t: float) -> float:
        """Second derivative by time [1/s^2]."""

    @property
    def breakpoints(self) -> tuple[float, ...]:
        """Times [s] at which the value or one of the two derivatives jumps."""
        return ()


class Integrable(TimeFunction):
    """A function of time whose integral has a closed form, so that it may be given as the speed of a drive."""

    @abstractmethod
    def integral(self, t: float) -> float:
        """Integral of the value from 0 to t [s]."""
