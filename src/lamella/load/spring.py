"""Springs and dampers between points, and about or along joints."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from lamella import units
from lamella.body.base import Marker
from lamella.declaration import declaration
from lamella.dofs import Build, Signal
from lamella.errors import DeclarationError
from lamella.joint.turning import SlidingJoint, TurningJoint, angle_shares, check_added, joint_displacement
from lamella.math.profile import AngleProfile, Constant, ForceProfile, LengthProfile, TorqueProfile
from lamella.measure.force import MeasureForce
from lamella.measure.law import Law, SpringLaw
from lamella.measure.measure import Measure, length
from lamella.roles import Declaration
from lamella.state import State


@declaration
class SpringDamper(Declaration):
    """A spring and a damper between two markers: tension F = k (L - L_0(t)) + c L' + F_0(t) along their distance L.

    Args:
        name: unique name; the result holds ``<name>.tension`` [N], positive when it pulls, and ``<name>.length`` [m].
        a: first marker (may be on the ground).
        b: second marker.
        stiffness: k [N/m].
        damping: c [N s/m].
        rest_length: unstressed length L_0 as a function of time [m]; the initial distance when left out.
        preload: further tension F_0 as a function of time [N]: an actuator.
    """

    name: str
    a: Marker
    b: Marker
    stiffness: units.Stiffness = 0.0
    damping: units.Damping = 0.0
    rest_length: LengthProfile | None = None
    preload: ForceProfile = Constant(0.0)

    def contribute(self, build: Build) -> None:
        """Add one force and its signals."""
        d = self.b.rows(build).point - self.a.rows(build).point
        distance = float(np.linalg.norm(d.at(build.initial)))
        if distance == 0.0:
            raise DeclarationError(
                f"SpringDamper '{self.name}'", f"{self.a} and {self.b} coincide", "accepted are distinct points"
            )
        law = SpringLaw(self.stiffness, self.damping, self.rest_length or Constant(distance), self.preload)
        add_measure_force(build, MeasureForce(self.name, [(length(d),)], np.ones(1), law), ("tension", "N"), ("length", "m"))


@declaration
class TorsionSpring(Declaration):
    """A spring and a damper about the axis of a joint: torque T = k (phi - phi_0(t)) + c phi' + T_0(t) against its angle phi.

    Along a hinge of plates the spring is spread evenly over the edge, or over the points of the hinge. A negative T_0 drives the
    angle up, as the wound springs of deployable structures do.

    Args:
        name: unique name; the result holds ``<name>.torque`` [N m], which acts against a growing angle, and ``<name>.angle``.
        on: the joint.
        stiffness: k [N m/rad].
        damping: c [N m s/rad].
        rest_angle: unstressed angle phi_0 as a function of time [rad].
        preload: further torque T_0 as a function of time [N m].
        middle: the angle in the reference configuration is taken within pi of it [rad]: says whether a hinge folded flat is at pi
            or at -pi. From there the angle counts turns.
    """

    name: str
    on: TurningJoint
    stiffness: units.TorsionalStiffness = 0.0
    damping: units.TorsionalDamping = 0.0
    rest_angle: AngleProfile = Constant(0.0)
    preload: TorqueProfile = Constant(0.0)
    middle: units.Angle = 0.0

    def contribute(self, build: Build) -> None:
        """Add the shares of the spring along the joint and its signals."""
        check_added(f"TorsionSpring '{self.name}'", build, self.on)
        law = SpringLaw(self.stiffness, self.damping, self.rest_angle, self.preload)
        add_measure_force(build, turning_force(build, self.name, self.on, law, self.middle), ("torque", "N m"), ("angle", "rad"))


@declaration
class SlideSpring(Declaration):
    """A spring and a damper along the axis of a joint: F = k (s - s_0(t)) + c s' + F_0(t) against its displacement s.

    Args:
        name: unique name; the result holds ``<name>.force`` [N], which acts against a growing displacement, and
            ``<name>.displacement`` [m].
        on: the joint.
        stiffness: k [N/m].
        damping: c [N s/m].
        rest: unstressed displacement s_0 as a function of time [m].
        preload: further force F_0 as a function of time [N].
    """

    name: str
    on: SlidingJoint
    stiffness: units.Stiffness = 0.0
    damping: units.Damping = 0.0
    rest: LengthProfile = Constant(0.0)
    preload: ForceProfile = Constant(0.0)

    def contribute(self, build: Build) -> None:
        """Add one force and its signals."""
        check_added(f"SlideSpring '{self.name}'", build, self.on)
        law = SpringLaw(self.stiffness, self.damping, self.rest, self.preload)
        block = MeasureForce(self.name, [joint_displacement(build, self.on)], np.ones(1), law)
        add_measure_force(build, block, ("force", "N"), ("displacement", "m"))


def turning_force(build: Build, name: str, joint: TurningJoint, law: Law, middle: float = 0.0) -> MeasureForce:
    """A law about a joint, shared among the places where the joint turns."""
    terms = angle_shares(build, joint, middle)
    measures: list[Measure] = [(replace(term, factor=1.0),) for term in terms]
    return MeasureForce(name, measures, np.array([term.factor for term in terms]), law)


def add_measure_force(build: Build, block: MeasureForce, force: tuple[str, str], measure: tuple[str, str]) -> None:
    """Add a force and record it, summed over its shares, and its measure, averaged over them; each as name and unit."""
    build.forces.append(block)
    build.breakpoints.extend(block.law.breakpoints)

    def total(state: State) -> float:
        return float(block.shares @ block.answers(state.t, state.q, state.v))

    def mean(state: State) -> float:
        block.measures.evaluate(state.q)
        return float(block.shares @ block.measures.values)

    build.signals.append(Signal(f"{block.name}.{force[0]}", force[1], (), total, f"{force[0]} of {block.name}"))
    build.signals.append(Signal(f"{block.name}.{measure[0]}", measure[1], (), mean, f"{measure[0]} of {block.name}"))
