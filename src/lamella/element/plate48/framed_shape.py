"""Groups of elements as their frames see them: vectors in the frames' axes, and forces that turn with them.

The symbols are those of :mod:`lamella.element.plate48.frame`.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from lamella.element.plate48.frame_groups import FrameGroups
from lamella.errors import LamellaError
from lamella.math.rotation import polar
from lamella.roles import Floats

_CROSS = np.array([[[0, 0, 0], [0, 0, -1], [0, 1, 0]], [[0, 0, 1], [0, 0, 0], [-1, 0, 0]], [[0, -1, 0], [1, 0, 0], [0, 0, 0.0]]])
"""The matrices [e1 x], [e2 x], [e3 x]."""
FIRST_AXES = _CROSS[:2]
"""The matrices [e_i x] of the two axes in the surface."""


def cross_matrix(vectors: Floats) -> Floats:
    """The matrices [v x] with [v x] u = v x u, shape (..., 3, 3), of vectors of shape (..., 3)."""
    return (vectors @ _CROSS.reshape(3, 9)).reshape(*vectors.shape, 3)


def axial(matrix: Floats) -> Floats:
    """sum a x b, shape (..., 3), from the matrix sum a b^T."""
    return np.stack([matrix[..., i, j] - matrix[..., j, i] for i, j in ((1, 2), (2, 0), (0, 1))], axis=-1)


@dataclass(frozen=True)
class FramedShape:
    """Groups in a configuration; components in the frames' axes.

    Args:
        groups: the groups.
        R: axes of the frames as columns, shape (n_group, 3, 3).
        y: deformations y_k = R^T x_k - X_k, shape (n_group, n, 3).
        U: stretch of the mean gradients, shape (n_group, 2, 2).
        J_inverse: inverse of J = tr(U) I - U, shape (n_group, 3, 3).
    """

    groups: FrameGroups
    R: Floats
    y: Floats
    U: Floats
    J_inverse: Floats

    @cached_property
    def turns(self) -> Floats:
        """Gam_i = J^-1 [e_i x], shape (n_group, 2, 3, 3)."""
        return self.J_inverse[:, None] @ FIRST_AXES

    @cached_property
    def gradients(self) -> Floats:
        """The mean gradients R^T f_i, shape (n_group, 2, 3)."""
        full = np.zeros((len(self.U), 2, 3))
        full[..., :2] = self.U
        return full

    @cached_property
    def y_cross(self) -> Floats:
        """The matrices [y_k x] below each other, shape (n_group, 3 n, 3)."""
        return cross_matrix(self.y).reshape(len(self.y), -1, 3)

    @cached_property
    def turning(self) -> Floats:
        """The matrices G_k beside each other, shape (n_group, 3, 3 n): a motion dX turns the frame by theta = sum_k G_k dX_k."""
        return self.beside(self.turns)

    def weighted(self, of_gradients: Floats) -> Floats:
        """sum_i w_ik A_i of each vector, shape (n_group, n, 3, 3), from A_i of shape (n_group, 2, 3, 3)."""
        g, n = self.y.shape[:2]
        w = self.groups.weights.swapaxes(1, 2)
        return (w @ of_gradients.reshape(g, 2, 9)).reshape(g, n, 3, 3)

    def beside(self, of_gradients: Floats) -> Floats:
        """The same beside each other, shape (n_group, 3, 3 n): sum_i A_i times the change of the gradients by a motion dX."""
        return self.weighted(of_gradients).swapaxes(1, 2).reshape(len(self.y), 3, -1)

    def torque(self, p: Floats) -> Floats:
        """tau = sum_k y_k x p_k, shape (n_group, 3)."""
        return axial(self.y.swapaxes(1, 2) @ p)

    def across(self, p: Floats) -> Floats:
        """e_i x s with s = J^-1 tau, shape (n_group, 2, 3)."""
        s = np.einsum("gab,gb->ga", self.J_inverse, self.torque(p))
        return np.einsum("iab,gb->gia", FIRST_AXES, s)

    def in_frame(self, p: Floats, across: Floats) -> Floats:
        """F_k = p_k + sum_i w_ik e_i x s, shape (n_group, n, 3): the forces whose power is that of p on the rates of y."""
        return p + self.groups.weights.swapaxes(1, 2) @ across

    def force(self, p: Floats, across: Floats) -> Floats:
        """R F_k, shape (n_group, n, 3)."""
        return self.in_frame(p, across) @ self.R.swapaxes(1, 2)

    def components(self, vectors: Floats) -> Floats:
        """Vectors of the groups, positions from the origin, in the frames' axes, shape (n_group, n, 3), from all coordinates."""
        return _from_origin(self.groups, vectors) @ self.R


def framed_shape(groups: FrameGroups, q: Floats) -> FramedShape:
    """Groups in the configuration q; not a number where the mean gradients give no frame."""
    x = _from_origin(groups, q)
    gradients = groups.weights @ x
    R = _frames(gradients)
    U = (gradients @ R)[..., :2]
    trace = U[:, 0, 0] + U[:, 1, 1]
    J_inverse = np.zeros_like(R)
    # the inverse of tr(U) I - U for a symmetric 2 x 2 matrix is U / det(U)
    J_inverse[:, :2, :2] = U / (U[:, 0, 0] * U[:, 1, 1] - U[:, 0, 1] * U[:, 1, 0])[:, None, None]
    J_inverse[:, 2, 2] = 1.0 / trace
    return FramedShape(groups, R, x @ R - groups.rest, U, J_inverse)


def _from_origin(groups: FrameGroups, vectors: Floats) -> Floats:
    x = vectors[groups.coords]
    x -= groups.is_position[:, None] * x[:, groups.origin, None]
    return x


def _frames(gradients: Floats) -> Floats:
    """R of each group from f1, f2, shape (n_group, 2, 3); not a number where there is none."""
    try:
        return polar(gradients.swapaxes(1, 2))[0]
    except (LamellaError, np.linalg.LinAlgError):
        return np.full((len(gradients), 3, 3), np.nan)
