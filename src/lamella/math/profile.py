"""Named functions of time: the courses of loads and of prescribed motions.

The value of a profile is a pure number that multiplies the magnitude of a load. A prescribed motion takes it as a displacement in
metres.
"""

from __future__ import annotations

import math
from abc import abstractmethod
from typing import TYPE_CHECKING, Annotated, Any, Literal, Union, get_args

import numpy as np
from pydantic import BeforeValidator, Discriminator, Field, Tag

from lamella.declaration import declaration
from lamella.errors import DeclarationError
from lamella.math.table import Table
from lamella.math.time_function import TimeFunction
from lamella.units import Angle, Number, Time, quantity

__all__ = ["Constant", "Cycloid", "Harmonic", "Profile", "Ramp", "SmoothStep", "Step", "Table", "TimeFunction", "as_profile"]


def _periods(value: object) -> object:
    # An angular unit would pass as Hz and be wrong by 2 pi, since radians count as pure numbers.
    if isinstance(value, str) and any(word in value.lower() for word in ("rad", "rpm", "rev", "turn", "deg")):
        raise ValueError(f"'{value}' is an angular velocity; accepted is a number of periods per second such as '1.5 Hz'")
    return value


if TYPE_CHECKING:
    Frequency = float
else:
    Frequency = Annotated[quantity("Hz", gt=0), BeforeValidator(_periods)]


@declaration
class Constant(TimeFunction):
    """The same value at all times.

    Args:
        level: the value [-].
    """

    level: Number = 1.0
    kind: Literal["constant"] = "constant"

    def value(self, t: float) -> float:
        """Value at the time t [s]."""
        return self.level

    def rate(self, t: float) -> float:
        """First derivative by time [1/s]."""
        return 0.0

    def acceleration(self, t: float) -> float:
        """Second derivative by time [1/s^2]."""
        return 0.0


@declaration
class Step(TimeFunction):
    """A jump from zero: 0 before the time ``at``, ``level`` from then on.

    Args:
        level: value after the jump [-].
        at: time of the jump [s].
    """

    level: Number = 1.0
    at: Time = 0.0
    kind: Literal["step"] = "step"

    def value(self, t: float) -> float:
        """Value at the time t [s]."""
        return self.level if t >= self.at else 0.0

    def rate(self, t: float) -> float:
        """First derivative by time, zero on both sides of the jump [1/s]."""
        return 0.0

    def acceleration(self, t: float) -> float:
        """Second derivative by time, zero on both sides of the jump [1/s^2]."""
        return 0.0

    @property
    def breakpoints(self) -> tuple[float, ...]:
        """The time of the jump [s]."""
        return (self.at,)


@declaration
class Transition(TimeFunction):
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
    start: Number = 0.0
    end: Number = 1.0

    def __post_init__(self) -> None:
        """Refuse a change without duration."""
        if self.t_end <= self.t_start:
            raise ValueError(f"t_end = {self.t_end:g}; accepted is a time later than t_start = {self.t_start:g}")

    @abstractmethod
    def shape(self, tau: float) -> tuple[float, float, float]:
        """s, ds/dtau and d2s/dtau2 for 0 <= tau < 1, from s(0) = 0 to s(1) = 1."""

    def value(self, t: float) -> float:
        """Value at the time t [s]."""
        return self.end if t >= self.t_end else self.start + (self.end - self.start) * self._at(t)[0]

    def rate(self, t: float) -> float:
        """First derivative by time [1/s]."""
        return (self.end - self.start) * self._at(t)[1] / (self.t_end - self.t_start)

    def acceleration(self, t: float) -> float:
        """Second derivative by time [1/s^2]."""
        return (self.end - self.start) * self._at(t)[2] / (self.t_end - self.t_start) ** 2

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


@declaration
class Cycloid(Transition):
    """Change with the acceleration of one sine wave, ``s = tau - sin(2 pi tau)/(2 pi)``. Arguments: see :class:`Transition`."""

    kind: Literal["cycloid"] = "cycloid"

    def shape(self, tau: float) -> tuple[float, float, float]:
        """The cycloid, the classical law of smooth drives and cams."""
        phase = 2.0 * math.pi * tau
        return tau - math.sin(phase) / (2.0 * math.pi), 1.0 - math.cos(phase), 2.0 * math.pi * math.sin(phase)


@declaration
class Harmonic(TimeFunction):
    """A sine wave, ``mean + amplitude sin(2 pi frequency t + phase)``.

    Args:
        amplitude: half the range [-].
        frequency: periods per second, not radians [Hz].
        phase: [rad].
        mean: value about which it swings [-].
    """

    amplitude: Number
    frequency: Frequency
    phase: Angle = 0.0
    mean: Number = 0.0
    kind: Literal["harmonic"] = "harmonic"

    def value(self, t: float) -> float:
        """Value at the time t [s]."""
        return self.mean + self.amplitude * math.sin(self._omega * t + self.phase)

    def rate(self, t: float) -> float:
        """First derivative by time [1/s]."""
        return self.amplitude * self._omega * math.cos(self._omega * t + self.phase)

    def acceleration(self, t: float) -> float:
        """Second derivative by time [1/s^2]."""
        return -self.amplitude * self._omega**2 * math.sin(self._omega * t + self.phase)

    @property
    def _omega(self) -> float:
        return 2.0 * math.pi * self.frequency


def _constant_from_number(value: object) -> object:
    is_number = isinstance(value, (int, float, np.number)) and not isinstance(value, bool)
    return Constant(float(value)) if is_number else value  # type: ignore[arg-type]


AnyProfile = Constant | Step | Ramp | SmoothStep | Cycloid | Harmonic | Table


def _kind(value: object) -> object:
    return value.get("kind") if isinstance(value, dict) else getattr(value, "kind", None)


if TYPE_CHECKING:
    Profile = AnyProfile
else:
    _MEMBERS = {cls.kind: cls for cls in get_args(AnyProfile)}
    Profile = Annotated[
        Union[tuple(Annotated[cls, Tag(kind)] for kind, cls in _MEMBERS.items())],  # noqa: UP007  # made from the catalogue
        Discriminator(
            _kind,
            custom_error_type="profile",
            custom_error_message=f"accepted is a number, or a profile whose kind is one of {', '.join(_MEMBERS)}",
        ),
        BeforeValidator(_constant_from_number, json_schema_input_type=float | AnyProfile),
    ]
"""A profile in a declaration or a model file (``{kind: ramp, t_end: 1 s}``); a plain number stands for a Constant."""


def as_profile(value: Any) -> TimeFunction:
    """The profile itself, or a :class:`Constant` made from a number.

    Args:
        value: a profile or a finite number [-].

    Raises:
        DeclarationError: neither a profile nor a number.
    """
    made = _constant_from_number(value)
    if not isinstance(made, TimeFunction):
        raise DeclarationError(
            "profile", f"{value!r} is not a function of time", "accepted is a number or a profile such as lm.Ramp"
        )
    return made
