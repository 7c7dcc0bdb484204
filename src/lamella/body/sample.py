"""Points of a plate in one configuration or several, with stress and failure recovered from their strains and temperatures."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from lamella.material.failure import von_mises
from lamella.material.laminate import Laminate
from lamella.material.recovery import Axes, Criterion, Surface, failure_index, ply_stress, section_forces
from lamella.roles import Floats


@dataclass(frozen=True)
class PlateSample:
    """A structured grid of points on a plate in one configuration, or in a stack of them (...).

    Args:
        laminate: the section.
        x: first parameter [m], shape (mx,).
        y: second parameter [m], shape (my,).
        r: positions [m], shape (..., my, mx, 3).
        n: unit normals, shape (..., my, mx, 3).
        strains: membrane strains and curvatures (eps, kap) in the local orthonormal frame [-, 1/m], shape (..., my, mx, 6).
        T_N: change of temperature at the reference surface [K], shape (..., my, mx) or one for all points.
        T_M: gradient of temperature through the thickness [K/m], shape (..., my, mx) or one for all points.
        thickness_factors: by which all heights of the section are multiplied, shape (my, mx) or one for all points.
    """

    laminate: Laminate
    x: Floats
    y: Floats
    r: Floats
    n: Floats
    strains: Floats
    T_N: Floats | float = 0.0
    T_M: Floats | float = 0.0
    thickness_factors: Floats | float = 1.0

    @cached_property
    def _of_section(self) -> tuple[Floats, Floats | float, Floats | float]:
        """Strains, T_N and T_M that give the laminate itself, at its own heights, the strains and temperatures at each point."""
        factor = np.asarray(self.thickness_factors, float)[..., None]
        return (
            np.concatenate([self.strains[..., :3], factor * self.strains[..., 3:]], axis=-1),
            self.T_N,
            factor[..., 0] * self.T_M,
        )

    def section_forces(self) -> Floats:
        """Membrane forces and moments (N, M) [N/m, N], shape (..., my, mx, 6)."""
        factor = np.asarray(self.thickness_factors, float)[..., None]
        return section_forces(self.laminate, *self._of_section) * factor ** np.array([1.0, 1.0, 1.0, 2.0, 2.0, 2.0])

    def energy_density(self) -> Floats:
        """Strain energy per reference area W = 1/2 R . C^-1 R [J/m^2], shape (..., my, mx).

        R = (N, M) are the section forces, of strains less thermal strains, and C = [[A, -B], [-B, D]].
        """
        forces = section_forces(self.laminate, *self._of_section)
        strains = forces @ np.linalg.inv(self.laminate.stiffness)
        return 0.5 * np.asarray(self.thickness_factors, float) * np.sum(forces * strains, axis=-1)

    def stress(self, ply: int, surface: Surface = "middle", axes: Axes = "element") -> Floats:
        """Plane stress (11, 22, 12) in a ply [Pa], shape (..., my, mx, 3).

        Args:
            ply: number of the ply, 0 at the bottom.
            surface: ``bottom``, ``middle`` or ``top`` of the ply.
            axes: those of the ``element``, or ``fibre``: along and across the fibres.
        """
        strains, T_N, T_M = self._of_section
        return ply_stress(self.laminate, strains, ply, surface, axes, T_N, T_M)

    def von_mises(self, ply: int, surface: Surface = "middle") -> Floats:
        """Von Mises stress in a ply [Pa], shape (..., my, mx)."""
        return von_mises(self.stress(ply, surface))

    def failure_index(self, ply: int, surface: Surface = "middle", criterion: Criterion = "tsai-wu") -> Floats:
        """Tsai-Wu or Tsai-Hill index of a ply, 1 at failure, shape (..., my, mx); the ply's material needs its strengths."""
        strains, T_N, T_M = self._of_section
        return failure_index(self.laminate, strains, ply, surface, criterion, T_N, T_M)
