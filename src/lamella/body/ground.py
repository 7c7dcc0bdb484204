"""The inertial frame as a body, so that joints can end in fixed points of space."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from pydantic import Field

from lamella.arguments import NUMBER, TEXT, accepts
from lamella.body.base import Body, Marker
from lamella.declaration import declaration
from lamella.errors import DeclarationError
from lamella.kinematics import Frame, PointRows, VectorRows
from lamella.roles import Floats
from lamella.units import Length

if TYPE_CHECKING:
    from lamella.dofs import Build


@declaration
class Ground(Body):
    """The inertial frame. It has no coordinates.

    Args:
        name: name of the body.
        markers: named points fixed in space [m].
    """

    name: str = "ground"
    markers: dict[str, tuple[Length, Length, Length]] = Field(default_factory=dict)

    has_axes = True

    @accepts(name=TEXT, x=NUMBER, y=NUMBER, z=NUMBER)
    def marker(self, name: str, x: float, y: float, z: float) -> Marker:
        """A named point (x, y, z) [m] fixed in space."""
        at = (float(x), float(y), float(z))
        if self.markers.setdefault(name, at) != at:
            raise DeclarationError(
                f"Ground '{self.name}'", f"marker '{name}' is already at {self.markers[name]}", "use another name"
            )
        return Marker(self, name, at)

    @property
    def origin(self) -> Marker:
        """The origin of the inertial frame as a marker."""
        return Marker(self, "origin", (0.0, 0.0, 0.0))

    def contribute(self, build: Build) -> None:
        """The ground adds nothing."""
        build.bodies[self.name] = self

    def locate(self, build: Build, at: tuple[float, ...]) -> PointRows:
        """A constant point."""
        none = np.zeros(0)
        return PointRows(np.zeros(0, dtype=np.int64), none, none, none, np.asarray(at, float))

    def frame(self, build: Build, at: tuple[float, ...], axes: Floats) -> Frame:
        """A frame fixed in space."""
        x, y, z = (VectorRows.fixed(axis) for axis in np.asarray(axes).T)
        return Frame(VectorRows.fixed(np.asarray(at, float)), (x, y, z))
