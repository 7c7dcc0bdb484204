"""A curved shell of absolute nodal coordinate shell elements."""

from __future__ import annotations

from lamella.body.shell_body import Count, ShellBody
from lamella.declaration import declaration
from lamella.errors import DeclarationError
from lamella.material.laminate import Laminate
from lamella.surface.base import Surface


@declaration
class Shell(ShellBody):
    """A thin shell on a curved reference surface, open or closed on itself.

    The surface is given in the body's axes; ``position`` and ``rotation`` place it. Points are named by its parameters x, y [m].
    What else a shell may be given: :class:`ShellBody`.

    Args:
        name: unique name.
        surface: the reference surface, where the shell is at the start.
        mesh: numbers of elements along x and y.
        laminate: the section; its top side is that of the surface's normal.
        stress_free: the surface on which the shell has no stress, for a flat sheet that was bent or a belt that was stretched;
            the reference surface when left out. Points correspond by their share of the parameters' lengths.

    Raises:
        DeclarationError: the surface folds, degenerates or does not close as it says.
    """

    name: str
    surface: Surface
    mesh: tuple[Count, Count]
    laminate: Laminate
    stress_free: Surface | None = None

    def __post_init__(self) -> None:
        """Refuse what a curved shell cannot be."""
        super().__post_init__()
        if self.strain == "rigid":
            raise DeclarationError(
                self.item,
                "strain = 'rigid'",
                "accepted for a curved body that keeps its shape is a RigidBody, or a Plate if it is flat",
            )
        if self.stress_free is not None and self.strain != "exact":
            raise DeclarationError(self.item, f"stress_free with the strain model '{self.strain}'", "accepted is 'exact'")

    @property
    def geometry(self) -> Surface:
        """The surface."""
        return self.surface

    @property
    def stress_free_geometry(self) -> Surface:
        """The surface on which there is no stress."""
        return self.stress_free or self.surface
