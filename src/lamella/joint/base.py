"""What joints between two markers have in common."""

from __future__ import annotations

from abc import abstractmethod
from typing import Any, ClassVar, Literal

import numpy as np

from lamella import units
from lamella.body.base import Marker
from lamella.dofs import Build
from lamella.errors import DeclarationError
from lamella.joint.equations import Rows, axes_along, check_coincide, check_guided
from lamella.joint.motion_signals import angle_signals, slide_signals
from lamella.kinematics import Frame, VectorRows
from lamella.measure.measure import Term, angle, slide
from lamella.roles import Declaration, Floats

Direction = tuple[units.Number, units.Number, units.Number]

Axis = Literal["x", "y", "z"] | Direction
"""A direction in the inertial frame: one of its axes by its letter, or a vector of any length."""


class Joint(Declaration):
    """A joint between a marker ``a`` and a marker ``b`` of another body.

    1. Each marker carries a joint frame that moves with its body; in the reference configuration both frames have the axes
       ``axes()``.
    2. ``equations`` lists what the frames have in common. Rows that come out linear are eliminated, the others take
       multipliers.
    3. The result holds the force ``<name>.force`` [N] and torque ``<name>.torque`` [N m] that the joint exerts on the body of b,
       the torque about b's marker, in the inertial frame, and the same in a's joint frame as ``<name>.force_local`` and
       ``<name>.torque_local`` (a point of a plate whose axes play no part gets axes fixed in space).
    4. Where b can turn about or slide along z, the result also holds ``<name>.angle`` [rad] and ``<name>.rate`` [rad/s], or
       ``<name>.displacement`` [m] and ``<name>.speed`` [m/s].
    """

    a: Any
    b: Any
    """Markers, which each joint declares (the fixed joint takes edges as well)."""
    axes_of: ClassVar[str] = "ab"
    """Whose axes the equations use; a point of a plate gets no axes for nothing, they would cost nine multipliers."""
    meets: ClassVar[bool] = True
    """Whether the markers must coincide in the reference configuration."""
    turns: ClassVar[bool] = False
    """Whether b may turn about z, and not about another axis."""
    slides: ClassVar[bool] = False
    """Whether b may slide along z, and in no other direction."""

    @abstractmethod
    def equations(self, a: Frame, b: Frame) -> Rows:
        """The rows of the joint."""

    def axes(self) -> Floats:
        """Axes of the joint frames in the reference configuration as columns, shape (3, 3)."""
        return np.eye(3)

    @property
    def item(self) -> str:
        """The joint in messages."""
        return f"{type(self).__name__} '{self.name}'"

    def frames(self, build: Build) -> tuple[Frame, Frame]:
        """The joint frames on both bodies."""
        axes = self.axes()
        a, b = (
            marker.frame(build, axes) if side in self.axes_of or marker.body.has_axes else point_frame(build, marker, axes)
            for side, marker in (("a", self.a), ("b", self.b))
        )
        return a, b

    def turns_of(self, build: Build) -> list[Term]:
        """The joint's angle about z, as terms whose factors sum to 1."""
        a, b = self.frames(build)
        return [angle(a.x, b.x, a.z)]

    def slide_of(self, build: Build) -> Term:
        """The joint's displacement along z."""
        a, b = self.frames(build)
        return slide(b.origin - a.origin, a.z)

    def contribute(self, build: Build) -> None:
        """Add the rows, the reaction, and what moves."""
        refuse_same_body(self.item, self.a, self.b)
        a, b = self.frames(build)
        rows = self.equations(a, b)
        if self.meets:
            check_coincide(self.item, build.initial, a.origin, b.origin, f"{self.a} and {self.b}", body_size(build))
        else:
            check_guided(self.item, build.initial, rows, body_size(build))
        build.hold(self.name, rows, b.origin, self.b.body.name, a)
        if self.turns:
            build.signals.extend(angle_signals(self.name, self.turns_of(build)[0]))
        if self.slides:
            build.signals.extend(slide_signals(self.name, self.slide_of(build)))


class AxisJoint(Joint):
    """A joint with an axis, the z axis of its frames; ``axis`` is its direction in the inertial frame at the reference."""

    axis: Direction

    def axes(self) -> Floats:
        return axes_along(self.item, self.axis)


def axes_with(item: str, axis: Axis) -> Floats:
    """Orthonormal axes as columns, shape (3, 3), whose z is along a direction."""
    x, y, z = np.eye(3)["xyz".index(axis)].tolist() if isinstance(axis, str) else axis
    return axes_along(item, (x, y, z))


def point_frame(build: Build, marker: Marker, axes: Floats) -> Frame:
    """A frame whose origin moves with a marker and whose axes are fixed in space."""
    x, y, z = (VectorRows.fixed(axis) for axis in axes.T)
    return Frame(marker.rows(build).point, (x, y, z))


def refuse_same_body(item: str, a: Marker, b: Marker) -> None:
    """A joint joins two bodies."""
    if a.body.name == b.body.name:
        raise DeclarationError(item, f"{a} and {b} are points of one body", "accepted are markers of two bodies")


def body_size(build: Build) -> float:
    """Size of the largest body [m]."""
    return max((float(m[p].max()) for m, p in zip(build.magnitude, build.is_position, strict=True) if p.any()), default=1.0)
