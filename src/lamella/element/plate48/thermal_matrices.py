"""What heat does to the constant stiffness of the reference: thermal forces and energies of Plate48 elements."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lamella.element.packing import unpacked
from lamella.element.plate48.heated import HeatedShellBlock, ThermalCouplingBlock
from lamella.element.plate48.section import Section
from lamella.element.plate48.shape import product_order
from lamella.lane import aligned
from lamella.roles import Floats, Ints


@dataclass(frozen=True)
class HeatedElements:
    """Elements that have temperatures; the arguments of :class:`HeatedShellBlock`.

    Args:
        name: name of the body.
        coords: global coordinates of each element in element order, shape (n_element, 48).
        scale: factors from global to element coordinates, shape (n_element, 48).
        reference: unscaled stress-free coordinates, shape (n_element, 48).
        section: the section.
        n_gauss: Gauss points in each direction.
        temperatures: coordinates of T_N and then T_M at an element's four nodes, shape (n_element, 8).
        expansion: thermal resultants a0, a1, a2 of (1, 2, 12) for each power of z, shape (3, 3).
    """

    name: str
    coords: Ints
    scale: Floats
    reference: Floats
    section: Section | Floats
    n_gauss: int
    temperatures: Ints
    expansion: Floats

    def shell(self) -> HeatedShellBlock:
        """The elements with exact strains."""
        return HeatedShellBlock(
            self.name, self.coords, self.scale, self.reference, self.section, self.n_gauss, self.temperatures, self.expansion
        )


def thermal_matrices(elements: HeatedElements) -> tuple[Floats, Floats]:
    """G and S of each element in W = 1/2 y.K0 y + y.G T + 1/2 T.S T, the strain energy of linear theory with thermal strain:

        W = 1/2 int (B y - s_T).C (B y - s_T) dA,     G T = -int B^T C s_T dA,     S = int s_T.C s_T dA for T = 1

    with the strains B y at the reference. The force p = K0 y + G T has neither resultant nor torque about the reference.

    Returns:
        G in unscaled coordinates, shape (n_element, 48, 8), and S, shape (n_element, 8, 8).
    """
    n = len(elements.coords)
    own = np.arange(48 * n, dtype=np.int64).reshape(n, 48)
    own_T = 48 * n + np.arange(8 * n, dtype=np.int64).reshape(n, 8)
    shell = HeatedShellBlock(
        elements.name, own, elements.scale, elements.reference, elements.section, elements.n_gauss, own_T, elements.expansion
    )
    coupling = ThermalCouplingBlock(elements.name, shell, own)
    rest = np.concatenate([np.asarray(elements.reference, float).reshape(-1), np.zeros(8 * n)])
    k = aligned(coupling.k_rows.size)
    coupling.force_tangent(0.0, rest, rest, 1.0, 0.0, rest, np.zeros(0), k)
    G = np.empty((n, 48, 8))
    G[:, product_order()] = unpacked(k * coupling.k_scale, n).reshape(n, 8, 48).swapaxes(1, 2)
    S = np.zeros((n, 8, 8))
    for part in shell.parts:
        ends = part.corners.reshape(-1, 2)
        corners = np.einsum("jb,ia->jiba", ends, ends).reshape(-1, 4)
        strain, stress = (unpacked(values, n).reshape(n, -1, 2, 6) for values in (part.strain, part.stress))
        S += np.einsum("egam,egbm,gk,gl->eakbl", strain, stress, corners, corners, optimize=True).reshape(n, 8, 8)
    return G, S
