"""Surfaces of revolution: cylinder, belt, cone, sphere and annulus.

Their axis is z and angles count from the x axis towards the y axis. With the distance rho(s) from the axis and the height z(s)
along the meridian, and one parameter along the angle phi = phi_0 + p / R, a point is

    r = (rho cos phi, rho sin phi, z)
"""

from __future__ import annotations

from abc import abstractmethod
from typing import Literal

import numpy as np

from lamella.declaration import declaration
from lamella.errors import DeclarationError
from lamella.roles import Floats
from lamella.surface.base import Surface, SurfacePoints
from lamella.units import Angle, Thickness

FULL_TURN = (0.0, 2.0 * np.pi)
Meridian = tuple[Floats, Floats, Floats, Floats]
"""rho, z [m] and their derivatives by s [-]."""


class Revolution(Surface):
    """What surfaces of revolution share; x runs around the axis and y along the meridian, unless a surface says otherwise."""

    angle: tuple[float, float]
    closed: bool

    @property
    @abstractmethod
    def around(self) -> float:
        """Radius R at which the parameter of the angle is an arc length [m]."""

    @property
    @abstractmethod
    def along(self) -> float:
        """Length of the meridian [m]."""

    @abstractmethod
    def meridian(self, s: Floats) -> Meridian:
        """The meridian at the length s [m]."""

    @property
    def size(self) -> tuple[float, float]:
        return (self.around * (self.angle[1] - self.angle[0]), self.along)

    @property
    def loops(self) -> tuple[bool, bool]:
        return (self.closed, False)

    def at(self, x: Floats, y: Floats) -> SurfacePoints:
        rho, z, d_rho, d_z = self.meridian(y)
        phi = self.angle[0] + x / self.around
        outward = np.stack([np.cos(phi), np.sin(phi), np.zeros_like(phi)], axis=1)
        forward = np.stack([-np.sin(phi), np.cos(phi), np.zeros_like(phi)], axis=1)
        up = np.array([0.0, 0.0, 1.0])
        return SurfacePoints(
            rho[:, None] * outward + z[:, None] * up,
            (rho / self.around)[:, None] * forward,
            d_rho[:, None] * outward + d_z[:, None] * up,
            (d_rho / self.around)[:, None] * forward,
        )

    def _check_angle(self) -> None:
        """Refuse angles that do not grow, overlap, or do not close where they should."""
        item, span = type(self).__name__, self.angle[1] - self.angle[0]
        if not 0.0 < span <= 2.0 * np.pi * (1.0 + 1e-12):
            raise DeclarationError(
                item,
                f"angle from {self.angle[0]:g} to {self.angle[1]:g} rad",
                "accepted is an angle that grows by up to one turn",
            )
        if self.closed and abs(span - 2.0 * np.pi) > 1e-9:
            raise DeclarationError(
                item,
                f"closed, but its ends do not meet: the angle spans {np.degrees(span):g} deg",
                "accepted is a full turn of 360 deg, or closed: false",
            )


@declaration
class CylinderSurface(Revolution):
    """A circular cylinder: x is the arc length around, y the height along the axis z; the normal points outward.

    Args:
        radius: of the reference surface [m].
        length: along the axis [m].
        angle: where the surface begins and ends around the axis [rad].
        closed: whether the ends of a full turn are joined.
    """

    radius: Thickness
    length: Thickness
    angle: tuple[Angle, Angle] = FULL_TURN
    closed: bool = False
    kind: Literal["cylinder"] = "cylinder"

    def __post_init__(self) -> None:
        """Refuse impossible angles."""
        self._check_angle()

    @property
    def around(self) -> float:
        return self.radius

    @property
    def along(self) -> float:
        return self.length

    def meridian(self, s: Floats) -> Meridian:
        return np.full_like(s, self.radius), s, np.zeros_like(s), np.ones_like(s)


@declaration
class BeltSurface(Revolution):
    """A closed belt, a circular cylinder about z: x runs along the belt, y across it; the normal points outward.

    Args:
        length: of the belt, once around [m].
        width: [m].
    """

    length: Thickness
    width: Thickness
    kind: Literal["belt"] = "belt"
    angle = FULL_TURN
    closed = True

    @property
    def around(self) -> float:
        return self.length / (2.0 * np.pi)

    @property
    def along(self) -> float:
        return self.width

    def meridian(self, s: Floats) -> Meridian:
        return np.full_like(s, self.around), s, np.zeros_like(s), np.ones_like(s)


@declaration
class ConeSurface(Revolution):
    """A truncated circular cone: x runs around, an arc length at the mean radius; y is the length along the slant.

    The meridian begins at z = 0 with the first radius; with a height above zero the normal points outward.

    Args:
        radii: at the beginning and at the end of the meridian [m]; no apex, where the parameters degenerate.
        height: by which z grows along the meridian [m].
        angle: where the surface begins and ends around the axis [rad].
        closed: whether the ends of a full turn are joined.
    """

    radii: tuple[Thickness, Thickness]
    height: Thickness
    angle: tuple[Angle, Angle] = FULL_TURN
    closed: bool = False
    kind: Literal["cone"] = "cone"

    def __post_init__(self) -> None:
        """Refuse impossible angles."""
        self._check_angle()

    @property
    def around(self) -> float:
        return 0.5 * (self.radii[0] + self.radii[1])

    @property
    def along(self) -> float:
        return float(np.hypot(self.radii[1] - self.radii[0], self.height))

    def meridian(self, s: Floats) -> Meridian:
        d_rho, d_z = (self.radii[1] - self.radii[0]) / self.along, self.height / self.along
        return self.radii[0] + d_rho * s, d_z * s, np.full_like(s, d_rho), np.full_like(s, d_z)


@declaration
class SphereSurface(Revolution):
    """A part of a sphere: x runs around, an arc length at the equator; y is the arc length along the meridian, northwards.

    The normal points outward. The poles, where the parameters degenerate, are left out.

    Args:
        radius: of the reference surface [m].
        latitude: where the meridian begins and ends, above the equator [rad], within -90 and 90 deg.
        angle: where the surface begins and ends around the axis, the longitude [rad].
        closed: whether the ends of a full turn are joined.
    """

    radius: Thickness
    latitude: tuple[Angle, Angle]
    angle: tuple[Angle, Angle] = FULL_TURN
    closed: bool = False
    kind: Literal["sphere"] = "sphere"

    def __post_init__(self) -> None:
        """Refuse impossible angles, and poles."""
        self._check_angle()
        south, north = self.latitude
        if not -0.5 * np.pi < south < north < 0.5 * np.pi:
            raise DeclarationError(
                "SphereSurface",
                f"latitude from {np.degrees(south):g} to {np.degrees(north):g} deg",
                "accepted are ascending latitudes between -90 and 90 deg, without the poles, where all meridians meet",
            )

    @property
    def around(self) -> float:
        return self.radius

    @property
    def along(self) -> float:
        return self.radius * (self.latitude[1] - self.latitude[0])

    def meridian(self, s: Floats) -> Meridian:
        psi = self.latitude[0] + s / self.radius
        return self.radius * np.cos(psi), self.radius * np.sin(psi), -np.sin(psi), np.cos(psi)


@declaration
class AnnulusSurface(Revolution):
    """A flat ring in the plane z = 0: x is the distance from the inner edge, y runs around, an arc length at the mean radius.

    The normal is z. A full turn that is not closed is a slit ring, whose two edges lie upon each other.

    Args:
        radii: of the inner and the outer edge [m].
        angle: where the surface begins and ends around the axis [rad].
        closed: whether the ends of a full turn are joined.
    """

    radii: tuple[Thickness, Thickness]
    angle: tuple[Angle, Angle] = FULL_TURN
    closed: bool = False
    kind: Literal["annulus"] = "annulus"

    def __post_init__(self) -> None:
        """Refuse impossible angles and radii."""
        self._check_angle()
        if not self.radii[0] < self.radii[1]:
            raise DeclarationError(
                "AnnulusSurface",
                f"radii = {self.radii[0]:g}, {self.radii[1]:g}",
                "accepted is the inner radius, then the outer one",
            )

    @property
    def around(self) -> float:
        return 0.5 * (self.radii[0] + self.radii[1])

    @property
    def along(self) -> float:
        return self.radii[1] - self.radii[0]

    @property
    def size(self) -> tuple[float, float]:
        around, along = super().size
        return along, around

    @property
    def loops(self) -> tuple[bool, bool]:
        return (False, self.closed)

    def meridian(self, s: Floats) -> Meridian:
        return self.radii[0] + s, np.zeros_like(s), np.ones_like(s), np.zeros_like(s)

    def at(self, x: Floats, y: Floats) -> SurfacePoints:
        turned = super().at(y, x)
        return SurfacePoints(turned.r, turned.r_y, turned.r_x, turned.r_xy)
