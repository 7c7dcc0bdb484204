"""Contact with a cylinder, a sphere and a plane."""

from __future__ import annotations

from pydantic import InstanceOf

from lamella.body.base import Marker
from lamella.body.rigid import RigidBody
from lamella.body.shell_body import ShellBody
from lamella.contact.base import Contact, Direction, unit_axis
from lamella.contact.gap import CYLINDER, PLANE, SPHERE, Obstacle
from lamella.declaration import declaration
from lamella.units import Thickness

EDGE = 0.05
"""Radius of a cylinder's edges, when left out, as a share of its radius."""


@declaration
class CylinderContact(Contact):
    """Contact of a shell with the outside of a circular cylinder of finite length, such as a roller.

    The law, its options and what is recorded: :class:`Contact`. Its ends are rounded: beyond them the surface falls off by
    (|z| - l/2)^2 / (2 r).

    Args:
        name: unique name.
        shell: the plate or shell.
        at: marker in the middle of the cylinder, on a rigid body or the ground.
        radius: R [m].
        length: l, of the straight part [m].
        axis: its direction in the axes of the marker's body.
        edge: r, radius of the edges [m]; 5 % of R when left out.
    """

    name: str
    shell: InstanceOf[ShellBody]
    at: Marker
    radius: Thickness
    length: Thickness
    axis: Direction = (0.0, 0.0, 1.0)
    edge: Thickness | None = None

    def obstacle(self) -> Obstacle:
        """The cylinder."""
        axis = unit_axis(self.item, "axis", self.axis)
        edge = EDGE * self.radius if self.edge is None else self.edge
        return Obstacle(CYLINDER, self.radius, 0.5 * self.length, edge, _centre(self.at), axis, _moves(self.at))


@declaration
class SphereContact(Contact):
    """Contact of a shell with the outside of a sphere. The law, its options and what is recorded: :class:`Contact`.

    Args:
        name: unique name.
        shell: the plate or shell.
        at: marker in its centre, on a rigid body or the ground.
        radius: R [m].
    """

    name: str
    shell: InstanceOf[ShellBody]
    at: Marker
    radius: Thickness

    def obstacle(self) -> Obstacle:
        """The sphere."""
        return Obstacle(SPHERE, self.radius, 0.0, 1.0, _centre(self.at), (0.0, 0.0, 1.0), _moves(self.at))


@declaration
class PlaneContact(Contact):
    """Contact of a shell with a plane, beyond which all is solid. The law, its options and what is recorded: :class:`Contact`.

    Args:
        name: unique name.
        shell: the plate or shell.
        at: marker in the plane, on a rigid body or the ground.
        normal: direction out of the solid, in the axes of the marker's body.
    """

    name: str
    shell: InstanceOf[ShellBody]
    at: Marker
    normal: Direction = (0.0, 0.0, 1.0)

    def obstacle(self) -> Obstacle:
        """The half space."""
        normal = unit_axis(self.item, "normal", self.normal)
        return Obstacle(PLANE, 0.0, 0.0, 1.0, _centre(self.at), normal, _moves(self.at))


def _centre(at: Marker) -> tuple[float, float, float]:
    x, y, z = (float(c) for c in at.at)
    return x, y, z


def _moves(at: Marker) -> bool:
    return isinstance(at.body, RigidBody)
