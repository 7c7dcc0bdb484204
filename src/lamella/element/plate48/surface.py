"""Geometry of the reference surface: metric, curvature, area and the local orthonormal frame.

The first axis of the local frame is the material direction: that of the reference r_x, or the projection of a given vector on the
surface. The third is the unit normal. Strains that refer to the parameters xi, eta are components on the dual basis G^1, G^2 of
the surface; with J^a_i = G^a . e_i they become

    E_ij = J^a_i J^b_j E_ab

in the local frame, a constant 3 x 3 matrix T for (E_11, E_22, 2 E_12).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lamella.element.base import ROUNDING
from lamella.element.plate48 import surface_kernels
from lamella.element.plate48.strain import Cubed
from lamella.errors import ModelError
from lamella.roles import Floats

NORMAL = 0.1
"""Sine of the angle to the normal below which a direction has no usable projection on the surface: nearby it turns over."""


@dataclass(frozen=True)
class ReferenceSurface:
    """The reference surface at points; every array has the shape (..., ) of the points in front.

    Args:
        area: |R_xi x R_eta|, area for a unit of xi eta [m^2].
        first: A11, A22, A12 of the parameters xi, eta [m^2], shape (..., 3).
        second: B11, B22, B12 [m], shape (..., 3).
        transform: T, from (E_11, E_22, 2 E_12) of the parameters to the local orthonormal frame [1/m^2], shape (..., 3, 3).
    """

    area: Floats
    first: Floats
    second: Floats
    transform: Floats

    @property
    def repeats(self) -> bool:
        """Whether all elements have the same numbers at the same points, but for rounding."""
        A11, A22 = self.first[:1, ..., 0], self.first[:1, ..., 1]
        size, area = np.stack([A11, A22, np.sqrt(A11 * A22)], axis=-1), self.area[:1]
        changes = (
            self.area / area - 1.0,
            (self.first - self.first[:1]) / size,
            (self.second - self.second[:1]) / size * np.sqrt(area)[..., None],
            (self.transform - self.transform[:1]) * size[..., None, :],
        )
        return all(float(np.abs(change).max()) <= ROUNDING for change in changes)

    def constants(self, cubed: Cubed) -> Floats:
        """A11/2, A22/2, A12 and B11, B22, B12 as the kernels' strains count from them, shape (..., 6).

        The cubed normal R_xi x R_eta / |R_xi x R_eta|^3 gives B divided by the area's square.
        """
        second = self.second if cubed is None else self.second / self.area[..., None] ** 2
        return np.concatenate([self.first * np.array([0.5, 0.5, 1.0]), second], axis=-1)

    def strain_transform(self, cubed: Cubed) -> Floats:
        """Transform of the kernels' strains (E_11, E_22, 2 E_12, K_11, K_22, K_12) to (eps, kap) with doubled shear and twist.

        With the cubed normal it has the area's square as a factor, J0^2 in kap_ab = (J0/J)^2 r_ab.n0 - B_ab.

        Returns:
            Shape (..., 6, 6).
        """
        full = np.zeros((*self.transform.shape[:-2], 6, 6))
        full[..., :3, :3] = self.transform
        full[..., 3:, 3:] = self.transform * np.array([1.0, 1.0, 2.0])
        if cubed is not None:
            full[..., 3:, 3:] *= self.area[..., None, None] ** 2
        return full


def derivatives_at_points(shape: Floats, coordinates: Floats) -> Floats:
    """Position and its derivatives at the same points of every element.

    Args:
        shape: S, S_xi, S_eta, S_xixi, S_xieta, S_etaeta, shape (6, n, n_shape).
        coordinates: scaled coordinates, shape (n_element, 3 n_shape).

    Returns:
        Shape (6, n_element, n, 3).
    """
    n, n_shape = shape.shape[1:]
    vectors = coordinates.reshape(-1, n_shape, 3).swapaxes(0, 1).reshape(n_shape, -1)
    return (shape.reshape(-1, n_shape) @ vectors).reshape(-1, n, len(coordinates), 3).swapaxes(1, 2)


def reference_surface(item: str, derivatives: Floats, direction: Floats | None = None) -> ReferenceSurface:
    """Geometry of the reference surface.

    Args:
        item: what is being built, for messages.
        derivatives: R, R_xi, R_eta, R_xixi, R_xieta, R_etaeta at the points, shape (6, n_element, ..., 3).
        direction: vector whose projection on the surface is the first axis of the local frame, shape (3,); R_xi when None.

    Raises:
        ModelError: the reference surface has no normal at a point of an element, or the direction is normal to it there.
    """
    points, front = _listed(derivatives), derivatives.shape[1:-1]
    area, first, second = np.empty(points.shape[1]), np.empty(points.shape[1:]), np.empty(points.shape[1:])
    surface_kernels.measure(points, area, first, second)
    _refuse_degenerate(item, area, front)
    area, first, second = area.reshape(front), first.reshape(*front, 3), second.reshape(*front, 3)
    axis = (1.0, 0.0) if direction is None else _projected(item, direction, derivatives, first, area)
    return ReferenceSurface(area, first, second, _strain_transform(first, area, *axis))


def areas_of(item: str, derivatives: Floats) -> Floats:
    """|R_xi x R_eta|, the area for a unit of xi eta; arguments as those of :func:`reference_surface`.

    Raises:
        ModelError: the reference surface has no normal at a point of an element.
    """
    points, front = _listed(derivatives[1:3]), derivatives.shape[1:-1]
    area = np.empty(points.shape[1])
    surface_kernels.areas(points, area)
    _refuse_degenerate(item, area, front)
    return area.reshape(front)


def _listed(derivatives: Floats) -> Floats:
    """Derivatives with their points in one row, shape (n_derivative, n_point, 3)."""
    return np.ascontiguousarray(derivatives).reshape(len(derivatives), -1, 3)


def _refuse_degenerate(item: str, area: Floats, front: tuple[int, ...]) -> None:
    """Refuse a point without area, which the kernels mark by a number below 0."""
    if area.min(initial=0.0) < 0.0:
        element = int(np.argmax(area < 0.0)) // int(np.prod(front[1:]))
        raise ModelError(
            f"{item}: element {element} has no area in the reference configuration; r_x and r_y must not be parallel"
        )


def _projected(item: str, direction: Floats, derivatives: Floats, first: Floats, area: Floats) -> tuple[Floats, Floats]:
    """Components by r_x and r_y of the projection of a vector on the surface at every point."""
    vector = np.asarray(direction, float)
    by_x, by_y = derivatives[1] @ vector, derivatives[2] @ vector
    A11, A22, A12 = np.moveaxis(first, -1, 0)
    axis = (A22 * by_x - A12 * by_y) / area**2, (A11 * by_y - A12 * by_x) / area**2
    bad = np.argwhere(~(axis[0] * by_x + axis[1] * by_y > NORMAL**2 * (vector @ vector)))
    if len(bad):
        at = ", ".join(f"{x:.4g}" for x in derivatives[0][tuple(bad[0])])
        raise ModelError(
            f"{item}: the ply direction ({', '.join(f'{x:g}' for x in vector)}) is normal to the surface near ({at}) m in "
            f"element {bad[0, 0]}; accepted is a direction with a projection on the surface everywhere"
        )
    return axis


def _strain_transform(first: Floats, area: Floats, alpha: Floats | float, beta: Floats | float) -> Floats:
    """The matrix T of the module's docstring, for local frames whose first axis has the direction alpha r_x + beta r_y.

    e_2 = n0 x e_1, and n0 x r_x = J0 G^2, n0 x r_y = -J0 G^1 with the area element J0.
    """
    transform, every = np.empty((area.size, 3, 3)), np.empty((2, *area.shape))
    every[0], every[1] = alpha, beta
    surface_kernels.strain_transforms(first.reshape(-1, 3), area.reshape(-1), every.reshape(2, -1), transform)
    return transform.reshape(*area.shape, 3, 3)
