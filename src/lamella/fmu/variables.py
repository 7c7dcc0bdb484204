"""The variables of a unit by reference."""

from __future__ import annotations

from typing import Any, Never

from lamella.errors import DeclarationError


class Variables(dict[int, Any]):
    """What pythonfmu and pythonfmu3 look variables up in, whatever is asked of them; tells of one that does not exist.

    Args:
        unit: name of the unit.
    """

    def __init__(self, unit: str) -> None:
        super().__init__()
        self._unit = unit

    def __missing__(self, reference: int) -> Never:
        """Raise: no variable has this reference."""
        there = ", ".join(f"{own} ({variable.name})" for own, variable in self.items())
        raise DeclarationError(f"FMU '{self._unit}'", f"no variable has the reference {reference}", f"accepted is one of {there}")
