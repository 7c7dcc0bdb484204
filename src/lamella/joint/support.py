"""Supports that hold positions and leave rotations free."""

from __future__ import annotations

from typing import Literal

import numpy as np
from pydantic import Field

from lamella.body.base import Marker
from lamella.body.plate import Edge
from lamella.declaration import declaration
from lamella.dofs import Build
from lamella.errors import DeclarationError
from lamella.joint.clamp import check_axes
from lamella.joint.rows import AXES, centre, hold_edge, hold_point
from lamella.math.profile import LengthProfile
from lamella.math.rotation import matrix_from_vector
from lamella.roles import Declaration
from lamella.units import Angle


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
    """Hold components of the position along a whole edge; rotation about the edge is free (simple support, hinged edge).

    Position and tangential slope of every node on the edge are held, so the cubic edge keeps its line in those components. The
    axes are the inertial ones, or oblique ones turned from them. A support that moves carries the edge without turning it.

    Args:
        name: unique name; the result holds ``<name>.force`` [N] and ``<name>.torque`` [N m] about the middle of the edge.
        on: the edge.
        axes: letters of the components held.
        rotation: rotation vector that turns the support's axes from the inertial ones [rad].
        motion: displacement [m] of the support along its axes, each a function of time; these axes must be held.
    """

    name: str
    on: Edge
    axes: str = "xyz"
    rotation: tuple[Angle, Angle, Angle] = (0.0, 0.0, 0.0)
    motion: dict[str, LengthProfile] = Field(default_factory=dict)

    def __post_init__(self) -> None:
        check_axes(self, self.axes)
        if not set(self.motion) <= set(self.axes):
            raise DeclarationError(
                f"EdgeSupport '{self.name}'",
                f"a motion along {', '.join(sorted(self.motion))} of an edge held along {', '.join(self.axes)}",
                "accepted are motions along axes that are held",
            )

    def contribute(self, build: Build) -> None:
        """Hold position and tangential slope at the edge's nodes."""
        turn = matrix_from_vector(np.asarray(self.rotation))
        held = {axis: turn[:, AXES.index(axis)] for axis in self.axes}
        along, _ = self.on.body.compiled(build).edge_slope(self.on.side)
        rows = [*hold_edge(build, self.on, "r", held, motions=self.motion), *hold_edge(build, self.on, along, held)]
        build.hold(self.name, rows, centre(build, self.on), edge=True)


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
    displacement: LengthProfile

    def contribute(self, build: Build) -> None:
        """Hold one component of the position at its reference value plus the displacement."""
        build.hold(
            self.name, hold_point(build, self.on, self.axis, motions={self.axis: self.displacement}), centre(build, self.on)
        )
