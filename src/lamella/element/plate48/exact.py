"""Elastic Plate48 shells with exact Kirchhoff-Love strains."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from lamella.element.block import ElementBlock
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


class ExactModel(Protocol):
    """The exact strain model of an element: :class:`ShellBlock`, or another that takes the same arguments."""

    def __call__(
        self, name: str, coords: Ints, scale: Floats, reference: Floats, section: Section | Floats, n_gauss: int = 4
    ) -> ElementBlock:
        """The block of the elements."""
        ...


def reference_tangent(
    model: ExactModel, name: str, coords: Ints, scale: Floats, reference: Floats, section: Section | Floats, n_gauss: int
) -> tuple[ElementBlock, Floats]:
    """The exact tangent K0 of each element at the reference.

    Returns:
        The block of the elements, each with coordinates of its own, and its tangent buffer.
    """
    own = np.arange(coords.size, dtype=np.int64).reshape(coords.shape)
    shell = model(name, own, scale, reference, section, n_gauss)
    f, k = aligned(shell.f_coords.size), aligned(shell.k_rows.size)
    rest = np.ascontiguousarray(reference, float).reshape(-1)
    shell.force_tangent(0.0, rest, rest, 1.0, 0.0, rest, f, k)
    return shell, k
