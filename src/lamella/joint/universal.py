"""The universal joint."""

from __future__ import annotations

from lamella.body.base import Marker
from lamella.declaration import declaration
from lamella.joint.base import Direction, Joint
from lamella.joint.equations import Rows, X, Y, axes_along, coincident, perpendicular
from lamella.kinematics import Frame
from lamella.roles import Floats


@declaration
class UniversalJoint(Joint):
    """Two markers coincide and two crossed axes, one of each body, stay perpendicular (a Cardan or Hooke joint).

        r_b - r_a = 0,    x_a . y_b = 0

    Args:
        name: unique name.
        a: first marker (may be on the ground); the cross turns in it about ``axis_a``.
        b: second marker; it turns on the cross about ``axis_b``.
        axis_a: direction of the first axis in the reference configuration, inertial frame [-].
        axis_b: direction of the second axis [-]; only its part perpendicular to ``axis_a`` counts.
    """

    name: str
    a: Marker
    b: Marker
    axis_a: Direction = (1.0, 0.0, 0.0)
    axis_b: Direction = (0.0, 1.0, 0.0)

    def axes(self) -> Floats:
        z_x_y = axes_along(self.item, self.axis_a, self.axis_b)
        return z_x_y[:, [2, 0, 1]]

    def equations(self, a: Frame, b: Frame) -> Rows:
        return [*coincident(self.name, a, b), perpendicular(self.name, a, X, b, Y)]
