"""The cylindrical joint."""

from __future__ import annotations

from lamella.body.base import Marker
from lamella.declaration import declaration
from lamella.joint.base import AxisJoint, Direction
from lamella.joint.equations import Rows, on_axis, parallel_axes
from lamella.kinematics import Frame


@declaration
class CylindricalJoint(AxisJoint):
    """Marker b slides along an axis fixed in a and turns about it (a shaft in a long bearing).

        (r_b - r_a) . x_a = (r_b - r_a) . y_a = 0,    z_a . x_b = z_a . y_b = 0

    Args:
        name: unique name.
        a: marker through which the axis runs (may be on the ground).
        b: marker on the axis.
        axis: direction of the axis in the reference configuration, inertial frame [-].
    """

    name: str
    a: Marker
    b: Marker
    axis: Direction = (0.0, 0.0, 1.0)

    meets, turns, slides = False, True, True

    def equations(self, a: Frame, b: Frame) -> Rows:
        return [*on_axis(self.name, a, b), *parallel_axes(self.name, a, b)]
