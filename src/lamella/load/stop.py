"""End stops and latches of joints."""

from __future__ import annotations

from math import inf
from typing import Annotated

from pydantic import Field

from lamella import units
from lamella.declaration import declaration
from lamella.dofs import Build, Signal
from lamella.joint.turning import TurningJoint, check_added
from lamella.load.spring import add_measure_force, turning_force
from lamella.measure.law import LatchLaw, StopLaw
from lamella.roles import Declaration
from lamella.state import State
from lamella.trigger import Trigger


@declaration
class EndStop(Declaration):
    """Stops that keep the angle of a joint between two bounds: a one-sided stiff spring with damping that never pulls.

    Beyond a bound, with the depth d: |T| = p(d) (1 + c_s d'), p = k d^2/(2 w) for d < w and k (d - w/2) beyond.

    Args:
        name: unique name; the result holds ``<name>.torque`` [N m], which acts against a growing angle.
        on: the joint.
        lower: smallest angle [rad]; none when left out.
        upper: largest angle [rad]; none when left out.
        stiffness: k [N m/rad].
        damping: c_s, the inverse of the angular velocity of approach that doubles the torque [s/rad].
        width: w, the angle over which the stop grows stiff [rad].
        middle: the angle in the reference configuration is taken within pi of it [rad]; from there it counts turns.
    """

    name: str
    on: TurningJoint
    stiffness: Annotated[units.TorsionalStiffness, Field(gt=0)]
    lower: units.Angle | None = None
    upper: units.Angle | None = None
    damping: Annotated[units.Number, Field(ge=0)] = 0.0
    width: Annotated[units.Angle, Field(gt=0)] = 1e-3
    middle: units.Angle = 0.0

    def __post_init__(self) -> None:
        if self.lower is None and self.upper is None:
            raise ValueError("neither 'lower' nor 'upper' is given; accepted is one of them or both")
        if self.lower is not None and self.upper is not None and self.lower >= self.upper:
            raise ValueError(f"lower = {self.lower:g} rad; accepted is less than upper = {self.upper:g} rad")

    def contribute(self, build: Build) -> None:
        """Add the stop's shares along the joint and its signals."""
        check_added(f"EndStop '{self.name}'", build, self.on)
        lower, upper = (-inf if self.lower is None else self.lower), (inf if self.upper is None else self.upper)
        law = StopLaw(lower, upper, self.stiffness, self.damping, self.width)
        add_measure_force(build, turning_force(build, self.name, self.on, law, self.middle), ("torque", "N m"), ("angle", "rad"))


@declaration
class Latch(Declaration):
    """A latch that locks a joint when its angle reaches a value: from then on a stiff spring and damper hold the angle there.

    The moment of locking is found in time to a small share of the step. Along a hinge of plates every place is held at the angle
    it has at that moment, so that the latch begins without energy and without a jump of the torque but for its damping. Choose k
    so that the locked joint's frequency is above those of interest, and c near 2 sqrt(k I) for an inertia I, so that it does not
    ring.

    Args:
        name: unique name; the result holds ``<name>.torque`` [N m], which acts against a growing angle, and ``<name>.engaged``.
        on: the joint.
        at: angle at which it locks [rad].
        stiffness: k [N m/rad].
        damping: c [N m s/rad].
        middle: the angle in the reference configuration is taken within pi of it [rad]; from there it counts turns.
    """

    name: str
    on: TurningJoint
    stiffness: Annotated[units.TorsionalStiffness, Field(gt=0)]
    at: units.Angle = 0.0
    damping: units.TorsionalDamping = 0.0
    middle: units.Angle = 0.0

    def contribute(self, build: Build) -> None:
        """Add the latch's shares along the joint, its trigger, and its signals."""
        check_added(f"Latch '{self.name}'", build, self.on)
        law = LatchLaw(self.stiffness, self.damping)
        block = turning_force(build, self.name, self.on, law, self.middle)
        add_measure_force(build, block, ("torque", "N m"), ("angle", "rad"))

        def beyond(state: State) -> float:
            block.measures.evaluate(state.q)
            return float(block.shares @ block.measures.values) - self.at

        def engage() -> None:
            law.engage(block.measures.values)  # those of the state just accepted, which the trigger has evaluated last

        build.latches[self.name] = engage
        build.triggers.append(Trigger(self.name, beyond, 0, f"'{self.name}' locks '{self.on.name}'", engage))
        build.signals.append(
            Signal(f"{self.name}.engaged", "1", (), lambda state: float(law.held is not None), f"whether {self.name} holds")
        )
