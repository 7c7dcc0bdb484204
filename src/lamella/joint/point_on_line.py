"""Joints that guide a point: on a line, in a plane."""

from __future__ import annotations

from lamella.body.base import Marker
from lamella.declaration import declaration
from lamella.joint.base import AxisJoint, Direction
from lamella.joint.equations import Rows, Z, on_axis
from lamella.kinematics import Frame


@declaration
class PointOnLineJoint(AxisJoint):
    """Marker b stays on a line fixed in a; the bodies turn freely (a ball in a straight groove).

        (r_b - r_a) . x_a = (r_b - r_a) . y_a = 0

    Args:
        name: unique name.
        a: marker through which the line runs (may be on the ground).
        b: marker on the line.
        axis: direction of the line in the reference configuration, inertial frame [-].
    """

    name: str
    a: Marker
    b: Marker
    axis: Direction = (0.0, 0.0, 1.0)

    axes_of, meets, slides = "a", False, True

    def equations(self, a: Frame, b: Frame) -> Rows:
        return on_axis(self.name, a, b)


@declaration
class PointInPlaneJoint(AxisJoint):
    """Marker b stays in a plane fixed in a; the bodies turn freely.

        (r_b - r_a) . z_a = 0

    Args:
        name: unique name.
        a: marker in the plane (may be on the ground).
        b: marker that stays in the plane.
        axis: normal of the plane in the reference configuration, inertial frame [-].
    """

    name: str
    a: Marker
    b: Marker
    axis: Direction = (0.0, 0.0, 1.0)

    axes_of, meets = "a", False

    def equations(self, a: Frame, b: Frame) -> Rows:
        return on_axis(self.name, a, b, (Z,))
