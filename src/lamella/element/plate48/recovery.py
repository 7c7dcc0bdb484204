"""Positions, normals and strains of a shell at any point."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from scipy import sparse

from lamella.element.base import ElementSpec
from lamella.element.plate48.section import Curvature
from lamella.element.plate48.strain import Cubed, extrapolated_strains, strains, surface_frame
from lamella.element.plate48.surface import reference_surface
from lamella.roles import Floats, Ints


@dataclass(frozen=True)
class ShellPoints:
    """A shell at n points, in one configuration or in a stack of them (...).

    Args:
        r: positions [m], shape (..., n, 3).
        n: unit normals, shape (..., n, 3).
        strains: (eps_11, eps_22, 2 eps_12 [-], kap_11, kap_22, 2 kap_12 [1/m]) in the local orthonormal frame whose first
            axis is the material direction, shape (..., n, 6).
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

    Positions and their derivatives are one sparse matrix times the coordinates, of as many configurations as there are at once.

    Args:
        element: number of the element of each point, shape (n,).
        shape: shape functions and their derivatives, shape (n, 6, n_shape).
        coords: global coordinates of the elements, those of a vector one after another, shape (n, n_coordinate).
        scale: factors from global to element coordinates, one for each vector, likewise.
        rest: element coordinates of the reference, likewise.
        direction: the material direction.
        cubed: the definition of kap.
    """

    def __init__(
        self, element: Ints, shape: Floats, coords: Ints, scale: Floats, rest: Floats, direction: Floats | None, cubed: Cubed
    ) -> None:
        n, _, n_shape = shape.shape
        vectors, weights = coords[:, ::3] // 3, (shape * scale[:, None, ::3]).transpose(1, 0, 2)
        table = weights.reshape(-1), np.tile(vectors, (6, 1)).reshape(-1), np.arange(6 * n + 1) * n_shape
        self._n, self._n_vectors, self._element = n, int(vectors.max()) + 1, element
        self._derivatives = sparse.csr_array(table, shape=(6 * n, self._n_vectors))
        self._cubed: Cubed = cubed
        at_rest = (shape @ rest.reshape(n, -1, 3)).transpose(1, 0, 2)
        reference = reference_surface("strain recovery", at_rest, direction)
        self._rest = _vectors(at_rest.transpose(0, 2, 1)[..., None])
        self._constants, self._to_local = tuple(reference.constants(cubed).T[..., None]), reference.strain_transform(cubed)

    @cached_property
    def _positions(self) -> sparse.csr_array:
        return self._derivatives[: self._n]

    def positions(self, q: Floats) -> Floats:
        """Positions [m], shape (..., n, 3), in the configurations ``q`` (..., n_q)."""
        return _by_configuration(self._components(self._positions, q)[0], q)

    def at(self, q: Floats, turns: Floats | None = None) -> ShellPoints:
        """Position, unit normal and strains.

        The strains are the exact ones s(g), or those of a small-deformation model, which are linear in the frame of the element:
        ds/dg (G) . (Q^T g - G) with the derivatives g of the position, G those of the reference, and the turn Q of the frame.

        Args:
            q: global coordinates, shape (..., n_q).
            turns: Q of each element or one for all, shape (..., n_element, 3, 3) or (..., 1, 3, 3); None for exact strains.
        """
        now = self._components(self._derivatives, q)
        g = _vectors(now)
        n0 = surface_frame(g[0], g[1])[0]
        if turns is None:
            m = n0 if self._cubed is None else surface_frame(g[0], g[1], self._cubed)[0]
            found = strains(g, m, self._constants)
        else:
            frames = turns.reshape(-1, *turns.shape[-3:])[:, self._element % turns.shape[-3]]
            own = np.einsum("dcns,snce->dens", now, frames)
            found = extrapolated_strains(_vectors(own), self._rest, self._constants, self._cubed)
        local = self._to_local @ np.stack(found, axis=1)
        return ShellPoints(*(_by_configuration(values, q) for values in (now[0], np.stack(n0), local.transpose(1, 0, 2))))

    def _components(self, matrix: sparse.csr_array, q: Floats) -> Floats:
        """Components of the position, and of its derivatives, at the points in s configurations, shape (6 or 1, 3, n, s)."""
        stack = q.reshape(-1, q.shape[-1])[:, : 3 * self._n_vectors].T
        found = matrix @ stack.reshape(self._n_vectors, -1)
        return np.ascontiguousarray(found.reshape(-1, self._n, 3, stack.shape[1]).swapaxes(1, 2))


def _by_configuration(components: Floats, q: Floats) -> Floats:
    """Components (k, n, s) at the points in the s configurations ``q`` (..., n_q), as an array (..., n, k)."""
    return np.ascontiguousarray(components.T).reshape(*q.shape[:-1], components.shape[1], len(components))


def _vectors(derivatives: Floats) -> tuple[Any, ...]:
    """r_x, r_y, r_xx, r_yy, r_xy (6, 3, ...) as the expressions for strains take them."""
    return tuple(tuple(derivatives[d]) for d in (1, 2, 3, 5, 4))
