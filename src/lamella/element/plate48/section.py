"""The section of shell elements, as their blocks take it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from lamella.roles import Floats


@dataclass(frozen=True)
class Section:
    """What a shell is made of, in the local orthonormal frame whose first axis is the material direction.

    Args:
        stiffness: [[A, -B], [-B, D]] of (eps, kap) [N/m, N, N m], shape (6, 6) or, element by element, (n_element, 6, 6).
        direction: vector of the inertial frame whose projection on the reference surface is the material direction, shape (3,);
            None stands for the direction of the reference r_x.
        prestrain: (eps_11, eps_22, 2 eps_12) that the reference configuration already has, shape (3,); None stands for none.
    """

    stiffness: Floats
    direction: Floats | None = None
    prestrain: Floats | None = None

    @classmethod
    def of(cls, section: Section | Floats) -> Section:
        """A section, from itself or from a stiffness alone."""
        return section if isinstance(section, Section) else cls(np.asarray(section, float))

    def times(self, factor: float) -> Section:
        """The section with its stiffness multiplied."""
        return replace(self, stiffness=factor * self.stiffness)

    @property
    def by_element(self) -> Floats:
        """The stiffness with the axes of elements and Gauss points in front, shape (1 or n_element, 1, 6, 6)."""
        return self.stiffness.reshape(-1, 1, 6, 6)
