"""Supports that hold positions and leave rotations free."""

from __future__ import annotations

from typing import Literal

from lamella.body.base import Marker
from lamella.body.plate import Edge
from lamella.declaration import declaration
from lamella.dofs import Build
from lamella.joint.clamp import check_axes
from lamella.joint.rows import centre, hold_edge, hold_point
from lamella.math.profile import Profile
from lamella.roles import Declaration


@declaration
class PointSupport(Declaration):
    """Hold the position of a marker along some axes of the inertial frame; rotations are free (a pin, a ball joint to ground).

    Args:
        name: unique name; the result holds ``<name>.force`` [N], which the support exerts on the body.
        on: the marker.
        axes: letters of the components held.
    """

    name: str
    on: Marker
    axes: str = "xyz"

    def __post_init__(self) -> None:
        check_axes(self, self.axes)

    def contribute(self, build: Build) -> None:
        """Hold components of the position."""
        build.hold(self.name, hold_point(build, self.on, self.axes), centre(build, self.on))


@declaration
class EdgeSupport(Declaration):
    """Hold components of the position along a whole edge; rotation about the edge is free (simple support).

    Position and tangential slope of every node on the edge are held, so the cubic edge stays straight in those components.

    Args:
        name: unique name; the result holds ``<name>.force`` [N] and ``<name>.torque`` [N m] about the middle of the edge.
        on: the edge.
        axes: letters of the components held.
    """

    name: str
    on: Edge
    axes: str = "xyz"

    def __post_init__(self) -> None:
        check_axes(self, self.axes)

    def contribute(self, build: Build) -> None:
        """Hold position and tangential slope at the edge's nodes."""
        along, _ = self.on.body.compiled(build).edge_slope(self.on.side)
        build.hold(self.name, hold_edge(build, self.on, ("r", along), self.axes), centre(build, self.on), edge=True)


@declaration
class PrescribedMotion(Declaration):
    """Move a marker along one axis of the inertial frame by a given displacement from its reference position.

    Args:
        name: unique name; the result holds the driving force ``<name>.force`` [N].
        on: the marker.
        axis: ``x``, ``y`` or ``z``.
        displacement: displacement [m] as a function of time.
    """

    name: str
    on: Marker
    axis: Literal["x", "y", "z"]
    displacement: Profile

    def contribute(self, build: Build) -> None:
        """Hold one component of the position at its reference value plus the displacement."""
        build.hold(
            self.name, hold_point(build, self.on, self.axis, motions={self.axis: self.displacement}), centre(build, self.on)
        )
