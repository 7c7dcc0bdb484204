"""Elastic Plate48 shells with exact Kirchhoff-Love strains."""

from __future__ import annotations

from lamella.element.packing import aligned
from lamella.element.plate48 import kernels
from lamella.element.plate48.entries import upper_entries
from lamella.element.plate48.layout import GaussTables, Plate48Block
from lamella.element.plate48.section import Section
from lamella.lane import WIDTH
from lamella.roles import Floats, Ints


class ShellBlock(Plate48Block):
    """Elastic shell with exact Kirchhoff-Love strains (Green-Lagrange membrane strains, curvature with the exact unit normal).

    W = int 1/2 eps.A eps - eps.B kap + 1/2 kap.D kap dA with E(z) = eps - z kap: the section stiffness of (eps, kap) is
    [[A, -B], [-B, D]] and the resultants are N = A eps - B kap, M = -B eps + D kap.

    Args:
        name: name of the body, for messages.
        coords: global coordinates of each element in element order, shape (n_element, 48).
        scale: factors from global to element coordinates, shape (n_element, 48).
        reference: unscaled stress-free coordinates, flat or curved, shape (n_element, 48).
        section: the section, or its stiffness [[A, -B], [-B, D]] alone, shape (6, 6) or (n_element, 6, 6).
        n_gauss: Gauss points in each direction; 4 is nearly exact, 3 faster and softer.

    Raises:
        ModelError: shapes do not agree, or the reference surface has no area.
    """

    def __init__(
        self, name: str, coords: Ints, scale: Floats, reference: Floats, section: Section | Floats, n_gauss: int = 4
    ) -> None:
        super().__init__(name, coords, scale, reference, *upper_entries())
        tables = GaussTables(self, section, n_gauss)
        self._tables = (self._index, self._scale, tables.sections, tables.table, tables.n)
        self._work, self._energies = aligned(kernels.work_size(n_gauss) * WIDTH), aligned(self.n_block * WIDTH)

    def force(self, t: float, q: Floats, v: Floats, f: Floats) -> None:
        """Elastic force dW/de."""
        kernels.force(q, *self._tables, self._work, f)

    def force_tangent(
        self, t: float, q: Floats, v: Floats, alpha_q: float, alpha_v: float, q_previous: Floats, f: Floats, k: Floats
    ) -> None:
        """Elastic force and alpha_q d2W/de2; geometric part with strains extrapolated from ``q_previous``."""
        kernels.force_tangent(q, q_previous, q_previous is not q, *self._tables, self._work, f, k)
        if alpha_q != 1.0:
            k *= alpha_q

    def energy(self, t: float, q: Floats) -> float:
        """Strain energy [J]."""
        kernels.energy(q, *self._tables, self._work, self._energies)
        return float(self._energies[: self.n_element].sum())
