"""Pressure on a plate: a force per current area that follows the normal."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import numpy as np
from pydantic import InstanceOf

from lamella import units
from lamella.body.shell_body import ShellBody
from lamella.declaration import declaration
from lamella.dofs import Build, Motion
from lamella.load.record import add_load
from lamella.math.gauss import gauss_rule
from lamella.math.profile import Constant, Profile
from lamella.roles import Declaration, Floats, ForceBlock, Symmetry

if TYPE_CHECKING:
    from lamella.body.mesh import PlateMesh

N_GAUSS = 5
"""Bicubic S^T (r_xi x r_eta) has degree 8 in each direction: five points are exact, four (degree 7) are not."""


@declaration
class Pressure(Declaration):
    """A pressure on the top side (z > 0) of a plate; it stays normal to the surface and acts on the current area.

    Q = -p(t) p int S^T (r_x x r_y) dx dy,      r_x x r_y dx dy = n0 dA (current)

    A positive pressure pushes along -n0, from the top side towards the bottom side; a negative one pulls on the top side, which
    is the same as a positive one on the bottom side.

    Args:
        name: unique name; the result holds ``<name>.factor``.
        on: the plate.
        pressure: force per current area [Pa].
        profile: factor p(t).
    """

    order: ClassVar[int] = 3  # after the supports, which decide whether the tangent is symmetric
    name: str
    on: InstanceOf[ShellBody]
    pressure: units.Pressure
    profile: Profile = Constant(1.0)

    def contribute(self, build: Build) -> None:
        """Add the pressure on all elements of the plate."""
        mesh = self.on.compiled(build)
        block = PressureBlock(self.name, mesh, self.pressure, self.profile)
        block.symmetry = "nearly" if _boundary_is_held(build, mesh) else "none"
        add_load(build, block, self.profile)


def _boundary_is_held(build: Build, mesh: PlateMesh) -> bool:
    """Whether supports hold the whole boundary curve: positions and slopes along the edge at all nodes of all edges.

    A direction in which the surface is closed has no edges.
    """
    held = {int(row.coords[0]) for row in build.rows if len(row.coords) == 1}
    sides = [side for side in ("x-", "x+", "y-", "y+") if not mesh.loops["xy".index(side[0])]]
    curve = {
        3 * mesh.vector(int(node), name) + c
        for side in sides
        for node in mesh.edge_nodes(side)
        for name in ("r", mesh.edge_slope(side)[0])
        for c in range(3)
    }
    return curve <= held


class PressureBlock(ForceBlock):
    """f_a = p int S_a (r_xi x r_eta) dxi deta for every element, exact to rounding, with its exact tangent.

    The force is quadratic in the element's vectors e_a, so its tangent is linear in them, with constant coefficients:

        df_a/de_b = [k_ab x],      k_ab = p int S_a (S_b,eta r_xi - S_b,xi r_eta) = p sum_d P_abd e_d

    The 3x3 blocks [k_ab x] are skew: their diagonals are zero by structure and are not listed. The tangent is symmetric when
    k_ab = -k_ba. As r_xi,eta is the same in both orders, k_ab + k_ba = p int ((S_a S_b),eta r_xi - (S_a S_b),xi r_eta) is an
    integral along the boundary of the surface: it cancels between neighbouring elements and vanishes where the boundary is held
    (Schweizerhof and Ramm, 1984). So the symmetry is ``nearly`` when all edges are held, and ``none`` when one is free: with the
    symmetric part alone Newton on a cantilever that the pressure bends over stops converging.
    There is no potential with free edges, and with held ones only pressure times the volume swept, which has no natural zero:
    ``energy`` is 0.0 and the energy that the pressure gives is the work of f.

    Args:
        name: the load's name.
        mesh: the plate.
        pressure: p [Pa].
        profile: the factor p(t).
    """

    symmetry: Symmetry = "none"

    def __init__(self, name: str, mesh: PlateMesh, pressure: float, profile: Motion) -> None:
        self.name, self.pressure, self.profile = name, pressure, profile
        self._tables(mesh)
        count, n = mesh.coords.shape[0], self._value.shape[0]
        coords = np.ascontiguousarray(mesh.coords.T)
        scale = np.ascontiguousarray(mesh.scale.T)
        self.f_coords, self.f_scale = coords.reshape(-1), scale.reshape(-1)
        c = np.arange(3)
        rows, cols = np.stack([(c + 2) % 3, (c + 1) % 3]), np.stack([(c + 1) % 3, (c + 2) % 3])  # where +k_c and -k_c stand
        a, b = np.divmod(np.arange(n * n), n)
        row, col = (3 * a[:, None] + rows[:, None]).reshape(-1), (3 * b[:, None] + cols[:, None]).reshape(-1)
        self.k_rows, self.k_cols = coords[row].reshape(-1), coords[col].reshape(-1)
        self.k_scale = (scale[row] * scale[col]).reshape(-1)
        self._e = np.empty((n, 3 * count))
        self._r_xi, self._r_eta, self._n = np.empty((3, N_GAUSS**2, 3, count))
        self._part = np.empty((N_GAUSS**2, count))

    def _tables(self, mesh: PlateMesh) -> None:
        """Shape functions at the Gauss points, and the coefficients P of the tangent, shape (n n, n)."""
        places, weights = gauss_rule(N_GAUSS)
        xi, eta = np.repeat(places, N_GAUSS), np.tile(places, N_GAUSS)
        S, self._S_xi, self._S_eta = np.ascontiguousarray(mesh.element.shape(xi, eta)[:3])
        self._value = np.ascontiguousarray((np.outer(weights, weights).reshape(-1, 1) * S).T)
        products = np.einsum("pb,pd->pbd", self._S_eta, self._S_xi)
        P = np.tensordot(self._value, products - products.transpose(0, 2, 1), axes=1)
        self._P = P.reshape(-1, S.shape[1])

    def force(self, t: float, q: Floats, v: Floats, f: Floats) -> None:
        e = self._e
        np.take(q, self.f_coords, out=e.reshape(-1), mode="clip")  # checked at compilation; "raise" would copy
        np.multiply(e.reshape(-1), self.f_scale, out=e.reshape(-1))
        a, b, n, part = self._r_xi, self._r_eta, self._n, self._part
        np.matmul(self._S_xi, e, out=a.reshape(len(a), -1))
        np.matmul(self._S_eta, e, out=b.reshape(len(b), -1))
        for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
            np.multiply(a[:, j], b[:, k], out=n[:, i])
            n[:, i] -= np.multiply(a[:, k], b[:, j], out=part)
        np.matmul(self._value, n.reshape(len(n), -1), out=f.reshape(e.shape))
        f *= self.pressure * self.profile.value(t)

    def force_tangent(
        self, t: float, q: Floats, v: Floats, alpha_q: float, alpha_v: float, q_previous: Floats, f: Floats, k: Floats
    ) -> None:
        self.force(t, q, v, f)
        positive, negative = k.reshape(2, -1)
        np.matmul(self._P, self._e, out=positive.reshape(len(self._P), -1))
        positive *= alpha_q * self.pressure * self.profile.value(t)
        np.negative(positive, out=negative)

    def energy(self, t: float, q: Floats) -> float:
        return 0.0
