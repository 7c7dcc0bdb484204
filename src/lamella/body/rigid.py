"""Rigid bodies in natural coordinates."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from pydantic import Field

from lamella import units
from lamella.arguments import NUMBER, TEXT, accepts
from lamella.body.base import Body, Marker
from lamella.body.rigid_frame import RigidFrame, RigidInertia, unit_length_rows
from lamella.body.shape import Box, Cylinder, Sphere
from lamella.body.signals import marker_signals, rigid_signals
from lamella.declaration import declaration
from lamella.errors import DeclarationError
from lamella.kinematics import Frame, PointRows
from lamella.math.rotation import matrix_from_vector
from lamella.roles import Floats

if TYPE_CHECKING:
    from lamella.dofs import Build

Moments = tuple[units.Inertia, units.Inertia, units.Inertia]
Vector = tuple[units.Length, units.Length, units.Length]


@declaration
class RigidBody(Body):
    """A rigid body, described by the position p of its origin and its three axes d_1, d_2, d_3 as vectors.

        r = p + x d_1 + y d_2 + z d_3,      d_i . d_j = delta_ij

    In these natural coordinates (Garcia de Jalon and Bayo 1994) the mass matrix is constant and there are no gyroscopic terms;
    the six equations take multipliers. The result holds ``<name>.position``, ``.velocity``, ``.rotation`` (matrix R_WB row by
    row), ``.quaternion`` (w, x, y, z), ``.euler`` (yaw, pitch, roll about the turned axes z, y, x) and ``.angular_velocity``.

    Args:
        name: unique name.
        mass: mass [kg]; from ``shape`` and ``density`` when left out.
        inertia: moments of inertia I_xx, I_yy, I_zz about the centre of mass in the body's axes [kg m^2]; those of the evenly
            filled ``shape`` when left out.
        products: off-diagonal entries I_xy, I_xz, I_yz of the inertia matrix [kg m^2], -int x y dm and so on.
        centre_of_mass: in the body's axes, from its origin [m].
        position: of the body's origin in the inertial frame [m].
        rotation: rotation vector that turns the body's axes from the inertial ones [rad].
        velocity: initial velocity of the origin [m/s].
        angular_velocity: initial angular velocity in the inertial frame [rad/s].
        shape: a solid about the centre of mass, for pictures and for what is left out of mass and inertia.
        density: density of the shape [kg/m^3].
        markers: named points (x, y, z) in the body's axes [m]; each is recorded.
    """

    name: str
    mass: units.Mass | None = None
    inertia: Moments | None = None
    products: tuple[units.Product, units.Product, units.Product] = (0.0, 0.0, 0.0)
    centre_of_mass: Vector = (0.0, 0.0, 0.0)
    position: Vector = (0.0, 0.0, 0.0)
    rotation: tuple[units.Angle, units.Angle, units.Angle] = (0.0, 0.0, 0.0)
    velocity: tuple[units.Velocity, units.Velocity, units.Velocity] = (0.0, 0.0, 0.0)
    angular_velocity: tuple[units.AngularVelocity, units.AngularVelocity, units.AngularVelocity] = (0.0, 0.0, 0.0)
    shape: Box | Cylinder | Sphere | None = None
    density: units.Density | None = None
    markers: dict[str, Vector] = Field(default_factory=dict)

    has_axes = True

    def __post_init__(self) -> None:
        item = f"RigidBody '{self.name}'"
        if self.mass is None and (self.shape is None or self.density is None):
            raise DeclarationError(item, "its mass is not known", "accepted is 'mass', or 'density' together with 'shape'")
        if self.mass is not None and self.density is not None:
            raise DeclarationError(item, "both 'mass' and 'density' are given", "accepted is one of them")
        if self.inertia is None and self.shape is None:
            raise DeclarationError(item, "its inertia is not known", "accepted is 'inertia', or a 'shape' that is filled evenly")
        least = np.linalg.eigvalsh(self._second_moments())[0]
        if least < -1e-9 * np.abs(self.inertia_matrix()).max():
            moments = ", ".join(f"{value:g}" for value in np.linalg.eigvalsh(self.inertia_matrix()))
            raise DeclarationError(
                item,
                f"principal moments of inertia {moments} kg m^2 belong to no body",
                "accepted are moments of which none exceeds the sum of the two others",
            )

    @property
    def total_mass(self) -> float:
        """Mass [kg]."""
        if self.mass is not None:
            return self.mass
        assert self.shape is not None
        assert self.density is not None
        return self.shape.volume * self.density

    def inertia_matrix(self) -> Floats:
        """Inertia matrix about the centre of mass in the body's axes [kg m^2], shape (3, 3)."""
        diagonal = self.inertia
        if diagonal is None:
            assert self.shape is not None
            diagonal = self.total_mass * self.shape.gyration
        xy, xz, yz = self.products
        return np.diag(diagonal) + np.array([[0.0, xy, xz], [xy, 0.0, yz], [xz, yz, 0.0]])

    def _second_moments(self) -> Floats:
        """int x x^T dm about the centre of mass = tr(I)/2 1 - I, shape (3, 3)."""
        inertia = self.inertia_matrix()
        return 0.5 * np.trace(inertia) * np.eye(3) - inertia

    @accepts(name=TEXT, x=NUMBER, y=NUMBER, z=NUMBER)
    def marker(self, name: str, x: float, y: float, z: float) -> Marker:
        """A named point (x, y, z) [m] in the body's axes; it is recorded when the body is in a system."""
        at = (float(x), float(y), float(z))
        if self.markers.setdefault(name, at) != at:
            raise DeclarationError(
                f"RigidBody '{self.name}'", f"marker '{name}' is already at {self.markers[name]}", "use another name"
            )
        return Marker(self, name, at)

    @property
    def origin(self) -> Marker:
        """The body's origin as a marker."""
        return Marker(self, "origin", (0.0, 0.0, 0.0))

    def contribute(self, build: Build) -> None:
        """Number position and axes, and add inertia, the six equations of rigidity and signals."""
        turn = matrix_from_vector(np.asarray(self.rotation))
        q = np.vstack([self.position, turn.T])
        v = np.vstack([self.velocity, np.cross(self.angular_velocity, turn.T)])
        reach = max([1.0 if self.shape is None else 0.0, *(np.linalg.norm(at) for at in self.markers.values())])
        if self.shape is not None:
            reach = max(reach, np.abs(self.shape.surface()[0]).max())
        first = build.vectors(self.name, q, v, np.array([True, False, False, False]), np.array([reach, 1.0, 1.0, 1.0]))
        frame = RigidFrame(self.name, first, turn, self.shape, np.asarray(self.centre_of_mass))
        build.bodies[self.name] = frame
        build.inertias.append(RigidInertia(self.name, first, self.total_mass, frame.centre, self._second_moments()))
        build.tie(unit_length_rows(f"RigidBody '{self.name}'", frame.axes))
        build.signals.extend(rigid_signals(self.name, frame))
        for name, at in self.markers.items():
            build.signals.extend(marker_signals(name, f"{self.name}.{name}", frame.locate(at)))

    def compiled(self, build: Build) -> RigidFrame:
        """The compiled form of this body in a build."""
        frame = build.body(self.name)
        assert isinstance(frame, RigidFrame)
        return frame

    def locate(self, build: Build, at: tuple[float, ...]) -> PointRows:
        """Weights of position and axes at (x, y, z)."""
        return self.compiled(build).locate(at)

    def frame(self, build: Build, at: tuple[float, ...], axes: Floats) -> Frame:
        """A frame fixed in the body."""
        return self.compiled(build).frame(at, axes)
