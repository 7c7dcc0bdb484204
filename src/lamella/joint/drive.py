"""Drives: the angle or the displacement of a joint as a function of time."""

from __future__ import annotations

from lamella.declaration import declaration
from lamella.dofs import Build, Motion, Signal
from lamella.joint.turning import SlidingJoint, TurningJoint, angle_shares, check_added, joint_displacement
from lamella.math.profile import AngleProfile, AngularVelocityProfile, Integral, LengthProfile, Profile, VelocityProfile
from lamella.measure.constraint import MeasureConstraint, MeasureRow
from lamella.measure.measure import Measure, MeasureSet
from lamella.roles import Declaration


@declaration
class AngleDrive(Declaration):
    """Turn a joint as a function of time: Phi = angle(q) - p(t) = 0.

    Given is the angle, or the speed, which is integrated in closed form. The angle of a joint of markers counts from the
    reference configuration, that of a hinge of plates from where the plates continue each other; a drive of a hinge moves the
    mean angle along the edge.

    Args:
        name: unique name; the result holds the driving torque ``<name>.torque`` [N m] on b.
        on: the joint.
        angle: angle p as a function of time [rad].
        speed: angular velocity as a function of time [rad/s], in place of the angle; the drive then begins at the joint's angle
            in the reference configuration.
    """

    name: str
    on: TurningJoint
    angle: AngleProfile | None = None
    speed: AngularVelocityProfile | None = None

    def __post_init__(self) -> None:
        _check_one(self.angle, self.speed, "angle")

    def contribute(self, build: Build) -> None:
        """Add one constraint and the driving torque."""
        check_added(f"AngleDrive '{self.name}'", build, self.on)
        measure = tuple(angle_shares(build, self.on))
        motion = _motion(build, measure, self.angle, self.speed)
        row = MeasureRow(f"the angle of '{self.on.name}'", measure, motion=motion, shared=True)
        _drive(build, self.name, row, "torque", "N m")


@declaration
class SlideDrive(Declaration):
    """Move a joint along its axis as a function of time: Phi = (r_b - r_a) . z_a - p(t) = 0.

    Args:
        name: unique name; the result holds the driving force ``<name>.force`` [N] on b.
        on: the joint.
        displacement: displacement p as a function of time [m].
        speed: speed as a function of time [m/s], in place of the displacement; the drive then begins at the joint's displacement
            in the reference configuration.
    """

    name: str
    on: SlidingJoint
    displacement: LengthProfile | None = None
    speed: VelocityProfile | None = None

    def __post_init__(self) -> None:
        _check_one(self.displacement, self.speed, "displacement")

    def contribute(self, build: Build) -> None:
        """Add one constraint and the driving force."""
        check_added(f"SlideDrive '{self.name}'", build, self.on)
        measure = joint_displacement(build, self.on)
        motion = _motion(build, measure, self.displacement, self.speed)
        _drive(build, self.name, MeasureRow(f"the displacement of '{self.on.name}'", measure, motion=motion), "force", "N")


def _check_one(place: Profile | None, speed: Profile | None, name: str) -> None:
    if (place is None) == (speed is None):
        given = f"neither '{name}' nor 'speed' is" if place is None else f"both '{name}' and 'speed' are"
        raise ValueError(f"{given} given; accepted is one of them")


def _motion(build: Build, measure: Measure, place: Profile | None, speed: Profile | None) -> Motion:
    """The prescribed value: as given, or the integral of the speed from the value in the reference configuration on."""
    if place is not None:
        return place
    found = MeasureSet([measure])
    found.evaluate(build.initial.reshape(-1))
    return Integral(of=speed, start=float(found.values[0]))  # type: ignore[arg-type]  # checked by Integral


def _drive(build: Build, name: str, row: MeasureRow, quantity: str, unit: str) -> None:
    """Add the constraint, and its multiplier as what drives."""
    block = MeasureConstraint(name, [row])
    build.constrain(block)
    description = f"driving {quantity} of {name}"
    build.signals.append(Signal(f"{name}.{quantity}", unit, (), lambda state: -float(state.lam[block.first]), description))
