"""The block of moments at points of plates."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from lamella.dofs import Motion
from lamella.kinematics import PointRows
from lamella.load.moment_kernels import Vector, group_forces, moment_tangents
from lamella.roles import Floats, ForceBlock, Ints, Symmetry


class MomentBlock(ForceBlock):
    """f = -p(t) sum_points weight sum_i S_i^T F_i with the forces F_i = W_i^T m of the moment on the tangents r_x, r_y.

    The points come in groups that depend on the same coordinate vectors (one element's points on an edge), so that a group has
    one force and one tangent, however many points it has.

    A moment in space has no potential, whether its axes are fixed or turn with the material: two small rotations in exchanged
    order differ by a third one, so the tangent has a skew part of the size of the moment. It vanishes only while all rotations
    have the axis of the moment (plane bending). Hence the symmetry ``none``: with the symmetric part alone Newton loses its
    quadratic convergence in space (27 iterations instead of 9 for a strip bent and twisted by an edge moment). Sources:
    Ziegler, Principles of structural stability, 1968; Simo and Vu-Quoc, 1986, on the tangent at non-equilibrium states.

    Args:
        name: the load's name.
        groups: the points of each group; all groups have the same number of points.
        weights: weight of each point of each group (reference length per point along an edge), shape (n_groups, n_points).
        kind: what the components refer to, see :mod:`lamella.load.moment_kernels`.
        components: moment [N m], or per length [N].
        profile: the factor p(t).
    """

    symmetry: Symmetry = "none"

    def __init__(
        self, name: str, groups: Sequence[Sequence[PointRows]], weights: Floats, kind: int, components: Vector, profile: Motion
    ) -> None:
        self.name, self.kind, self.profile = name, kind, profile
        self.components = (float(components[0]), float(components[1]), float(components[2]))
        found = [_slopes(points) for points in groups]
        self._vectors = np.stack([vectors for vectors, _ in found])
        slopes = np.stack([rows for _, rows in found])  # group, point, tangent, vector
        n_groups, n_points, _, n = slopes.shape
        self._slopes = slopes.reshape(n_groups, 2 * n_points, n)
        shares = slopes * weights[:, :, None, None]
        self._shares = np.ascontiguousarray(shares.reshape(n_groups, 2 * n_points, n).swapaxes(1, 2))
        pairs = np.einsum("gpia,gpjb->gabpij", shares, slopes)
        self._pairs = np.ascontiguousarray(pairs.reshape(n_groups, n * n, 4 * n_points))
        self._number(n)
        self._first, self._shape = 3 * self._vectors, (n_groups, n, 3)
        self._tangents = np.empty((n_groups, n_points, 2, 3))
        self._F = np.empty_like(self._tangents)
        self._H = np.empty((n_groups, 4 * n_points, 9))

    def _number(self, n: int) -> None:
        """Coordinates of the entries: forces by group, vector, component; tangents by group, two vectors, two components."""
        coords = 3 * self._vectors[:, :, None] + np.arange(3)
        self.f_coords, self.f_scale = coords.reshape(-1), np.ones(coords.size)
        shape = (len(coords), n, n, 3, 3)
        self.k_rows = np.broadcast_to(coords[:, :, None, :, None], shape).reshape(-1)
        self.k_cols = np.broadcast_to(coords[:, None, :, None, :], shape).reshape(-1)
        self.k_scale = np.ones(self.k_rows.size)

    def force(self, t: float, q: Floats, v: Floats, f: Floats) -> None:
        factor = self.profile.value(t)
        if factor == 0.0:  # much of a manoeuvre is coasting
            f[:] = 0.0
            return
        group_forces(
            self.kind, self.components, -factor, q, self._first, self._slopes, self._shares,
            self._tangents, self._F, f.reshape(self._shape),
        )  # fmt: skip

    def force_tangent(
        self, t: float, q: Floats, v: Floats, alpha_q: float, alpha_v: float, q_previous: Floats, f: Floats, k: Floats
    ) -> None:
        self.force(t, q, v, f)
        factor = self.profile.value(t)
        if factor == 0.0:
            k[:] = 0.0
            return
        moment_tangents(self.kind, self.components, self._tangents.reshape(-1, 2, 3), self._H.reshape(-1, 2, 2, 3, 3))
        np.matmul(self._pairs, self._H, out=k.reshape(*self._pairs.shape[:2], 9))
        k *= -alpha_q * factor

    def energy(self, t: float, q: Floats) -> float:
        return 0.0


def _slopes(points: Sequence[PointRows]) -> tuple[Ints, Floats]:
    """Vectors that any of the points depends on, and the weights of r_x, r_y in them, shape (n_points, 2, n_vectors)."""
    vectors = np.unique(np.concatenate([rows.vectors for rows in points]))
    slopes = np.zeros((len(points), 2, len(vectors)))
    for weights, rows in zip(slopes, points, strict=True):
        weights[:, np.searchsorted(vectors, rows.vectors)] = rows.slope_x, rows.slope_y
    used = np.any(slopes != 0.0, axis=(0, 1))
    return vectors[used], np.ascontiguousarray(slopes[:, :, used])
