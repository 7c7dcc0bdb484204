"""Couplings between coordinates of markers, and between angles of joints."""

from __future__ import annotations

from dataclasses import replace
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from lamella import units
from lamella.body.base import Marker
from lamella.declaration import declaration
from lamella.dofs import Build, LinearRow, Signal
from lamella.errors import DeclarationError
from lamella.joint.turning import TurningJoint, angle_shares, check_added
from lamella.kinematics import VectorRows
from lamella.math.profile import Constant, LengthProfile
from lamella.measure.constraint import MeasureConstraint, MeasureRow
from lamella.measure.force import MeasureForce
from lamella.measure.law import SpringLaw
from lamella.measure.measure import Measure, MeasureSet
from lamella.roles import Declaration


@declaration
class PositionCoupling(Declaration):
    """Coordinates of markers in the inertial frame stay in a linear relation.

        sum_i c_i (r_i . e_i - reference) = p(t)

    Ropes over pulleys and scissor linkages do this: of two markers that a loop of rope moves in the ratio 1 to 2 along x, the
    factors are 2 and -1. The row is linear and eliminated. The result holds the generalised force ``<name>.force`` [N]: the
    force on marker i along its axis is c_i times it.

    Args:
        name: unique name.
        markers: the markers, at least two.
        axes: one letter ``x``, ``y`` or ``z`` for each marker.
        factors: one factor c_i for each marker [-].
        offset: p as a function of time [m].
    """

    name: str
    markers: tuple[Marker, ...]
    axes: tuple[Literal["x", "y", "z"], ...]
    factors: tuple[units.Number, ...] = Field(min_length=2)
    offset: LengthProfile = Constant(0.0)

    def __post_init__(self) -> None:
        if not len(self.markers) == len(self.axes) == len(self.factors):
            counts = f"{len(self.markers)} markers, {len(self.axes)} axes and {len(self.factors)} factors"
            raise ValueError(f"{counts}; accepted is one axis and one factor for each marker")
        if 0.0 in self.factors:
            raise ValueError(f"factors = {list(self.factors)}; accepted are factors other than zero")

    def contribute(self, build: Build) -> None:
        """Add one linear row."""
        coords, coefs = [], []
        for marker, axis, factor in zip(self.markers, self.axes, self.factors, strict=True):
            point = marker.rows(build).point
            if not len(point.vectors):
                raise DeclarationError(
                    f"PositionCoupling '{self.name}'", f"{marker} cannot move", "accepted are markers of bodies"
                )
            coords.append(3 * point.vectors + "xyz".index(axis))
            coefs.append(factor * point.weights)
        places, inverse = np.unique(np.concatenate(coords), return_inverse=True)
        summed = np.bincount(inverse, np.concatenate(coefs), minlength=len(places)).astype(float)
        constant = float(summed @ build.initial.reshape(-1)[places])
        row = LinearRow(f"the coupling '{self.name}'", places, summed, constant, self.offset)
        build.hold(self.name, [row], VectorRows.fixed(np.zeros(3)), single=True)


@declaration
class AngleCoupling(Declaration):
    """Angles of joints stay in a linear relation: sum_i c_i phi_i keeps its initial value.

    A closed cable loop over a pulley of radius r_i at each joint does this with c_i = +-r_i / r_1, and gears do. With a stiffness
    the relation is elastic, as a cable loop is:

        T = k (sum_i c_i phi_i - initial value) + c sum_i c_i phi_i',      torque c_i T against the angle of joint i

    Without one it is a constraint whose multiplier is T.

    Args:
        name: unique name; the result holds ``<name>.torque`` T [N m].
        joints: joints whose angles are coupled, at least two.
        factors: one factor c_i for each joint [-].
        stiffness: k [N m/rad]; rigid when left out.
        damping: c [N m s/rad], only with a stiffness.
    """

    name: str
    joints: tuple[TurningJoint, ...]
    factors: tuple[units.Number, ...] = Field(min_length=2)
    stiffness: Annotated[units.TorsionalStiffness, Field(gt=0)] | None = None
    damping: units.TorsionalDamping = 0.0

    def __post_init__(self) -> None:
        if len(self.joints) != len(self.factors):
            raise ValueError(f"{len(self.joints)} joints and {len(self.factors)} factors; accepted is one factor for each joint")
        if 0.0 in self.factors:
            raise ValueError(f"factors = {list(self.factors)}; accepted are factors other than zero")
        if self.damping and self.stiffness is None:
            raise ValueError(f"damping = {self.damping:g} without 'stiffness'; a rigid coupling has no damping")

    def contribute(self, build: Build) -> None:
        """Add the constraint or the spring, and T."""
        terms = []
        for joint, factor in zip(self.joints, self.factors, strict=True):
            check_added(f"AngleCoupling '{self.name}'", build, joint)
            terms += [replace(term, factor=factor * term.factor) for term in angle_shares(build, joint)]
        measure: Measure = tuple(terms)
        found = MeasureSet([measure])
        found.evaluate(build.initial.reshape(-1))
        initial = float(found.values[0])
        if self.stiffness is None:
            block = MeasureConstraint(self.name, [MeasureRow(f"the coupling '{self.name}'", measure, initial)])
            build.constrain(block)
            signal = Signal(f"{self.name}.torque", "N m", (), lambda s: float(s.lam[block.first]), f"torque of {self.name}")
        else:
            law = SpringLaw(self.stiffness, self.damping, Constant(initial), Constant(0.0))
            spring = MeasureForce(self.name, [measure], np.ones(1), law)
            build.forces.append(spring)
            signal = Signal(
                f"{self.name}.torque", "N m", (), lambda s: float(spring.answers(s.t, s.q, s.v)[0]), f"torque of {self.name}"
            )
        build.signals.append(signal)
