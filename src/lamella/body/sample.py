"""Points of a plate in one configuration, with stress and failure recovered from their strains and temperatures."""

from __future__ import annotations

from dataclasses import dataclass

from lamella.material.failure import von_mises
from lamella.material.laminate import Laminate
from lamella.material.recovery import Axes, Criterion, Surface, failure_index, ply_stress, section_forces
from lamella.roles import Floats


@dataclass(frozen=True)
class PlateSample:
    """A structured grid of points on a plate in one configuration.

    Args:
        laminate: the section.
        x: first parameter [m], shape (mx,).
        y: second parameter [m], shape (my,).
        r: positions [m], shape (my, mx, 3).
        n: unit normals, shape (my, mx, 3).
        strains: membrane strains and curvatures (eps, kap) in the local orthonormal frame [-, 1/m], shape (my, mx, 6).
        T_N: change of temperature at the reference surface [K], shape (my, mx) or one for all points.
        T_M: gradient of temperature through the thickness [K/m], shape (my, mx) or one for all points.
    """

    laminate: Laminate
    x: Floats
    y: Floats
    r: Floats
    n: Floats
    strains: Floats
    T_N: Floats | float = 0.0
    T_M: Floats | float = 0.0

    def section_forces(self) -> Floats:
        """Membrane forces and moments (N, M) [N/m, N], shape (my, mx, 6)."""
        return section_forces(self.laminate, self.strains, self.T_N, self.T_M)

    def stress(self, ply: int, surface: Surface = "middle", axes: Axes = "element") -> Floats:
        """Plane stress (11, 22, 12) in a ply [Pa], shape (my, mx, 3).

        Args:
            ply: number of the ply, 0 at the bottom.
            surface: ``bottom``, ``middle`` or ``top`` of the ply.
            axes: those of the ``element``, or ``fibre``: along and across the fibres.
        """
        return ply_stress(self.laminate, self.strains, ply, surface, axes, self.T_N, self.T_M)

    def von_mises(self, ply: int, surface: Surface = "middle") -> Floats:
        """Von Mises stress in a ply [Pa], shape (my, mx)."""
        return von_mises(self.stress(ply, surface))

    def failure_index(self, ply: int, surface: Surface = "middle", criterion: Criterion = "tsai-wu") -> Floats:
        """Tsai-Wu or Tsai-Hill index of a ply, 1 at failure, shape (my, mx); the ply's material needs its strengths."""
        return failure_index(self.laminate, self.strains, ply, surface, criterion, self.T_N, self.T_M)
