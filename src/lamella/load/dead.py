"""The block of a dead load: a constant generalised force times a function of time."""

from __future__ import annotations

import numpy as np

from lamella.dofs import Build, Motion
from lamella.load.record import add_load
from lamella.math.profile import Constant
from lamella.numbering import Numbering
from lamella.roles import Bools, Floats, ForceBlock, Ints

NONE = np.zeros(0, dtype=np.int64)


class DeadLoadBlock(ForceBlock):
    """f = -p(t) Q with a constant vector Q on some coordinates; potential energy -p(t) Q . q.

    Args:
        name: the load's name.
        coords: coordinates, shape (n,).
        values: generalised force Q, shape (n,).
        profile: the factor p(t).
    """

    def __init__(self, name: str, coords: Ints, values: Floats, profile: Motion) -> None:
        self.name, self.values, self.profile = name, values, profile
        self.f_coords, self.f_scale = coords, np.ones(len(coords))
        self.k_rows, self.k_cols, self.k_scale = NONE, NONE, np.zeros(0)

    def acting_on(self, coordinates: Bools, numbering: Numbering | None) -> DeadLoadBlock:
        """As the role says."""
        own = coordinates[self.f_coords]
        coords = self.f_coords[own]
        return DeadLoadBlock(self.name, numbering.coordinates(coords) if numbering else coords, self.values[own], self.profile)

    def repeated(self, n: int, n_q: int) -> DeadLoadBlock | None:
        """As the role says: of a constant load."""
        if not isinstance(self.profile, Constant):
            return None
        first = n_q * np.repeat(np.arange(n), len(self.f_coords))
        return DeadLoadBlock(self.name, np.tile(self.f_coords, n) + first, np.tile(self.values, n), self.profile)

    def force(self, t: float, q: Floats, v: Floats, f: Floats) -> None:
        np.multiply(self.values, -self.profile.value(t), out=f)

    def force_tangent(
        self, t: float, q: Floats, v: Floats, alpha_q: float, alpha_v: float, q_previous: Floats, f: Floats, k: Floats
    ) -> None:
        self.force(t, q, v, f)

    def energy(self, t: float, q: Floats) -> float:
        return -self.profile.value(t) * float(self.values @ q[self.f_coords])


def add_dead_load(build: Build, name: str, vectors: Ints, forces: Floats, profile: Motion) -> None:
    """Add a dead load given as forces on coordinate vectors, shape (n, 3), and record its factor.

    Vectors may repeat; their forces are summed.
    """
    unique, inverse = np.unique(vectors, return_inverse=True)
    summed = np.stack([np.bincount(inverse, forces[:, c], minlength=len(unique)).astype(float) for c in range(3)], axis=1)
    coords = (3 * unique[:, None] + np.arange(3)).reshape(-1)
    add_load(build, DeadLoadBlock(name, coords, summed.reshape(-1), profile), profile)
