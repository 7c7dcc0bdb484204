"""The section of shell elements, as their blocks take it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from lamella.element.plate48.strain import Cubed
from lamella.roles import Floats

Curvature = Literal["unit_normal", "cubed_normal"]
"""How curvature is measured: kap_ab = r_ab.n0 - B_ab, or (J0/J)^2 r_ab.n0 - B_ab with the area element J, J0 in the reference."""


@dataclass(frozen=True)
class Section:
    """What a shell is made of, in the local orthonormal frame whose first axis is the material direction.

    Args:
        stiffness: [[A, -B], [-B, D]] of (eps, kap) [N/m, N, N m], shape (6, 6) or, element by element, (n_element, 6, 6).
        direction: vector of the inertial frame whose projection on the reference surface is the material direction, shape (3,);
            None stands for the direction of the reference r_x.
        prestrain: (eps_11, eps_22, 2 eps_12) that the reference configuration already has, shape (3,); None stands for none.
        curvature: the definition of kap.
        membrane_gauss: Gauss points in each direction for the energy of the in-plane forces, at least 3; None stands for the
            same as for the rest. Two points would leave motions in the plane without stiffness, on every mesh.
    """

    stiffness: Floats
    direction: Floats | None = None
    prestrain: Floats | None = None
    curvature: Curvature = "unit_normal"
    membrane_gauss: int | None = None

    @classmethod
    def of(cls, section: Section | Floats) -> Section:
        """A section, from itself or from a stiffness alone."""
        return section if isinstance(section, Section) else cls(np.asarray(section, float))

    @property
    def cubed(self) -> Cubed:
        """The definition of curvature as the kernels take it."""
        return True if self.curvature == "cubed_normal" else None

    @property
    def by_element(self) -> Floats:
        """The stiffness with the axes of elements and Gauss points in front, shape (1 or n_element, 1, 6, 6)."""
        return self.stiffness.reshape(-1, 1, 6, 6)

    def parts(self, n_gauss: int) -> list[tuple[Section, int]]:
        """Sections whose stiffnesses add up to this one, with the Gauss points in each direction that integrate them.

        With N = A eps - B kap the energy is 1/2 N.A^-1 N + 1/2 kap.(D - B A^-1 B) kap, two parts that are never negative: the
        energy of the in-plane forces, and that of bending without any. In a symmetric laminate (B = 0) they are membrane and
        bending; otherwise ``membrane_gauss`` also integrates the part of bending that the coupling makes.

        Raises:
            LinAlgError: A is singular.
        """
        if self.membrane_gauss is None or self.membrane_gauss == n_gauss:
            return [(self, n_gauss)]
        whole = self.stiffness
        rows = whole[..., :3, :]
        membrane = rows.swapaxes(-1, -2) @ np.linalg.solve(whole[..., :3, :3], rows)
        membrane[..., :3, :], membrane[..., :, :3] = rows, rows.swapaxes(-1, -2)  # the difference vanishes but for rounding
        return [
            (replace(self, stiffness=whole - membrane, membrane_gauss=None), n_gauss),
            (replace(self, stiffness=membrane, membrane_gauss=None), self.membrane_gauss),
        ]
