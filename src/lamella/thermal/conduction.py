"""Heat stored in a plate, conducted in its plane and through its thickness, and exchanged with its surroundings."""

from __future__ import annotations

import numpy as np

from lamella._jit import njit
from lamella.errors import DeclarationError
from lamella.roles import Floats, ForceBlock, Ints
from lamella.thermal.mesh import ElementSum, TemperatureMesh

UPPER = np.triu_indices(8)


class ConductionBlock(ForceBlock):
    """f = C Tdot + K (T - T_a), the same matrices for all elements: conduction and capacity of a plate, or a film on its surface.

    Args:
        name: name of the item.
        coords: coordinates of the elements' temperatures, shape (n_element, 8).
        K: conduction or exchange [W/K], shape (8, 8).
        C: capacity [J/K], shape (8, 8); None for none.
        supply: K T_a, the heat given without temperatures [W], shape (8,).
    """

    first_order = True

    def __init__(self, name: str, coords: Ints, K: Floats, C: Floats | None = None, supply: Floats | None = None) -> None:
        self.name, self._K, self._C = name, K, C
        self._coords, self._supply = coords, np.zeros(8) if supply is None else supply
        self._capacity = np.zeros((0, 0)) if C is None else C
        self.depends_on_velocity = C is not None
        # One unit of T_N everywhere: its row of C is the heat content.
        self._stored = None if C is None else ElementSum(coords, C @ np.repeat([1.0, 0.0], 4))
        self.f_coords, self.f_scale = coords.reshape(-1), np.ones(coords.size)
        rows, cols = UPPER
        self.k_rows, self.k_cols = coords[:, rows].reshape(-1), coords[:, cols].reshape(-1)
        self.k_scale = np.ones(len(self.k_rows))

    def force(self, t: float, q: Floats, v: Floats, f: Floats) -> None:
        """Heat that leaves the nodes [W]."""
        _heat(q, v, self._coords, self._K, self._supply, self._capacity, f)

    def force_tangent(
        self, t: float, q: Floats, v: Floats, alpha_q: float, alpha_v: float, q_previous: Floats, f: Floats, k: Floats
    ) -> None:
        """The heat, and alpha_q K + alpha_v C."""
        self.force(t, q, v, f)
        matrix = alpha_q * self._K
        if self._C is not None:
            matrix = matrix + alpha_v * self._C
        k.reshape(-1, len(UPPER[0]))[:] = matrix[UPPER]

    def energy(self, t: float, q: Floats) -> float:
        """None: heat is not mechanical energy."""
        return 0.0

    def stored(self, q: Floats) -> float:
        """Heat above that of the reference temperature, sum C T [J]."""
        assert self._stored is not None
        return self._stored(q)


def plate_block(mesh: TemperatureMesh, item: str) -> ConductionBlock:
    """Capacity and conduction of a plate.

    With the moments c_p, k_p of rho c and of the conductivity about the reference surface (p = 0, 1, 2),

        c_0 T_N' + c_1 T_M' = div(k_0 grad T_N + k_1 grad T_M) + ...
        c_1 T_N' + c_2 T_M' = div(k_1 grad T_N + k_2 grad T_M) - k_33 T_M + ...,     k_33 = int k_3 dz

    Raises:
        DeclarationError: a material of the plate lacks conductivity or specific heat.
    """
    laminate = mesh.plate.laminate
    try:
        c, k, through = laminate.heat_capacity, laminate.conductivity, laminate.conductivity_through
    except DeclarationError as error:
        raise DeclarationError(f"{item}: {error.item}", error.problem, error.accepted) from error
    _, mixed, slopes = mesh.integrals()
    in_plane = [np.tensordot(k[p], slopes, 2) for p in range(3)]
    K = np.block([[in_plane[0], in_plane[1]], [in_plane[1], in_plane[2] + through * mixed]])
    C = np.block([[c[0] * mixed, c[1] * mixed], [c[1] * mixed, c[2] * mixed]])
    return ConductionBlock(mesh.name, mesh.coords, 0.5 * (K + K.T), C)


def film_block(name: str, mesh: TemperatureMesh, height: float, coefficient: float, ambient: float) -> ConductionBlock:
    """A film on the surface at ``height``: q = h_c (T_ambient - T_0 - T_N - z T_M) into the plate."""
    one, mixed, _ = mesh.integrals()
    z = (1.0, height)
    K = coefficient * np.block([[a * b * mixed for b in z] for a in z])
    supply = coefficient * (ambient - mesh.reference) * np.concatenate([a * one for a in z])
    return ConductionBlock(name, mesh.coords, K, supply=supply)


@njit
def _heat(q: Floats, v: Floats, coords: Ints, K: Floats, supply: Floats, C: Floats, f: Floats) -> None:
    """f = K q_e - supply + C v_e of each element e; C may be empty."""
    for e in range(len(coords)):
        for i in range(8):
            total = -supply[i]
            for j in range(8):
                total += K[i, j] * q[coords[e, j]]
            for j in range(len(C)):
                total += C[i, j] * v[coords[e, j]]
            f[8 * e + i] = total
