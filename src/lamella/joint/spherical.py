"""The spherical joint."""

from __future__ import annotations

from lamella.body.base import Marker
from lamella.declaration import declaration
from lamella.joint.base import Joint
from lamella.joint.equations import Rows, coincident
from lamella.kinematics import Frame


@declaration
class SphericalJoint(Joint):
    """Two markers coincide; the bodies turn freely about them (a ball and socket).

        r_b - r_a = 0

    The rows are linear and eliminated, so the joint is exact and costs nothing.

    Args:
        name: unique name.
        a: first marker (may be on the ground).
        b: second marker.
    """

    name: str
    a: Marker
    b: Marker

    axes_of = ""

    def equations(self, a: Frame, b: Frame) -> Rows:
        return coincident(self.name, a, b)
