"""Changes from one value to another, and polynomials: the laws of drives."""

from __future__ import annotations

import math
from abc import abstractmethod
from bisect import bisect_right
from functools import cached_property
from itertools import pairwise
from typing import Annotated, Literal

from pydantic import Field

from lamella.declaration import declaration
from lamella.math.time_function import Integrable
from lamella.units import Number, OfProfile, Time, Value


@declaration
class Transition(Integrable):
    """Base of the changes from one constant value to another.

    ``start + (end - start) s(tau)`` with ``tau = (t - t_start) / (t_end - t_start)``

    Args:
        t_start: time at which the change begins [s].
        t_end: time at which it is complete [s].
        start: value before [-].
        end: value after [-].

    Raises:
        DeclarationError: t_end is not later than t_start.
    """

    t_start: Time = 0.0
    t_end: Time = Field(kw_only=True)
    start: Value = 0.0
    end: Value = 1.0

    def __post_init__(self) -> None:
        """Refuse a change without duration."""
        if self.t_end <= self.t_start:
            raise ValueError(f"t_end = {self.t_end:g}; accepted is a time later than t_start = {self.t_start:g}")

    @abstractmethod
    def shape(self, tau: float) -> tuple[float, float, float]:
        """s, ds/dtau and d2s/dtau2 for 0 <= tau < 1, from s(0) = 0 to s(1) = 1."""

    @abstractmethod
    def area(self, tau: float) -> float:
        """int_0^tau s for 0 <= tau <= 1."""

    def value(self, t: float) -> float:
        """Value at the time t [s]."""
        return self.end if t >= self.t_end else self.start + (self.end - self.start) * self._at(t)[0]

    def rate(self, t: float) -> float:
        """First derivative by time [1/s]."""
        return (self.end - self.start) * self._at(t)[1] / (self.t_end - self.t_start)

    def acceleration(self, t: float) -> float:
        """Second derivative by time [1/s^2]."""
        duration = self.t_end - self.t_start
        return (self.end - self.start) * self._at(t)[2] / duration / duration  # the square of a short one may be zero

    def integral(self, t: float) -> float:
        """Integral from 0 to t [s]."""
        return self._since_start(t) - self._since_start(0.0)

    def _since_start(self, t: float) -> float:
        """Integral from t_start to t."""
        duration = self.t_end - self.t_start
        tau = min(max((t - self.t_start) / duration, 0.0), 1.0)
        after = (self.end - self.start) * max(t - self.t_end, 0.0)
        return self.start * (t - self.t_start) + (self.end - self.start) * duration * self.area(tau) + after

    def _at(self, t: float) -> tuple[float, float, float]:
        inside = self.t_start <= t < self.t_end
        return self.shape((t - self.t_start) / (self.t_end - self.t_start)) if inside else (0.0, 0.0, 0.0)


@declaration
class Ramp(Transition):
    """Change at a constant rate, ``s = tau``. Arguments: see :class:`Transition`."""

    kind: Literal["ramp"] = "ramp"

    def shape(self, tau: float) -> tuple[float, float, float]:
        """The straight line."""
        return tau, 1.0, 0.0

    def area(self, tau: float) -> float:
        return 0.5 * tau**2

    @property
    def breakpoints(self) -> tuple[float, ...]:
        """Start and end, where the rate jumps [s]."""
        return self.t_start, self.t_end


@declaration
class SmoothStep(Transition):
    """Change with continuous acceleration, ``s = 10 tau^3 - 15 tau^4 + 6 tau^5``. Arguments: see :class:`Transition`."""

    kind: Literal["smooth_step"] = "smooth_step"

    def shape(self, tau: float) -> tuple[float, float, float]:
        """The quintic whose first two derivatives vanish at both ends."""
        s = tau**3 * (10.0 + tau * (-15.0 + 6.0 * tau))
        return s, 30.0 * (tau * (1.0 - tau)) ** 2, 60.0 * tau * (1.0 - tau) * (1.0 - 2.0 * tau)

    def area(self, tau: float) -> float:
        return tau**4 * (2.5 + tau * (-3.0 + tau))


@declaration
class Cycloid(Transition):
    """Change with the acceleration of one sine wave, ``s = tau - sin(2 pi tau)/(2 pi)``. Arguments: see :class:`Transition`."""

    kind: Literal["cycloid"] = "cycloid"

    def shape(self, tau: float) -> tuple[float, float, float]:
        """The cycloid, the classical law of smooth drives and cams."""
        phase = 2.0 * math.pi * tau
        return tau - math.sin(phase) / (2.0 * math.pi), 1.0 - math.cos(phase), 2.0 * math.pi * math.sin(phase)

    def area(self, tau: float) -> float:
        return 0.5 * tau**2 - (1.0 - math.cos(2.0 * math.pi * tau)) / (4.0 * math.pi**2)


@declaration
class TrapezoidalSpeed(Transition):
    """Change with a trapezoidal speed: accelerate evenly, go on at constant speed, decelerate evenly.

    The acceleration changes linearly between zero and its full value a over the time ``ramp``, so that it is continuous and
    the jerk limited to ``a / ramp``. Without a phase of constant speed it thus goes from +a to -a in two ramps about the middle.
    Besides the arguments of :class:`Transition`:

    Args:
        cruise: share of the duration at constant speed, 0 to 1 [-].
        ramp: time in which the acceleration rises from zero to its full value, or falls back [s]; with 0 it jumps.

    Raises:
        DeclarationError: the ramps do not fit into the phases of acceleration.
    """

    cruise: Annotated[Number, Field(ge=0.0, lt=1.0)] = 0.0
    ramp: Annotated[Time, Field(ge=0.0)] = 0.0
    kind: Literal["trapezoidal_speed"] = "trapezoidal_speed"

    def __post_init__(self) -> None:
        """Refuse ramps that do not fit."""
        super().__post_init__()
        longest = 0.25 * (1.0 - self.cruise) * (self.t_end - self.t_start)
        if self.ramp > longest:
            raise ValueError(f"ramp = {self.ramp:g} s; accepted is at most {longest:g} s, so that it fits into the acceleration")

    def shape(self, tau: float) -> tuple[float, float, float]:
        """The piecewise cubic whose second derivative is a trapezoid up and one down."""
        x, (_, s, v, a, j) = self._at_piece(tau)
        return s + x * (v + x * (a / 2.0 + x * j / 6.0)), v + x * (a + x * j / 2.0), a + x * j

    def area(self, tau: float) -> float:
        x, (area, s, v, a, j) = self._at_piece(tau)
        return area + x * (s + x * (v / 2.0 + x * (a / 6.0 + x * j / 24.0)))

    @property
    def breakpoints(self) -> tuple[float, ...]:
        """Times at which the acceleration jumps [s], none with ramps."""
        if self.ramp > 0:
            return ()
        return (*(self.t_start + tau * (self.t_end - self.t_start) for tau in self._pieces[0]), self.t_end)

    def _at_piece(self, tau: float) -> tuple[float, tuple[float, ...]]:
        """Distance from the start of the piece, and area, s and its three derivatives there."""
        starts, values = self._pieces
        k = bisect_right(starts, tau + 1e-13) - 1  # at a jump, rounding shall not choose the piece before it
        return tau - starts[k], values[k]

    @cached_property
    def _pieces(self) -> tuple[list[float], list[tuple[float, ...]]]:
        """Where the pieces of constant jerk begin, and what the function is there."""
        r, phase = self.ramp / (self.t_end - self.t_start), 0.5 * (1.0 - self.cruise)
        corners = [(0.0, 0.0), (r, 1.0), (phase - r, 1.0), (phase, 0.0)]
        corners += [(1.0 - phase, 0.0), (1.0 - phase + r, -1.0), (1.0 - r, -1.0), (1.0, 0.0)]
        starts: list[float] = []
        found: list[tuple[float, ...]] = []
        area = s = v = 0.0
        for (tau, a), (following, a_next) in pairwise(corners):
            x = following - tau
            if x > 1e-12:
                j = (a_next - a) / x
                starts.append(tau)
                found.append((area, s, v, a, j))
                area += x * (s + x * (v / 2.0 + x * (a / 6.0 + x * j / 24.0)))
                s += x * (v + x * (a / 2.0 + x * j / 6.0))
                v += x * (a + x * j / 2.0)
        return starts, [tuple(value / s for value in piece) for piece in found]


@declaration
class Polynomial(Integrable):
    """A polynomial in the time since ``t_start``, ``sum_k c_k (t - t_start)^k``, constant before and after.

    Args:
        coefficients: c_0, c_1, ... [1/s^k].
        t_start: time at which it begins [s].
        t_end: time at which it ends [s].

    Raises:
        DeclarationError: no coefficient, or t_end is not later than t_start.
    """

    coefficients: Annotated[tuple[Number, ...], OfProfile(power=None)]
    t_start: Time = 0.0
    t_end: Time = Field(kw_only=True)
    kind: Literal["polynomial"] = "polynomial"

    def __post_init__(self) -> None:
        """Refuse an empty interval or no coefficients."""
        if self.t_end <= self.t_start:
            raise ValueError(f"t_end = {self.t_end:g}; accepted is a time later than t_start = {self.t_start:g}")
        if not self.coefficients:
            raise ValueError("coefficients = []; accepted is at least one")

    def value(self, t: float) -> float:
        """Value at the time t [s]."""
        return self._derivative(min(max(t, self.t_start), self.t_end), 0)

    def rate(self, t: float) -> float:
        """First derivative by time [1/s]."""
        return self._derivative(t, 1) if self.t_start <= t < self.t_end else 0.0

    def acceleration(self, t: float) -> float:
        """Second derivative by time [1/s^2]."""
        return self._derivative(t, 2) if self.t_start <= t < self.t_end else 0.0

    def integral(self, t: float) -> float:
        """Integral from 0 to t [s]."""
        return self._since_start(t) - self._since_start(0.0)

    @property
    def breakpoints(self) -> tuple[float, ...]:
        """Start and end [s]."""
        return self.t_start, self.t_end

    def _derivative(self, t: float, order: int) -> float:
        x, total = t - self.t_start, 0.0
        for k in range(len(self.coefficients) - 1, order - 1, -1):
            total = total * x + math.perm(k, order) * self.coefficients[k]
        return total

    def _since_start(self, t: float) -> float:
        """Integral from t_start to t."""
        x = min(max(t, self.t_start), self.t_end) - self.t_start
        inside = sum(c * x ** (k + 1) / (k + 1) for k, c in enumerate(self.coefficients))
        before, after = min(t - self.t_start, 0.0), max(t - self.t_end, 0.0)
        return self.value(self.t_start) * before + inside + self.value(self.t_end) * after
