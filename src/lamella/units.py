"""Physical quantities: numbers in SI units, or strings that carry a unit, such as ``1.5 mm``."""

from __future__ import annotations

import hashlib
import math
import re
import reprlib
import shutil
from dataclasses import dataclass
from functools import cache, lru_cache, partial
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, get_args

from platformdirs import user_cache_path
from pydantic import BeforeValidator, Field

from lamella.errors import UnitError
from lamella.remembered import Remembered

LARGEST = {"m": 1e12, "Pa": 1e20, "": 1e30}
"""Of quantities, by their unit; the last of any other. Beyond all use, and before digits are lost or products overflow."""


@dataclass(frozen=True)
class Unit:
    """The SI unit of an annotated number; shown in messages, schema and result files."""

    symbol: str


@dataclass(frozen=True)
class OfProfile:
    """Marks a number of a profile: its unit is that of what the profile stands for, over seconds to a power.

    Args:
        power: of seconds; None where it is the place in a list.
    """

    power: int | None = 0


@cache
def unit_in(annotation: Any) -> str | None:
    """The unit of the numbers or profiles that an annotation allows; None where it says none."""
    for mark in getattr(annotation, "__metadata__", ()):
        if isinstance(mark, Unit):
            return mark.symbol
    return next((unit for unit in map(unit_in, get_args(annotation)) if unit is not None), None)


ANY = "any unit"
"""Stands for the unit of a profile that nothing refers to."""


def per_second(unit: str, power: int) -> str:
    """The unit over seconds to a power, in which profiles of that unit grow."""
    if not power or unit == ANY:
        return unit
    if unit.endswith("/s"):
        unit, power = unit.removesuffix("/s"), power + 1
    return f"{unit or '1'}/s^{power}" if power > 1 else f"{unit or '1'}/s"


@cache
def _registry() -> Any:
    """Pint's units; what it has read of them is kept in the user's cache, which saves 0.3 s at each start."""
    import pint  # imported late: 0.2 s that plain numbers never need

    folder = user_cache_path("lamella") / f"units-{pint.__version__}"
    try:
        registry = pint.UnitRegistry(cache_folder=folder)
        registry.Quantity("1 m")
        return registry
    except Exception:  # noqa: BLE001  # whatever was left in the cache, or hinders us to write there
        shutil.rmtree(folder, ignore_errors=True)
        return pint.UnitRegistry(cache_folder=None)


def to_si(value: object, unit: str) -> float:
    """Convert a number or a string with a unit to a float in ``unit``.

    Args:
        value: a finite number, taken as SI, or a string such as ``"1.5 mm"`` or ``"181 GPa"``.
        unit: SI unit expected, for example ``"m"``; ``""`` for a pure number.

    Raises:
        UnitError: unknown or incompatible unit, not a number, NaN or infinite.
    """
    accepted = f"accepted is a number in {unit} or text such as '1.5 {unit}'" if unit else "accepted is a plain number"
    accepted = "accepted is a number or text such as '1.5 mm'" if unit == ANY else accepted
    if isinstance(value, bool) or not (isinstance(value, str) or hasattr(value, "__float__")):  # as numbers of NumPy have
        raise UnitError(f"{value!r} is not a number; {accepted}")
    try:
        number = _parse(value, unit, accepted) if isinstance(value, str) else float(value)  # type: ignore[arg-type]
    except OverflowError:  # an integer of more than 308 digits
        number = math.inf
    except TypeError as error:  # an array of several numbers
        raise UnitError(f"{reprlib.repr(value)} is not a number; {accepted}") from error
    if not math.isfinite(number):
        raise UnitError(f"{number} is not finite; {accepted}")
    return number


@cache
def _remembered() -> Remembered:
    """What this very file and this version of Pint have read before: of any other, values may be wrong."""
    made_by = hashlib.sha256(version("pint").encode() + Path(__file__).read_bytes()).hexdigest()[:16]
    return Remembered(user_cache_path("lamella") / f"quantities-{made_by}.json")


@lru_cache(maxsize=4096)
def _parse(text: str, unit: str, accepted: str) -> float:
    known = _remembered().get(text, unit)
    return _remembered().put(text, unit, _by_pint(text, unit, accepted)) if known is None else known


def _by_pint(text: str, unit: str, accepted: str) -> float:
    import pint  # late, as above

    try:
        quantity = _registry().Quantity(text)
    except pint.OffsetUnitCalculusError:  # '20 degC' is a point on a scale, not twenty times a unit
        quantity = _on_scale(text, accepted)
    except Exception as error:  # pint raises its own, tokenizer and attribute errors for malformed text
        raise UnitError(f"'{text}' is not a number with a known unit; {accepted}") from error
    if not quantity.unit_items():  # no unit at all; '50 percent' and '1 mm/m' have one, which must be converted
        return float(quantity.magnitude)
    if unit == ANY:
        return float(quantity.to_base_units().magnitude)
    try:
        return float(quantity.to(unit or "dimensionless").magnitude)
    except pint.DimensionalityError as error:
        raise UnitError(
            f"'{text}' has the unit {quantity.units:~}, which does not convert to {unit or 'a pure number'}; {accepted}"
        ) from error


def _on_scale(text: str, accepted: str) -> Any:
    """A temperature in degrees Celsius or Fahrenheit."""
    found = re.fullmatch(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*([^\W\d]+|°\w+)\s*", text)
    if found is None:
        raise UnitError(
            f"'{text}' mixes a temperature scale with other units; {accepted}, differences of temperature in K or delta_degC"
        )
    return _registry().Quantity(float(found[1]), found[2])


def in_base_units(unit: str) -> tuple[float, dict[str, float]]:
    """A unit as a factor times powers of base units, radians among them: N m is 1 and kilogram 1, meter 2, second -2."""
    found = _registry().Quantity(1.0, unit).to_base_units()
    return float(found.magnitude), {name: float(power) for name, power in found.unit_items()}


def limited(value: object, unit: str, *, unlimited: bool = False) -> float:
    """A number in ``unit`` that can be computed with, from a number or a string; arguments as those of :func:`quantity`.

    Raises:
        ValueError: it is none, or too large.
    """
    if unlimited and isinstance(value, float) and value == math.inf:
        return value
    try:
        number = to_si(value, unit)
    except UnitError as error:
        raise ValueError(str(error)) from error
    largest = LARGEST.get(unit, LARGEST[""])
    if abs(number) > largest:
        raise ValueError(f"{number} is too large to compute with; accepted is at most {largest:g} {unit}".rstrip())
    return number


def quantity(unit: str, *, unlimited: bool = False, **limits: float) -> Any:
    """An annotated float in ``unit`` with optional limits (``gt``, ``ge``, ``lt``, ``le``) for declarations.

    With ``unlimited`` it may be infinite, as a bound that holds nothing back is.
    """
    convert = BeforeValidator(partial(limited, unit=unit, unlimited=unlimited), json_schema_input_type=float | str)
    return Annotated[float, Unit(unit), convert, Field(json_schema_extra={"unit": unit}, **limits)]  # type: ignore[arg-type]


if TYPE_CHECKING:
    Value = Number = Positive = NonNegative = Length = Thickness = Angle = Time = Mass = Density = Modulus = float
    Force = ForcePerLength = Pressure = Torque = TorquePerLength = Velocity = AngularVelocity = Acceleration = Rate = float
    Expansion = Conductivity = SpecificHeat = Inertia = Product = float
    Temperature = TemperatureGradient = HeatFlux = HeatSource = FilmCoefficient = Share = float
    Stiffness = Damping = TorsionalStiffness = TorsionalDamping = float
else:
    Number = quantity("")
    Value = Annotated[Number, OfProfile()]
    Positive = quantity("", gt=0)
    NonNegative = quantity("", ge=0)
    Length = quantity("m")
    Thickness = quantity("m", gt=0)
    Angle = quantity("rad")
    Time = quantity("s")
    Mass = quantity("kg", gt=0)
    Density = quantity("kg/m^3", gt=0)
    Modulus = quantity("Pa", gt=0)
    Force = quantity("N")
    ForcePerLength = quantity("N/m")
    Pressure = quantity("Pa")
    Torque = quantity("N*m")
    TorquePerLength = quantity("N")
    Velocity = quantity("m/s")
    AngularVelocity = quantity("rad/s")
    Acceleration = quantity("m/s^2")
    Rate = quantity("1/s", ge=0)
    Expansion = quantity("1/K")
    Conductivity = quantity("W/(m*K)", gt=0)
    SpecificHeat = quantity("J/(kg*K)", gt=0)
    Temperature = quantity("K", ge=0)
    TemperatureGradient = quantity("K/m")
    HeatFlux = quantity("W/m^2")
    HeatSource = quantity("W/m^3")
    FilmCoefficient = quantity("W/(m^2*K)", ge=0)
    Share = quantity("", ge=0, le=1)
    Inertia = quantity("kg*m^2", gt=0)
    Product = quantity("kg*m^2")
    Stiffness = quantity("N/m", ge=0)
    Damping = quantity("N*s/m", ge=0)
    TorsionalStiffness = quantity("N*m/rad", ge=0)
    TorsionalDamping = quantity("N*m*s/rad", ge=0)
