"""Linear constraints between components of positions and slopes of several bodies."""

from __future__ import annotations

from typing import Literal

import numpy as np
from pydantic import Field

from lamella import units
from lamella.body.base import Marker
from lamella.declaration import declaration
from lamella.dofs import Build, DotRow, Motion
from lamella.errors import DeclarationError
from lamella.joint.base import Axis, axes_with
from lamella.joint.motion_sum import MotionSum
from lamella.kinematics import VectorRows
from lamella.math.profile import Constant, LengthProfile
from lamella.roles import Declaration


@declaration
class Component:
    """A term c e.u of a :class:`LinearConstraint`: a component of a vector at a marker, times a factor.

    Args:
        on: the marker.
        axis: direction e: ``x``, ``y``, ``z`` of the inertial frame, or a vector of any length.
        factor: c [-], for a slope in a constraint of lengths [m].
        of: the vector u: the marker's ``position`` r [m], or a tangent of its plate, ``slope_x`` r_x or ``slope_y`` r_y [-] (of a
            rigid body its first and second axis).
    """

    on: Marker
    axis: Axis
    factor: units.Number = 1.0
    of: Literal["position", "slope_x", "slope_y"] = "position"


@declaration
class LinearConstraint(Declaration):
    """Components of positions and slopes, of any bodies, stay in a linear relation (a multi-point constraint).

        sum_k c_k e_k . (u_k - U_k) = p(t)          U_k: in the reference configuration
        sum_k c_k e_k . u_k = p(t)                  with ``absolute``

    The row is linear and eliminated. Its generalised force mu puts c_k mu e_k on u_k and does the power mu p'. In statics the
    sum goes from its reference value to p as the load factor grows; in motion it begins at p.

    Args:
        name: unique name; the result holds mu: as ``<name>.force`` [N] with positions among the terms, when p is a length [m],
            as ``<name>.torque`` [N m] with slopes alone, when p is a number [-].
        terms: the terms.
        value: p as a function of time.
        absolute: whether p is the sum itself instead of its change from the reference configuration.
    """

    name: str
    terms: tuple[Component, ...] = Field(min_length=1)
    value: LengthProfile = Constant(0.0)
    absolute: bool = False

    def contribute(self, build: Build) -> None:
        """Add one linear row."""
        item = f"LinearConstraint '{self.name}'"
        parts = [(term.factor, self._vector(build, term), axes_with(item, term.axis)[:, 2]) for term in self.terms]
        reference = sum(c * float(axis @ vector.at(build.initial)) for c, vector, axis in parts)
        dots = tuple((c, vector, VectorRows.fixed(axis)) for c, vector, axis in parts if len(vector.vectors))
        constant = sum(c * float(axis.constant @ vector.at(build.initial)) for c, vector, axis in dots)
        motion: Motion = MotionSum(((1.0, self.value), (1.0, Constant(-reference)))) if self.absolute else self.value
        row = DotRow(f"the linear constraint '{self.name}'", dots, constant, motion)
        linear = row.linear() if dots else None
        largest = max(abs(c) * np.abs(vector.weights).max() for c, vector, _ in dots) if dots else 0.0
        if linear is None or not np.abs(linear.coefs).max() > 1e-12 * largest:  # what is left of terms that cancel is rounding
            factors = ", ".join(f"{term.factor:g} {term.of} of {term.on}" for term in self.terms)
            raise DeclarationError(
                item, f"nothing in it can move: {factors}", "accepted are markers of bodies with factors that do not cancel"
            )
        quantity = ("force", "N") if any(term.of == "position" for term in self.terms) else ("torque", "N m")
        build.hold(self.name, [linear], VectorRows.fixed(np.zeros(3)), single=True, quantity=quantity)

    def _vector(self, build: Build, term: Component) -> VectorRows:
        rows = term.on.rows(build)
        if term.of == "position":
            return rows.point
        slope = rows.tangents[0 if term.of == "slope_x" else 1]
        if not len(slope.vectors):
            raise DeclarationError(
                f"LinearConstraint '{self.name}'",
                f"{term.on} has no {term.of}",
                "accepted is a marker of a plate or a rigid body, or its position",
            )
        return slope
