"""Positions, normals and strains of a shell at any point."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from lamella.element.base import ElementSpec
from lamella.element.plate48.section import Curvature
from lamella.element.plate48.strain import Cubed, extrapolated_strains, strains, surface_frame
from lamella.element.plate48.surface import reference_surface
from lamella.roles import Floats, Ints


@dataclass(frozen=True)
class ShellPoints:
    """A shell at n points.

    Args:
        r: positions [m], shape (n, 3).
        n: unit normals, shape (n, 3).
        strains: (eps_11, eps_22, 2 eps_12 [-], kap_11, kap_22, 2 kap_12 [1/m]) in the local orthonormal frame whose first
            axis is the material direction, shape (n, 6).
    """

    r: Floats
    n: Floats
    strains: Floats


class ShellRecovery:
    """Evaluates the elements of a shell at any point of theirs.

    Args:
        element: the finite element.
        coords: global coordinates of each element in element order, shape (n_element, n_coordinate).
        scale: factors from global to element coordinates, shape (n_element, n_coordinate).
        reference: unscaled reference coordinates, shape (n_element, n_coordinate).
        direction: the material direction, see :class:`lamella.element.plate48.section.Section`.
        curvature: the definition of kap, see there.
    """

    def __init__(
        self,
        element: ElementSpec,
        coords: Ints,
        scale: Floats,
        reference: Floats,
        direction: Floats | None = None,
        curvature: Curvature = "unit_normal",
    ) -> None:
        self._element, self._coords, self._scale = element, np.asarray(coords), np.asarray(scale, float)
        self._rest, self._direction = np.asarray(reference, float) * self._scale, direction
        self._cubed: Cubed = True if curvature == "cubed_normal" else None

    def at(self, q: Floats, element: Ints, xi: Floats, eta: Floats, turns: Floats | None = None) -> ShellPoints:
        """Position, unit normal and strains.

        The strains are the exact ones s(g), or those of a small-deformation model, which are linear in the frame of the element:
        ds/dg (G) . (Q^T g - G) with the derivatives g of the position, G those of the reference, and the turn Q of the frame.

        Args:
            q: global coordinates, shape (n_q,).
            element: number of the element of each point, shape (n,).
            xi: first element coordinate in [0, 1], shape (n,).
            eta: second element coordinate in [0, 1], shape (n,).
            turns: Q of each element or one for all, shape (n_element, 3, 3) or (1, 3, 3); None for exact strains.
        """
        element = np.asarray(element)
        shape = self._element.shape(xi, eta)
        now = self._derivatives(shape, q[self._coords[element]] * self._scale[element])
        rest = self._derivatives(shape, self._rest[element])
        reference = reference_surface("strain recovery", rest, self._direction)
        constants, g = tuple(reference.constants(self._cubed).T), _vectors(now)
        n0 = surface_frame(g[0], g[1])[0]
        if turns is None:
            found = strains(g, surface_frame(g[0], g[1], self._cubed)[0], constants)
        else:
            own = np.einsum("dnc,nce->dne", now, np.broadcast_to(turns, (len(self._coords), 3, 3))[element])
            found = extrapolated_strains(_vectors(own), _vectors(rest), constants, self._cubed)
        covariant = np.stack(found, axis=-1)
        local = np.einsum("nij,nj->ni", reference.strain_transform(self._cubed), covariant)
        return ShellPoints(now[0], np.stack(n0, axis=-1), local)

    @staticmethod
    def _derivatives(shape: Floats, coordinates: Floats) -> Floats:
        """Position and its derivatives at the points, shape (6, n, 3)."""
        return np.einsum("dns,nsc->dnc", shape, coordinates.reshape(len(coordinates), -1, 3))


def _vectors(derivatives: Floats) -> tuple[Any, ...]:
    """r_x, r_y, r_xx, r_yy, r_xy as the expressions for strains take them."""
    return tuple(tuple(derivatives[d].T) for d in (1, 2, 3, 5, 4))
