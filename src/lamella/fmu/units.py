"""Units and names as FMI writes them."""

from __future__ import annotations

import re

from lamella.units import in_base_units

NONE = "1"
"""Unit of a pure number, which FMI leaves out."""
SYMBOLS = {
    "kilogram": "kg",
    "meter": "m",
    "second": "s",
    "ampere": "A",
    "kelvin": "K",
    "mole": "mol",
    "candela": "cd",
    "radian": "rad",
}
NAME = re.compile(r"[A-Za-z_]\w*(\.[A-Za-z_]\w*)*", re.ASCII)


def base_units(unit: str) -> dict[str, str]:
    """Attributes of FMI's BaseUnit: exponents of SI base units and of radians, and a factor unless it is 1."""
    factor, exponents = in_base_units(unit)
    found = {} if factor == 1.0 else {"factor": repr(factor)}
    return found | {SYMBOLS[name]: str(int(power)) for name, power in exponents.items()}


def is_structured(name: str) -> bool:
    """Whether a name follows FMI's convention for structured names."""
    return NAME.fullmatch(name) is not None
