"""Named functions of time: the courses of loads and of prescribed motions.

The value of a profile is a pure number that multiplies the magnitude of a load, or has the unit of what it stands for: a
displacement, the angle of a drive, its speed.
"""

from __future__ import annotations

import math
import re
from functools import partial
from typing import TYPE_CHECKING, Annotated, Any, Literal, Union, get_args

import numpy as np
from pydantic import BeforeValidator, Discriminator, Tag

from lamella.declaration import declaration
from lamella.math.table import Table
from lamella.math.time_function import Integrable, TimeFunction
from lamella.math.transition import Cycloid, Polynomial, Ramp, SmoothStep, TrapezoidalSpeed
from lamella.units import Angle, OfProfile, Time, Unit, Value, limited, quantity

__all__ = [
    "AngleProfile",
    "AngularVelocityProfile",
    "Constant",
    "Cycloid",
    "ForceProfile",
    "Harmonic",
    "Integral",
    "LengthProfile",
    "Polynomial",
    "Profile",
    "Ramp",
    "SmoothStep",
    "Step",
    "Table",
    "TimeFunction",
    "TorqueProfile",
    "TrapezoidalSpeed",
    "VelocityProfile",
]


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
class Constant(Integrable):
    """The same value at all times.

    Args:
        level: the value [-].
    """

    level: Value = 1.0
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

    def integral(self, t: float) -> float:
        """Integral from 0 to t [s]."""
        return self.level * t


@declaration
class Step(Integrable):
    """A jump from zero: 0 before the time ``at``, ``level`` from then on.

    Args:
        level: value after the jump [-].
        at: time of the jump [s].
    """

    level: Value = 1.0
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

    def integral(self, t: float) -> float:
        """Integral from 0 to t [s]."""
        return self.level * (max(t - self.at, 0.0) - max(-self.at, 0.0))

    @property
    def breakpoints(self) -> tuple[float, ...]:
        """The time of the jump [s]."""
        return (self.at,)


@declaration
class Harmonic(Integrable):
    """A sine wave, ``mean + amplitude sin(2 pi frequency t + phase)``.

    Args:
        amplitude: half the range [-].
        frequency: periods per second, not radians [Hz].
        phase: [rad].
        mean: value about which it swings [-].
    """

    amplitude: Value
    frequency: Frequency
    phase: Angle = 0.0
    mean: Value = 0.0
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

    def integral(self, t: float) -> float:
        """Integral from 0 to t [s]."""
        half = 0.5 * self._omega * t  # a product of sines, for a difference of cosines loses the digits of a slow wave
        return self.mean * t + 2.0 * self.amplitude * math.sin(half) * math.sin(half + self.phase) / self._omega

    @property
    def _omega(self) -> float:
        return 2.0 * math.pi * self.frequency


QUANTITY = re.compile(r"\s*[-+]?\.?\d")
"""How a number with a unit begins; any other text is a name."""


def _constant_from_number(value: object, unit: str) -> object:
    if isinstance(value, str) and QUANTITY.match(value):
        return Constant(limited(value, unit))
    is_number = isinstance(value, (int, float, np.number)) and not isinstance(value, bool)
    return Constant(value) if is_number else value  # type: ignore[arg-type]


def _kind(value: object) -> object:
    return value.get("kind") if isinstance(value, dict) else getattr(value, "kind", None)


def _told_by_kind(catalogue: Any, unit: str = "") -> Any:
    """The annotation of a field that takes a number or a profile of the catalogue, a union; its ``kind`` says which.

    Args:
        catalogue: the union.
        unit: of what the profile stands for, in which a model file may give it.
    """
    members = {cls.kind: cls for cls in get_args(catalogue)}
    number = f"a number in {unit} such as '1.5 {unit}'" if unit else "a number"
    return Annotated[
        Union[tuple(Annotated[cls, Tag(kind)] for kind, cls in members.items())],  # noqa: UP007  # made from the catalogue
        Unit(unit),
        Discriminator(
            _kind,
            custom_error_type="profile",
            custom_error_message=f"accepted is {number}, or a profile whose kind is one of {', '.join(members)}",
        ),
        BeforeValidator(partial(_constant_from_number, unit=unit), json_schema_input_type=float | str | catalogue),
    ]


SpeedProfile = Constant | Step | Ramp | SmoothStep | Cycloid | TrapezoidalSpeed | Polynomial | Harmonic | Table
"""Profiles whose integral has a closed form."""

if TYPE_CHECKING:
    Rate = SpeedProfile
else:
    Rate = Annotated[_told_by_kind(SpeedProfile), OfProfile(power=1)]


@declaration
class Integral(TimeFunction):
    """The integral of another profile, ``start + int_0^t of(s) ds``: the way of a speed, the angle of an angular velocity.

    Args:
        of: profile whose value is the rate of this one, or a number.
        start: value at t = 0 [-].
    """

    of: Rate
    start: Value = 0.0
    kind: Literal["integral"] = "integral"

    def value(self, t: float) -> float:
        """Value at the time t [s]."""
        return self.start + self.of.integral(t)

    def rate(self, t: float) -> float:
        """First derivative by time [1/s]."""
        return self.of.value(t)

    def acceleration(self, t: float) -> float:
        """Second derivative by time [1/s^2]."""
        return self.of.rate(t)

    @property
    def breakpoints(self) -> tuple[float, ...]:
        """Those of the integrand [s]."""
        return self.of.breakpoints


AnyProfile = SpeedProfile | Integral


if TYPE_CHECKING:
    Profile = LengthProfile = AngleProfile = ForceProfile = TorqueProfile = AnyProfile
    VelocityProfile = AngularVelocityProfile = AnyProfile
else:
    Profile = _told_by_kind(AnyProfile)
    LengthProfile, AngleProfile = _told_by_kind(AnyProfile, "m"), _told_by_kind(AnyProfile, "rad")
    VelocityProfile, AngularVelocityProfile = _told_by_kind(AnyProfile, "m/s"), _told_by_kind(AnyProfile, "rad/s")
    ForceProfile, TorqueProfile = _told_by_kind(AnyProfile, "N"), _told_by_kind(AnyProfile, "N m")
"""A profile in a declaration or a model file (``{kind: ramp, t_end: 1 s}``); a plain number stands for a Constant. ``Profile`` is
a factor, the others have a unit."""
