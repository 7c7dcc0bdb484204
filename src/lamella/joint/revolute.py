"""The revolute joint."""

from __future__ import annotations

from lamella.body.base import Marker
from lamella.declaration import declaration
from lamella.joint.base import AxisJoint, Direction
from lamella.joint.equations import Rows, coincident, parallel_axes
from lamella.kinematics import Frame


@declaration
class RevoluteJoint(AxisJoint):
    """Two markers coincide and b turns about an axis only (a pin).

        r_b - r_a = 0,    z_a . x_b = z_a . y_b = 0

    Args:
        name: unique name.
        a: first marker (may be on the ground).
        b: second marker.
        axis: direction of the axis in the reference configuration, inertial frame [-].
    """

    name: str
    a: Marker
    b: Marker
    axis: Direction = (0.0, 0.0, 1.0)

    turns = True

    def equations(self, a: Frame, b: Frame) -> Rows:
        return [*coincident(self.name, a, b), *parallel_axes(self.name, a, b)]
