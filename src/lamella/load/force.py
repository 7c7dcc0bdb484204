"""Forces at points, along edges and over surfaces, fixed in the inertial frame; at points also such as turn with the body."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from pydantic import InstanceOf

from lamella import units
from lamella.body.base import Marker
from lamella.body.plate import Edge
from lamella.body.quadrature import edge_quadrature, surface_integrals
from lamella.body.shell_body import ShellBody
from lamella.declaration import declaration
from lamella.load.dead import add_dead_load
from lamella.load.follower import FollowerForceBlock
from lamella.load.record import add_load
from lamella.math.profile import Constant, Profile
from lamella.roles import Declaration

if TYPE_CHECKING:
    from lamella.dofs import Build


@declaration
class PointForce(Declaration):
    """A force at a marker: Q = S(x, y)^T F p(t), or Q = S^T R F p(t) with the rotation R of the marker's axes.

    The axes of a follower force are the inertial axes in the reference configuration and turn with the body, as a thruster does.
    On a plate they turn with the normal and, about it, with the mean of the tangents at the marker.

    Args:
        name: unique name; the result holds ``<name>.factor``.
        on: the marker.
        force: force vector F [N]: in the inertial frame, or with ``follower`` in axes that turn with the body.
        profile: factor p(t).
        follower: whether the force turns with the body.
    """

    name: str
    on: Marker
    force: tuple[units.Force, units.Force, units.Force]
    profile: Profile = Constant(1.0)
    follower: bool = False

    def contribute(self, build: Build) -> None:
        """Add the force to the coordinate vectors that make the point."""
        rows = self.on.rows(build)
        if self.follower:
            x, y, z = self.on.frame(build, np.eye(3)).axes
            turned = self.force[0] * x + self.force[1] * y + self.force[2] * z
            add_load(build, FollowerForceBlock(self.name, rows.point, turned, self.profile), self.profile)
            return
        add_dead_load(build, self.name, rows.vectors, np.outer(rows.position, self.force), self.profile)


@declaration
class EdgeForce(Declaration):
    """A force per length along an edge: Q = int S^T f p(t) ds over the reference length.

    Args:
        name: unique name; the result holds ``<name>.factor``.
        on: the edge.
        force: force per reference length f in the inertial frame [N/m].
        profile: factor p(t).
    """

    name: str
    on: Edge
    force: tuple[units.ForcePerLength, units.ForcePerLength, units.ForcePerLength]
    profile: Profile = Constant(1.0)

    def contribute(self, build: Build) -> None:
        """Integrate the edge by its length in the reference configuration."""
        rows, weights = edge_quadrature(self.on.body.compiled(build), self.on.side, build.initial)
        vectors = np.concatenate([row.vectors for row in rows])
        lengths = np.concatenate([weight * row.position for weight, row in zip(weights.reshape(-1), rows, strict=True)])
        add_dead_load(build, self.name, vectors, np.outer(lengths, self.force), self.profile)


@declaration
class SurfaceForce(Declaration):
    """A force per area over a plate: Q = int S^T f p(t) dA over the reference area.

    Args:
        name: unique name; the result holds ``<name>.factor``.
        on: the plate.
        force: force per reference area f in the inertial frame [Pa].
        profile: factor p(t).
    """

    name: str
    on: InstanceOf[ShellBody]
    force: tuple[units.Pressure, units.Pressure, units.Pressure]
    profile: Profile = Constant(1.0)

    def contribute(self, build: Build) -> None:
        """Integrate the plate by its area in the reference configuration."""
        vectors, areas = surface_integrals(self.on.compiled(build), build.initial)
        add_dead_load(build, self.name, vectors.reshape(-1), np.outer(areas, self.force), self.profile)
