"""Couplings between coordinates of markers."""

from __future__ import annotations

from typing import Literal

import numpy as np
from pydantic import Field

from lamella import units
from lamella.body.base import Marker
from lamella.declaration import declaration
from lamella.dofs import Build, LinearRow
from lamella.errors import DeclarationError
from lamella.kinematics import VectorRows
from lamella.math.profile import Constant, Profile
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
    offset: Profile = Constant(0.0)

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
