"""Shape functions of Plate48: products of cubic Hermite polynomials."""

from __future__ import annotations

from functools import cache
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from lamella.element.base import ElementSpec
from lamella.math.gauss import gauss_rule
from lamella.math.hermite import cubic_hermite
from lamella.roles import Floats, Ints

DERIVATIVES = ((0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2))
"""Numbers of derivatives by xi and eta in the order of :meth:`ElementSpec.shape`."""


class Plate48(ElementSpec):
    """Bogner-Fox-Schmit element: r, r_x, r_y, r_xy at four nodes, counter-clockwise from (0, 0).

    Source: Bogner, Fox, Schmit, Proc. Conf. Matrix Methods in Structural Mechanics (1965), 397-443.
    """

    name: ClassVar[str] = "plate48"
    nodes: ClassVar[tuple[tuple[int, int], ...]] = ((0, 0), (1, 0), (1, 1), (0, 1))
    vector_names: ClassVar[tuple[str, ...]] = ("r", "r_x", "r_y", "r_xy")

    def factors(self) -> tuple[Ints, Ints]:
        """Numbers a, b of the polynomials whose product phi_a(xi) phi_b(eta) each shape function is, shapes (16,)."""
        a = [2 * i + power_x for i, _ in self.nodes for power_x, _ in self._powers()]
        b = [2 * j + power_y for _, j in self.nodes for _, power_y in self._powers()]
        return np.array(a), np.array(b)

    def shape(self, xi: ArrayLike, eta: ArrayLike) -> Floats:
        """Shape functions and derivatives, see :meth:`ElementSpec.shape`."""
        (a, b), (by_xi, by_eta) = _factors(), np.array(DERIVATIVES).T
        phi_xi, phi_eta = cubic_hermite(xi)[by_xi[:, None], a], cubic_hermite(eta)[by_eta[:, None], b]
        return np.ascontiguousarray(np.moveaxis(phi_xi * phi_eta, 1, -1))


@cache
def _factors() -> tuple[Ints, Ints]:
    return Plate48().factors()


PLATE48 = Plate48()


@cache
def gauss_points(n: int) -> tuple[Floats, Floats, Floats]:
    """Points and weights of the n x n Gauss rule on the unit square, xi fastest.

    Returns:
        xi, eta and weights, shapes (n n,).
    """
    points, weights = gauss_rule(n)
    found = np.tile(points, n), np.repeat(points, n), (weights[:, None] * weights[None, :]).reshape(-1)
    for array in found:
        array.flags.writeable = False  # all who ask share them
    return found


@cache
def shape_at_gauss_points(element: ElementSpec, n: int) -> Floats:
    """Shape functions and derivatives at the points of the n x n Gauss rule, see :meth:`ElementSpec.shape`."""
    found = element.shape(*gauss_points(n)[:2])
    found.flags.writeable = False  # all who ask share it
    return found


def hermite_table(n: int) -> Floats:
    """Cubic Hermite polynomials at the n Gauss points for the kernels: (point, derivative, function), flat."""
    return _hermite(n).copy()


@cache
def _hermite(n: int) -> Floats:
    return np.ascontiguousarray(np.moveaxis(cubic_hermite(gauss_rule(n)[0]), -1, 0)).reshape(-1)


@cache
def product_order() -> Ints:
    """Place in element order of the coordinate (a, b, component) of the kernels, shape (48,)."""
    a, b = _factors()
    vector = np.empty(16, np.int64)
    vector[4 * a + b] = np.arange(16)
    found = (3 * vector[:, None] + np.arange(3)).reshape(-1)
    found.flags.writeable = False  # all who ask share it
    return found
