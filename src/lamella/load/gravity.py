"""Gravity on all bodies."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import numpy as np

from lamella.declaration import declaration
from lamella.inertia import vector_mass
from lamella.load.dead import add_dead_load
from lamella.math.profile import Constant, Profile
from lamella.roles import Declaration
from lamella.units import Acceleration

if TYPE_CHECKING:
    from lamella.dofs import Build


@declaration
class Gravity(Declaration):
    """A uniform field of acceleration: Q = M g, with g in every position vector and zero in every slope.

    The positions interpolate a uniform displacement exactly (partition of unity), so this is the exact integral of the
    weight of every body.

    Args:
        name: unique name; the result holds ``<name>.factor``.
        acceleration: acceleration vector [m/s^2].
        profile: factor as a function of time.
    """

    order: ClassVar[int] = 2
    name: str
    acceleration: tuple[Acceleration, Acceleration, Acceleration] = (0.0, 0.0, -9.81)
    profile: Profile = Constant(1.0)

    def contribute(self, build: Build) -> None:
        """Add the weight of all bodies numbered in the build."""
        if not build.inertias:
            return
        field = np.outer(np.concatenate(build.is_position), self.acceleration)
        weight = vector_mass(build.inertias, build.n_vectors) @ field
        add_dead_load(build, self.name, np.arange(build.n_vectors), weight, self.profile)
