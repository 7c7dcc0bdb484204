"""The block of a force that turns with its body."""

from __future__ import annotations

import numpy as np

from lamella.dofs import Motion
from lamella.kinematics import VectorRows, vectors_of
from lamella.roles import Floats, ForceBlock, Symmetry


class FollowerForceBlock(ForceBlock):
    """f = -p(t) w d(x) with the point r = sum_i w_i x_i and the force d = sum_j b_j x_j, both linear in the coordinate vectors.

    The tangent -p(t) w_i b_j 1 is constant but for the factor. A force that turns with a body has no potential, so the tangent
    has no symmetry.

    Args:
        name: the load's name.
        point: the point on which it acts.
        force: the force [N].
        profile: the factor p(t).
    """

    symmetry: Symmetry = "none"

    def __init__(self, name: str, point: VectorRows, force: VectorRows, profile: Motion) -> None:
        self.name, self.profile = name, profile
        self._point, self._force = point, force
        coords, along = (3 * rows.vectors[:, None] + np.arange(3) for rows in (point, force))
        self.f_coords, self.f_scale = coords.reshape(-1), np.ones(coords.size)
        shape = (len(coords), len(along), 3)
        self.k_rows = np.broadcast_to(coords[:, None, :], shape).reshape(-1)
        self.k_cols = np.broadcast_to(along[None, :, :], shape).reshape(-1)
        self.k_scale = np.broadcast_to(np.outer(point.weights, force.weights)[:, :, None], shape).reshape(-1)

    def force(self, t: float, q: Floats, v: Floats, f: Floats) -> None:
        np.multiply.outer(-self.profile.value(t) * self._point.weights, self._force.at(vectors_of(q)), out=f.reshape(-1, 3))

    def force_tangent(
        self, t: float, q: Floats, v: Floats, alpha_q: float, alpha_v: float, q_previous: Floats, f: Floats, k: Floats
    ) -> None:
        self.force(t, q, v, f)
        k[:] = -alpha_q * self.profile.value(t)

    def energy(self, t: float, q: Floats) -> float:
        return 0.0
