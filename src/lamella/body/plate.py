"""A flat rectangular plate of absolute nodal coordinate shell elements."""

from __future__ import annotations

from lamella.body.shell_body import Count, Edge, ShellBody
from lamella.declaration import declaration
from lamella.material.laminate import Laminate
from lamella.surface.base import Rectangle, Surface
from lamella.units import Thickness

__all__ = ["Edge", "Plate"]


@declaration
class Plate(ShellBody):
    """A flat rectangle 0 <= x <= size[0], 0 <= y <= size[1] at rest in its reference configuration, z along its normal.

    The point x = y = 0 is the origin of the body's axes. What else a plate may be given: :class:`ShellBody`.

    Args:
        name: unique name.
        size: lengths along x and y [m].
        mesh: numbers of elements along x and y.
        laminate: the section.
    """

    name: str
    size: tuple[Thickness, Thickness]
    mesh: tuple[Count, Count]
    laminate: Laminate

    @property
    def geometry(self) -> Surface:
        """The rectangle."""
        return Rectangle(self.size)
