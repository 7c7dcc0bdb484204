"""The clamp: position and slopes are held."""

from __future__ import annotations

from pydantic import Field

from lamella.body.base import Marker
from lamella.body.plate import Edge
from lamella.declaration import declaration
from lamella.dofs import Build
from lamella.joint.rows import AXES, centre, hold_edge, hold_point
from lamella.math.profile import Profile
from lamella.roles import Declaration


@declaration
class Clamp(Declaration):
    """Clamp an edge, or a point, of a plate: r, r_x, r_y (and r_xy on an edge) keep their reference values.

    The constraints are linear and constant, so they are eliminated. The result holds the force ``<name>.force`` [N] and
    the torque ``<name>.torque`` [N m] about the middle of the edge that the support exerts on the plate.

    Args:
        name: unique name.
        on: an edge or a marker.
        motion: displacement [m] of the clamp along ``x``, ``y``, ``z`` of the inertial frame, each a function of time.
    """

    name: str
    on: Edge | Marker
    motion: dict[str, Profile] = Field(default_factory=dict)

    def __post_init__(self) -> None:
        if self.motion:
            check_axes(self, "".join(self.motion))

    def contribute(self, build: Build) -> None:
        """Hold all coordinate vectors of the edge, or position and slopes of the point."""
        if isinstance(self.on, Marker):
            rows = hold_point(build, self.on, AXES, motions=self.motion)
            rows += hold_point(build, self.on, AXES, "slope_x") + hold_point(build, self.on, AXES, "slope_y")
        else:
            rows = hold_edge(build, self.on, self.on.body.compiled(build).element.vector_names, AXES, self.motion)
        build.hold(self.name, rows, centre(build, self.on), edge=not isinstance(self.on, Marker))


def check_axes(item: Declaration, axes: str) -> None:
    """Refuse anything but distinct letters x, y, z, at least one."""
    from lamella.errors import DeclarationError

    if not axes or len(set(axes)) != len(axes) or not set(axes) <= set(AXES):
        raise DeclarationError(
            f"{type(item).__name__} '{item.name}'", f"axes '{axes}'", "accepted are distinct letters of x, y and z, such as 'xz'"
        )
