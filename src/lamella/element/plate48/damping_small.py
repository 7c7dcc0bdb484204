"""Kelvin-Voigt damping of the small-deformation models: viscous forces on the rates of the strains that each model has.

    p = c K0 ydot,      f = B^T p  with  B = dydot/dv,      power ydot.p

``linear`` has ydot = v. In moving frames, with V_k = R^T v_k, the mean gradients g_i = R^T f_i, their rates h_i = sum_k w_ik V_k
and Y_k = X_k + y_k (the other symbols are those of :mod:`lamella.element.plate48.frame`),

    om = J^-1 sum_i e_i x h_i,      ydot_k = V_k - om x Y_k
    f_k = R (p_k + sum_i w_ik e_i x s),      s = J^-1 sum_k y_k x p_k

om is the angular velocity of the frame, so a rigid spin is not damped. A variation dX of the configuration, in the frame's axes,
with the turn theta and the change d_i = sum_k w_ik dX_k of the gradients, changes

    dydot_k = -om x dX_k - theta x ydot_k - eta x Y_k,      eta = dom - om x theta
    dom = J^-1 sum_i e_i x (-theta x h_i - om x dg_i),      dg_i = d_i - theta x g_i
    J ds = sum_k (dy_k x p_k + y_k x dp_k) - sum_i e_i x (s x dg_i),      dy_k = dX_k - theta x Y_k

because J a = sum_i e_i x (a x g_i) for every a. The tangent follows from these and is exact; the part by velocity is c B^T K0 B.
"""

from __future__ import annotations

import numpy as np

from lamella.element.plate48.frame import FrameShellBlock
from lamella.element.plate48.frame_groups import FrameGroups
from lamella.element.plate48.framed_shape import FIRST_AXES, FramedShape, cross_matrix, framed_shape
from lamella.element.plate48.linear import LinearShellBlock
from lamella.roles import Floats, ForceBlock, Symmetry


class LinearDampingBlock(ForceBlock):
    """Viscous force f = c K0 v.

    Args:
        shell: gives K0.
        time: retardation time c [s].
    """

    depends_on_velocity = True

    def __init__(self, shell: LinearShellBlock, time: float) -> None:
        self.name, self._shell, self._time = shell.name, shell, time
        self.f_coords, self.f_scale = shell.f_coords, shell.f_scale
        self.k_rows, self.k_cols, self.k_scale = shell.k_rows, shell.k_cols, shell.k_scale
        self._unused = np.zeros(len(self.f_coords))

    def force(self, t: float, q: Floats, v: Floats, f: Floats) -> None:
        """Viscous force c K0 v."""
        self._shell.times_stiffness(v, f)
        f *= self._time

    def force_tangent(
        self, t: float, q: Floats, v: Floats, alpha_q: float, alpha_v: float, q_previous: Floats, f: Floats, k: Floats
    ) -> None:
        """Viscous force and alpha_v c K0."""
        self.force(t, q, v, f)
        np.multiply(self._shell.matrix_entries, alpha_v * self._time, out=k)

    def energy(self, t: float, q: Floats) -> float:
        """No potential."""
        return 0.0

    def dissipation(self, t: float, q: Floats, v: Floats) -> float:
        """Power c v.K0 v [W]."""
        used = self.f_coords >= 0
        self.force(t, q, v, self._unused)
        return float((self._unused * self.f_scale)[used] @ v[self.f_coords[used]])


class FrameDampingBlock(ForceBlock):
    """Viscous force in moving frames, as derived at the top of this file.

    Its tangent is not symmetric, by terms of the order of c om beside those of c / dt. It is dense in a group: n vectors take
    9 n^2 numbers.

    Args:
        name: name of the body.
        groups: the groups, with K0.
        time: retardation time c [s].
    """

    symmetry: Symmetry = "nearly"
    depends_on_velocity = True

    def __init__(self, name: str, groups: FrameGroups, time: float) -> None:
        self.name, self.groups, self._time = name, groups, time
        self.f_coords, self.f_scale = groups.coords.reshape(-1), np.ones(groups.coords.size)
        own = groups.coords.reshape(len(groups.coords), -1)
        shape = (*own.shape, own.shape[1])
        self.k_rows = np.broadcast_to(own[:, :, None], shape).reshape(-1)
        self.k_cols = np.broadcast_to(own[:, None, :], shape).reshape(-1)
        self.k_scale = np.ones(self.k_rows.size)

    def force(self, t: float, q: Floats, v: Floats, f: Floats) -> None:
        """Viscous force."""
        at = framed_shape(self.groups, q)
        p = self._viscous(_rates(at, v)[1])
        f[:] = at.force(p, at.across(p)).reshape(-1)

    def force_tangent(
        self, t: float, q: Floats, v: Floats, alpha_q: float, alpha_v: float, q_previous: Floats, f: Floats, k: Floats
    ) -> None:
        """Viscous force and its exact tangent."""
        groups, at = self.groups, framed_shape(self.groups, q)
        g, n = at.y.shape[:2]
        omega, ydot = _rates(at, v)
        p = self._viscous(ydot)
        F = at.in_frame(p, at.across(p))
        f[:] = (F @ at.R.swapaxes(1, 2)).reshape(-1)

        K, turning, y_cross = self._time * groups.stiffness, at.turning, at.y_cross
        eta, hardening = self._turn_rates(at, v, omega, p)
        bent = K @ y_cross
        dp = alpha_v * (K + bent @ turning)
        dp -= alpha_q * (K.reshape(g, 3 * n, n, 3) @ cross_matrix(omega)[:, None]).reshape(K.shape)
        dp += alpha_q * ((K @ cross_matrix(ydot).reshape(g, -1, 3)) @ turning + bent @ eta)
        matrix = dp + turning.swapaxes(1, 2) @ (y_cross.swapaxes(1, 2) @ dp + alpha_q * hardening)
        matrix -= alpha_q * cross_matrix(F).reshape(g, -1, 3) @ turning
        turned = (at.R[:, None] @ matrix.reshape(g, n, 3, 3 * n)).reshape(g, 3 * n, n, 3)
        k[:] = (turned @ at.R.swapaxes(1, 2)[:, None]).reshape(-1)

    def energy(self, t: float, q: Floats) -> float:
        """No potential."""
        return 0.0

    def dissipation(self, t: float, q: Floats, v: Floats) -> float:
        """Power c ydot.K0 ydot [W]."""
        ydot = _rates(framed_shape(self.groups, q), v)[1]
        return float(np.vdot(ydot, self._viscous(ydot)))

    def _viscous(self, ydot: Floats) -> Floats:
        """p = c K0 ydot."""
        return self._time * (self.groups.stiffness @ ydot.reshape(len(ydot), -1, 1)).reshape(ydot.shape)

    def _turn_rates(self, at: FramedShape, v: Floats, omega: Floats, p: Floats) -> tuple[Floats, Floats]:
        """eta by dX, and sum_i e_i x (s x dg_i) - sum_k dy_k x p_k by dX, each of shape (n_group, 3, 3 n)."""
        spin, g_cross = cross_matrix(omega)[:, None], cross_matrix(at.gradients)
        h_cross = cross_matrix(self.groups.weights @ at.components(v))
        by_turn = (at.turns @ (h_cross - spin @ g_cross)).sum(axis=1)[:, None] - spin
        eta = at.beside(by_turn @ at.turns - at.turns @ spin)
        across = cross_matrix(np.einsum("gab,gb->ga", at.J_inverse, at.torque(p)))[:, None]
        held = FIRST_AXES @ across
        p_cross, Y_cross = cross_matrix(p), cross_matrix(self.groups.rest + at.y)
        by_turn = (held @ g_cross).sum(axis=1) + (p_cross @ Y_cross).sum(axis=1)
        stress = p_cross.swapaxes(1, 2).reshape(len(p), 3, -1)
        return eta, at.beside(by_turn[:, None] @ at.turns + held) + stress


def small_damping(shell: LinearShellBlock | FrameShellBlock, time: float) -> LinearDampingBlock | FrameDampingBlock:
    """The damping of a small-deformation model, by its elastic block and the retardation time c [s]."""
    if isinstance(shell, LinearShellBlock):
        return LinearDampingBlock(shell, time)
    return FrameDampingBlock(shell.name, shell.groups, time)


def _rates(at: FramedShape, v: Floats) -> tuple[Floats, Floats]:
    """Angular velocity of the frames, shape (n_group, 3), and ydot, shape (n_group, n, 3), in the frames' axes."""
    V = at.components(v)
    omega = (at.turning @ V.reshape(len(V), -1, 1))[..., 0]
    return omega, V - np.cross(omega[:, None], at.groups.rest + at.y)
