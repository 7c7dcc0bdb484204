"""The clamp: position and slopes are held."""

from __future__ import annotations

import numpy as np
from pydantic import Field

from lamella.body.base import Marker
from lamella.body.plate import Edge
from lamella.declaration import declaration
from lamella.dofs import Build
from lamella.errors import DeclarationError
from lamella.joint.clamped_edge import Clamping, clamped_rows
from lamella.joint.rows import AXES, centre, hold_point
from lamella.kinematics import Frame, VectorRows
from lamella.math.profile import LengthProfile
from lamella.roles import Declaration


@declaration
class Clamp(Declaration):
    """Clamp an edge, or a point, of a plate: r, r_x, r_y (on an edge also r_xy, if the element has it) keep their values.

    Of an edge, less may be held: ``restrained`` keeps place and normal of the edge and lets the plate strain in its plane across
    it; ``sliding`` lets the edge grow along itself as well, its mean position and its line being held. A plate that is heated
    wants to strain where ``full`` allows none (see :data:`lamella.joint.clamped_edge.Clamping` for the rows).

    The constraints are linear and constant, so they are eliminated. The result holds the force ``<name>.force`` [N] and
    the torque ``<name>.torque`` [N m] about the middle of the edge that the support exerts on the plate.

    Args:
        name: unique name.
        on: an edge or a marker.
        motion: displacement [m] of the clamp along ``x``, ``y``, ``z`` of the inertial frame, each a function of time.
        kind: ``full``, ``restrained`` or ``sliding``; a marker takes ``full`` alone.
    """

    name: str
    on: Edge | Marker
    motion: dict[str, LengthProfile] = Field(default_factory=dict)
    kind: Clamping = "full"

    def __post_init__(self) -> None:
        if self.kind != "full" and isinstance(self.on, Marker):
            raise DeclarationError(
                f"Clamp '{self.name}'", f"kind '{self.kind}' of the point {self.on}", "accepted are an edge, or the kind 'full'"
            )
        if self.motion:
            check_axes(self, "".join(self.motion))

    def contribute(self, build: Build) -> None:
        """Hold what the kind says of the edge, or position and slopes of the point."""
        if isinstance(self.on, Marker):
            rows = hold_point(build, self.on, AXES, motions=self.motion)
            rows += hold_point(build, self.on, AXES, "slope_x") + hold_point(build, self.on, AXES, "slope_y")
        else:
            x, y, z = (VectorRows.fixed(axis) for axis in np.eye(3))
            space = Frame(VectorRows.fixed(np.zeros(3)), (x, y, z))
            rows = clamped_rows(f"Clamp '{self.name}'", build, self.on, space, self.kind, "in space", self.motion)
            if self.kind == "full":
                build.fully_clamped.append((self.name, self.on.body.name))
        build.hold(self.name, rows, centre(build, self.on), edge=not isinstance(self.on, Marker))


def check_axes(item: Declaration, axes: str) -> None:
    """Refuse anything but distinct letters x, y, z, at least one."""
    if not axes or len(set(axes)) != len(axes) or not set(axes) <= set(AXES):
        raise DeclarationError(
            f"{type(item).__name__} '{item.name}'", f"axes '{axes}'", "accepted are distinct letters of x, y and z, such as 'xz'"
        )
