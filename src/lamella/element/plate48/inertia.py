"""Inertia of shells."""

from __future__ import annotations

from functools import cache, cached_property

import numpy as np

from lamella.element.base import ElementSpec
from lamella.element.plate48.shape import PLATE48, gauss_points, shape_at_gauss_points
from lamella.element.plate48.surface import areas_of, derivatives_at_points
from lamella.errors import ModelError
from lamella.roles import Bools, Floats, InertiaBlock, Ints


class ShellInertia(InertiaBlock):
    """Consistent mass matrix M = int m S^T S dA of the reference surface; rotary inertia of the section is neglected.

    4 x 4 Gauss points integrate it exactly on rectangles (degree 6 in each direction).

    Args:
        name: name of the body, for messages.
        coords: global coordinates of each element in element order, shape (n_element, n_coordinate).
        scale: factors from global to element coordinates, shape (n_element, n_coordinate).
        reference: unscaled reference coordinates, shape (n_element, n_coordinate).
        mass_per_area: m [kg/m^2], a number or shape (n_element,).
        n_gauss: Gauss points in each direction.
        element: the finite element.

    Raises:
        ModelError: the mass per area is not positive; or, when the mass is asked for, the reference surface has no area.
    """

    def __init__(
        self,
        name: str,
        coords: Ints,
        scale: Floats,
        reference: Floats,
        mass_per_area: float | Floats,
        n_gauss: int = 4,
        element: ElementSpec = PLATE48,
    ) -> None:
        self.name = name
        density = np.broadcast_to(np.asarray(mass_per_area, float), (len(coords),))
        if not np.all(density > 0):
            raise ModelError(f"{name}: mass per area is {density.min():g} kg/m^2; accepted is a positive number")
        self._density, self._n_gauss, self._element = density, n_gauss, element
        self._rest, self._factors = np.asarray(reference, float) * scale, np.asarray(scale, float)[:, ::3]
        self._vectors = np.asarray(coords, np.int64)[:, ::3] // 3

    @cached_property
    def _values(self) -> Floats:
        """Masses of all entries, shape (n_element, n_shape, n_shape)."""
        n, factors = len(self._rest), self._factors
        own = slice(1) if self._element.repeats(self._rest) else slice(n)
        shape = shape_at_gauss_points(self._element, self._n_gauss)
        area = areas_of(self.name, derivatives_at_points(shape[:3], self._rest[own]))
        products = (shape[0][:, :, None] * shape[0][:, None, :]).reshape(len(shape[0]), -1)
        matrices = (gauss_points(self._n_gauss)[2] * area @ products).reshape(-1, *[shape.shape[-1]] * 2)
        if len(matrices) == 1 and np.all(factors == factors[0]) and np.all(self._density == self._density[0]):
            one = self._density[0] * matrices[0] * factors[0][:, None] * factors[0]
            return np.broadcast_to(one, (n, *one.shape))
        return self._density[:, None, None] * matrices * factors[:, :, None] * factors[:, None, :]

    def mass(self) -> tuple[Ints, Ints, Floats]:
        """Vectors and masses of all entries."""
        n = self._vectors.shape[1]
        i, j = np.repeat(self._vectors, n, axis=1), np.tile(self._vectors, n)
        return i.reshape(-1), j.reshape(-1), self._values.reshape(-1)

    def coupled_with(self, chosen: Bools) -> Ints:
        """Those of the elements that have some of the vectors."""
        return self._vectors[chosen[self._vectors].any(axis=1)].reshape(-1)

    def pairs(self) -> tuple[Ints, Ints]:
        """Vectors of all entries, each pair of an element once."""
        i, j = _pairs(self._vectors.shape[1])
        return self._vectors[:, i].reshape(-1), self._vectors[:, j].reshape(-1)


@cache
def _pairs(n: int) -> tuple[Ints, Ints]:
    return np.triu_indices(n)
