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

    def points(self, element: Ints, xi: Floats, eta: Floats) -> RecoveryPoints:
        """Points to evaluate in many configurations.

        Args:
            element: number of the element of each point, shape (n,).
            xi: first element coordinate in [0, 1], shape (n,).
            eta: second element coordinate in [0, 1], shape (n,).
        """
        element = np.asarray(element)
        shape = self._element.shape(xi, eta).transpose(1, 0, 2)
        return RecoveryPoints(
            element, shape, self._coords[element], self._scale[element], self._rest[element], self._direction, self._cubed
        )

    def at(self, q: Floats, element: Ints, xi: Floats, eta: Floats, turns: Floats | None = None) -> ShellPoints:
        """Position, unit normal and strains at points, as :meth:`points` takes them, in one configuration."""
        return self.points(element, xi, eta).at(q, turns)


class RecoveryPoints:
    """Points of a shell, with their shape functions and reference surface; made by :meth:`ShellRecovery.points`.

    Args:
        element: number of the element of each point, shape (n,).
        shape: shape functions and their derivatives, shape (n, 6, n_shape).
        coords: global coordinates of the elements, shape (n, n_coordinate).
        scale: factors from global to element coordinates, likewise.
        rest: element coordinates of the reference, likewise.
        direction: the material direction.
        cubed: the definition of kap.
    """

    def __init__(
        self, element: Ints, shape: Floats, coords: Ints, scale: Floats, rest: Floats, direction: Floats | None, cubed: Cubed
    ) -> None:
        self._element, self._shape, self._coords, self._scale = element, shape, coords, scale
        self._cubed: Cubed = cubed
        self._rest = self._derivatives(rest)
        reference = reference_surface("strain recovery", self._rest, direction)
        self._constants, self._to_local = tuple(reference.constants(cubed).T), reference.strain_transform(cubed)

    def positions(self, q: Floats) -> Floats:
        """Positions [m], shape (n, 3)."""
        return self._derivatives(q[self._coords] * self._scale, slice(1))[0]

    def at(self, q: Floats, turns: Floats | None = None) -> ShellPoints:
        """Position, unit normal and strains.

        The strains are the exact ones s(g), or those of a small-deformation model, which are linear in the frame of the element:
        ds/dg (G) . (Q^T g - G) with the derivatives g of the position, G those of the reference, and the turn Q of the frame.

        Args:
            q: global coordinates, shape (n_q,).
            turns: Q of each element or one for all, shape (n_element, 3, 3) or (1, 3, 3); None for exact strains.
        """
        now = self._derivatives(q[self._coords] * self._scale)
        g = _vectors(now)
        n0 = surface_frame(g[0], g[1])[0]
        if turns is None:
            found = strains(g, surface_frame(g[0], g[1], self._cubed)[0], self._constants)
        else:
            own = np.einsum("dnc,nce->dne", now, turns[self._element % len(turns)])
            found = extrapolated_strains(_vectors(own), _vectors(self._rest), self._constants, self._cubed)
        local = np.einsum("nij,nj->ni", self._to_local, np.stack(found, axis=-1))
        return ShellPoints(now[0], np.stack(n0, axis=-1), local)

    def _derivatives(self, coordinates: Floats, which: slice = slice(None)) -> Floats:
        """Position and its derivatives at the points, shape (6, n, 3)."""
        return (self._shape[:, which] @ coordinates.reshape(len(coordinates), -1, 3)).transpose(1, 0, 2)


def _vectors(derivatives: Floats) -> tuple[Any, ...]:
    """r_x, r_y, r_xx, r_yy, r_xy as the expressions for strains take them."""
    return tuple(tuple(derivatives[d].T) for d in (1, 2, 3, 5, 4))
