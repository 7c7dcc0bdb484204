"""Heat that a surface radiates to space."""

from __future__ import annotations

import numpy as np

from lamella.element.plate48.heated import NODES
from lamella.math.gauss import gauss_rule
from lamella.roles import Floats, ForceBlock
from lamella.thermal.conduction import UPPER
from lamella.thermal.mesh import TemperatureMesh

STEFAN_BOLTZMANN = 5.670374419e-8
"""[W/(m^2 K^4)], CODATA 2018."""


class RadiationBlock(ForceBlock):
    """f_a = int N_a epsilon sigma (T^4 - T_space^4) dA at T = T_0 + T_N + z T_M, with its exact tangent.

    Args:
        name: name of the item.
        mesh: the temperature field.
        height: height z of the surface [m].
        emissivity: epsilon [-].
        space: temperature of the surroundings [K].
    """

    first_order = True

    def __init__(self, name: str, mesh: TemperatureMesh, height: float, emissivity: float, space: float) -> None:
        self.name, self._reference, self._space = name, mesh.reference, space
        self._coords = mesh.coords
        s, w = gauss_rule(3)
        xi, eta = np.repeat(s, 3), np.tile(s, 3)
        N = np.stack([(xi if a else 1 - xi) * (eta if b else 1 - eta) for a, b in NODES], axis=1)
        self._shape = np.concatenate([N, height * N], axis=1)  # of the surface's temperature in the eight values, (9, 8)
        area = np.outer(w, w).reshape(-1) * mesh.plate.lx * mesh.plate.ly
        self._heat = emissivity * STEFAN_BOLTZMANN * area[:, None] * self._shape
        self._products = (self._shape[:, UPPER[0]] * self._heat[:, UPPER[1]]) * 4.0
        self.f_coords, self.f_scale = mesh.coords.reshape(-1), np.ones(mesh.coords.size)
        self.k_rows, self.k_cols = (mesh.coords[:, side].reshape(-1) for side in UPPER)
        self.k_scale = np.ones(len(self.k_rows))

    def _temperature(self, q: Floats) -> Floats:
        """Absolute temperature at the points [K], shape (n_element, 9)."""
        return self._reference + q[self._coords] @ self._shape.T

    def force(self, t: float, q: Floats, v: Floats, f: Floats) -> None:
        """Heat that leaves the nodes [W]."""
        np.matmul(self._temperature(q) ** 4 - self._space**4, self._heat, out=f.reshape(-1, 8))

    def force_tangent(
        self, t: float, q: Floats, v: Floats, alpha_q: float, alpha_v: float, q_previous: Floats, f: Floats, k: Floats
    ) -> None:
        """The heat, and alpha_q df/dT."""
        self.force(t, q, v, f)
        np.matmul(alpha_q * self._temperature(q) ** 3, self._products, out=k.reshape(-1, len(UPPER[0])))

    def energy(self, t: float, q: Floats) -> float:
        """None: heat is not mechanical energy."""
        return 0.0
