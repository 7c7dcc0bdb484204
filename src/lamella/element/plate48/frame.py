"""Elastic shells with the linear stiffness of the reference in frames that follow the motion.

A group of coordinate vectors x_k has the mean gradients f_i = sum_k w_ik x_k (the means of r_x and r_y over the reference area,
or along an edge), and its frame R = [d1, d2, d3] is the rotation of the polar decomposition of [f1, f2], which makes

    d1 x f1 + d2 x f2 = 0

In the frame's axes, with the reference X_k in those of the reference's frame,

    y_k = R^T x_k - X_k,      W = 1/2 y . K0 y,      p = K0 y

R depends on x. A variation of x with components dX_k in the frame's axes turns the frame by

    theta = sum_k G_k dX_k,   G_k = J^-1 (w_1k [e1 x] + w_2k [e2 x]),   J = tr(U) I - U

with the stretch U (bordered by zeros), and so, with tau = sum_k y_k x p_k and s = J^-1 tau,

    F_k = p_k + sum_i w_ik e_i x s,      f_k = R F_k

is the derivative of W. Its own derivative is R (K0 + H G + (H G)^T) R^T with

    H_k = sum_l K0_kl [y_l x] - [p_k x] + sum_i w_ik (1/2 Gam_i^T S - [(e_i x s) x]),      Gam_i = J^-1 [e_i x]
    S = sum_kl [y_k x]^T K0_kl [y_l x] - sum_k ((p_k . Y_k) I - Y_k p_k^T) + sum_i [(e_i x s) x] [(R^T f_i) x],   Y_k = R^T x_k

Translations and small rotations of the reference are in the null space of K0, so the choice of the origin changes nothing but
rounding; it moves with one node, so that a body far away is computed as well as one nearby.

Source: Rankin and Brogan (1986), An element independent corotational procedure for the treatment of large rotations, for the
idea; frame, force and tangent as above, exact for strains and rotations of any size.
"""

from __future__ import annotations

import numpy as np

from lamella.element.plate48.exact import ExactModel, ShellBlock
from lamella.element.plate48.frame_groups import FrameGroups, FramePlace, body_group, element_groups
from lamella.element.plate48.frame_kernels import turned_stiffness
from lamella.element.plate48.framed_shape import FramedShape, cross_matrix, framed_shape
from lamella.element.plate48.section import Section
from lamella.roles import Floats, ForceBlock, Ints


class FrameShellBlock(ForceBlock):
    """Elastic shell with the constant stiffness of the reference in one frame for each group of vectors.

    f = dW/dx,  W = 1/2 y . K0 y with y = R^T x - X, as derived at the top of this file. Rigid motion, however large, gives no
    force; strains must be small within a group. The tangent of a group is dense: n vectors take 9 n (n + 1) / 2 numbers.

    A configuration without a frame (mean gradients that vanish or are parallel) has a force that is not a number, so that the
    step that leads there is rejected.

    Args:
        name: name of the body, for messages.
        groups: the groups.
    """

    def __init__(self, name: str, groups: FrameGroups) -> None:
        self.name, self.groups = name, groups
        n_group, n = groups.coords.shape[:2]
        self.f_coords, self.f_scale = groups.coords.reshape(-1), np.ones(groups.coords.size)
        k, m = np.triu_indices(n)
        shape = (n_group, len(k), 3, 3)
        rows = np.broadcast_to(groups.coords[:, k, :, None], shape).copy()
        columns = np.broadcast_to(groups.coords[:, m, None, :], shape)
        below = np.tri(3, k=-1, dtype=bool)
        rows[:, k == m] = np.where(below, -1, rows[:, k == m])  # each pair once: blocks on the diagonal keep their upper part
        self.k_rows, self.k_cols, self.k_scale = rows.reshape(-1), columns.reshape(-1), np.ones(rows.size)

    def force(self, t: float, q: Floats, v: Floats, f: Floats) -> None:
        """Elastic force dW/dx."""
        at = framed_shape(self.groups, q)
        p = self._inner_force(at, q)
        f[:] = at.force(p, at.across(p)).reshape(-1)

    def force_tangent(
        self, t: float, q: Floats, v: Floats, alpha_q: float, alpha_v: float, q_previous: Floats, f: Floats, k: Floats
    ) -> None:
        """Elastic force and alpha_q d2W/dx2."""
        groups, at = self.groups, framed_shape(self.groups, q)
        p = self._inner_force(at, q)
        across = at.across(p)
        f[:] = at.force(p, across).reshape(-1)
        bent = groups.stiffness @ at.y_cross
        moment = (groups.rest + at.y).swapaxes(1, 2) @ p
        across = cross_matrix(across)
        S = at.y_cross.swapaxes(1, 2) @ bent + moment + (across @ cross_matrix(at.gradients)).sum(axis=1)
        S -= np.trace(moment, axis1=1, axis2=2)[:, None, None] * np.eye(3)
        shared = 0.5 * at.turns.swapaxes(-1, -2) @ S[:, None] - across
        H = bent.reshape(*p.shape, 3) - cross_matrix(p) + at.weighted(shared)
        turned_stiffness(groups.stiffness, H, at.weighted(at.turns), at.R, alpha_q, k)

    def energy(self, t: float, q: Floats) -> float:
        """Strain energy [J]."""
        at = framed_shape(self.groups, q)
        return 0.5 * float(np.vdot(at.y, self._elastic(at)))

    def turns(self, q: Floats) -> Floats:
        """Turn Q = R R0^T of each group's frame from the reference, shape (n_group, 3, 3)."""
        return framed_shape(self.groups, q).R @ self.groups.axes.swapaxes(1, 2)

    def _inner_force(self, at: FramedShape, q: Floats) -> Floats:
        """p = dW/dy, shape (n_group, n, 3)."""
        return self._elastic(at)

    def _elastic(self, at: FramedShape) -> Floats:
        """K0 y, shape (n_group, n, 3)."""
        return (self.groups.stiffness @ at.y.reshape(len(at.y), -1, 1)).reshape(at.y.shape)


class CorotationalShellBlock(FrameShellBlock):
    """Elastic shell with the constant stiffness of the reference in one frame for each element.

    Rotations are unlimited, strains and the bending of an element small: large bending converges with the mesh. The arguments
    are those of :class:`ShellBlock`, and

    Args:
        exact: the element's model of exact strains.

    Raises:
        ModelError: as :class:`ShellBlock`, or the mean gradient of an element's reference is singular.
    """

    def __init__(
        self,
        name: str,
        coords: Ints,
        scale: Floats,
        reference: Floats,
        section: Section | Floats,
        n_gauss: int = 4,
        exact: ExactModel = ShellBlock,
    ) -> None:
        super().__init__(name, element_groups(exact, name, coords, scale, reference, section, n_gauss))


class FloatingShellBlock(FrameShellBlock):
    """Elastic shell with the constant stiffness of the reference in one floating frame for the whole body.

    It is the floating frame of reference with all elastic modes of the mesh: the body moves as it likes and deforms as linear
    theory says. Its tangent is dense, n_q (n_q + 3) / 2 numbers for n_q coordinates, and so is the matrix of the system: the
    memory of a system grows with the square of the plate's coordinates. The arguments are those of :class:`ShellBlock`, and

    Args:
        frame_at: what the frame follows: the ``mean`` gradient over the body, or that over an edge. With an edge that is clamped
            the body deforms as linear theory says in the frame of the clamp.
        exact: the element's model of exact strains.

    Raises:
        ModelError: as :class:`ShellBlock`, the surface has no such edge, or the mean gradient of the reference is singular (a
            closed ring has none).
    """

    def __init__(
        self,
        name: str,
        coords: Ints,
        scale: Floats,
        reference: Floats,
        section: Section | Floats,
        n_gauss: int = 4,
        frame_at: FramePlace = "mean",
        exact: ExactModel = ShellBlock,
    ) -> None:
        super().__init__(name, body_group(exact, name, coords, scale, reference, section, n_gauss, frame_at))
