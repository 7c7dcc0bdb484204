"""Moments at points and along edges of plates."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from lamella import units
from lamella.body.base import Marker
from lamella.body.plate import Edge
from lamella.body.quadrature import N_GAUSS, edge_quadrature
from lamella.declaration import declaration
from lamella.errors import DeclarationError
from lamella.load.moment_block import MomentBlock
from lamella.load.moment_kernels import ALONG_X, ALONG_Y, FIXED, MATERIAL
from lamella.load.record import add_load
from lamella.math.profile import Constant, Profile
from lamella.roles import Declaration

if TYPE_CHECKING:
    from lamella.dofs import Build


@declaration
class PointMoment(Declaration):
    """A moment at a marker of a plate or a rigid body, of virtual work m . delta w.

    w is the angular velocity of the material frame (t1, t2, n0), on a rigid body that of the body:

    w = n0 x n0' + 1/2 sum_i n0.(a_i x a_i')/|a_i|^2 n0,      a_1 = r_x, a_2 = r_y

    The normal's turning is that of Kirchhoff's theory; about the normal (drilling) it is the mean turning of the two tangents.
    t1 and t2 lie in the tangent plane symmetrically to the tangents, on them where r_x and r_y are orthogonal. A concentrated
    moment has no mesh limit of the rotation under it (a logarithmic singularity of plate theory); use an edge moment for that.

    Args:
        name: unique name; the result holds ``<name>.factor``.
        on: the marker.
        moment: moment vector [N m]: in the inertial frame, or with ``follower`` in the axes t1, t2, n0.
        profile: factor p(t).
        follower: whether the moment turns with the material.
    """

    name: str
    on: Marker
    moment: tuple[units.Torque, units.Torque, units.Torque]
    profile: Profile = Constant(1.0)
    follower: bool = False

    def contribute(self, build: Build) -> None:
        """Add the moment through the tangents at the marker."""
        rows = self.on.rows(build)
        if not (np.any(rows.slope_x) and np.any(rows.slope_y)):
            raise DeclarationError(
                f"PointMoment '{self.name}'",
                f"{self.on} has no tangents to turn",
                "accepted is a marker of a plate or a rigid body",
            )
        kind = MATERIAL if self.follower else FIXED
        add_load(build, MomentBlock(self.name, [[rows]], np.ones((1, 1)), kind, self.moment, self.profile), self.profile)


@declaration
class EdgeMoment(Declaration):
    """A moment per length along an edge of a plate: virtual work int m . delta w ds over the reference length.

    Either ``moment`` or ``bending`` is given. The angular velocity w is that of :class:`PointMoment`.

    Args:
        name: unique name; the result holds ``<name>.factor``.
        on: the edge.
        moment: moment vector per reference length [N]: in the inertial frame, or with ``follower`` in the axes t1, t2, n0.
        profile: factor p(t).
        follower: whether ``moment`` turns with the material.
        bending: moment per reference length [N] about the edge's current tangent, right-handed about the direction in which y
            (on the edges x- and x+) or x (on y- and y+) grows; it always follows the edge.
    """

    name: str
    on: Edge
    moment: tuple[units.TorquePerLength, units.TorquePerLength, units.TorquePerLength] | None = None
    profile: Profile = Constant(1.0)
    follower: bool = False
    bending: units.TorquePerLength | None = None

    def __post_init__(self) -> None:
        """Refuse both or none of the two ways to give the moment."""
        if (self.moment is None) == (self.bending is None):
            given = "neither 'moment' nor 'bending' is" if self.moment is None else "both 'moment' and 'bending' are"
            raise ValueError(f"{given} given; accepted is one of them")

    def contribute(self, build: Build) -> None:
        """Integrate the edge by its length in the reference configuration, exact where a straight edge turns as a rigid body."""
        rows, weights = edge_quadrature(self.on.body.compiled(build), self.on.side, build.initial)
        groups = [rows[first : first + N_GAUSS] for first in range(0, len(rows), N_GAUSS)]
        if self.moment is not None:
            kind, components = (MATERIAL if self.follower else FIXED), self.moment
        else:
            kind, components = (ALONG_Y if self.on.side[0] == "x" else ALONG_X), (self.bending or 0.0, 0.0, 0.0)
        add_load(build, MomentBlock(self.name, groups, weights, kind, components, self.profile), self.profile)
