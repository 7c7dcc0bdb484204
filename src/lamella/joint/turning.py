"""What acts on the angle or the displacement that a joint leaves free."""

from __future__ import annotations

from dataclasses import replace

from lamella.dofs import Build
from lamella.errors import DeclarationError
from lamella.joint.cylindrical import CylindricalJoint
from lamella.joint.hinge import EdgeHinge
from lamella.joint.prismatic import PrismaticJoint
from lamella.joint.revolute import RevoluteJoint
from lamella.measure.measure import Measure, MeasureSet, Term

TurningJoint = RevoluteJoint | CylindricalJoint | EdgeHinge
"""Joints that leave an angle free."""

SlidingJoint = PrismaticJoint | CylindricalJoint
"""Joints that leave a displacement free."""


def angle_shares(build: Build, joint: TurningJoint, middle: float = 0.0) -> list[Term]:
    """The angle of a joint as terms whose factors sum to 1: one for a joint of markers, several along a hinge.

    Along a hinge folded flat some shares read pi and others -pi: all are taken as the first is.

    Args:
        build: the build.
        joint: the joint; it must have been added to the system.
        middle: the angle in the reference configuration is taken within pi of it [rad].
    """
    terms = joint.turns_of(build)
    first = MeasureSet([(replace(terms[0], factor=1.0, centre=middle),)])
    first.evaluate(build.initial.reshape(-1))
    return [replace(term, centre=float(first.values[0])) for term in terms]


def joint_displacement(build: Build, joint: SlidingJoint) -> Measure:
    """The displacement of a joint along its axis."""
    return (joint.slide_of(build),)


def check_added(item: str, build: Build, joint: TurningJoint | SlidingJoint) -> None:
    """Refuse a joint that is not in the system."""
    if all(support.name != joint.name for support in build.supports):
        raise DeclarationError(item, f"the joint '{joint.name}' is not in the system", "accepted is a joint that has been added")
