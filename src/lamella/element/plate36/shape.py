"""Shape functions of Plate36: the incomplete bicubic polynomial of Adini, Clough and Melosh."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from lamella.element.base import ElementSpec
from lamella.element.plate48.shape import DERIVATIVES, Plate48
from lamella.math.hermite import cubic_hermite
from lamella.roles import Floats


class Plate36(ElementSpec):
    """Dufva-Shabana element: r, r_x, r_y at four nodes, counter-clockwise from (0, 0).

    The twelve functions span 1, x, y, x^2, xy, y^2, x^3, x^2 y, x y^2, y^3, x^3 y, x y^3. With the cubic Hermite polynomials phi
    of value and psi of slope, and the linear ones L, those of the node (i, j) are

        S_r   = phi_i(xi) L_j(eta) + L_i(xi) phi_j(eta) - L_i(xi) L_j(eta)
        S_r_x = psi_i(xi) L_j(eta),     S_r_y = L_i(xi) psi_j(eta)

    the Coons patch of four cubic edges. The surface is continuous from element to element. The slope across an edge is not but
    at the nodes: along the edge it depends on the far nodes of each element too.

    Sources: Dufva and Shabana, Proc. IMechE K 219 (2005) 345-355; Adini and Clough, Analysis of plate bending by the finite
    element method, report to the National Science Foundation, G7337 (1960); Melosh, AIAA J. 1 (1963) 1631-1637.
    """

    name: ClassVar[str] = "plate36"
    nodes: ClassVar[tuple[tuple[int, int], ...]] = ((0, 0), (1, 0), (1, 1), (0, 1))
    vector_names: ClassVar[tuple[str, ...]] = ("r", "r_x", "r_y")
    conforming: ClassVar[bool] = False

    def shape(self, xi: ArrayLike, eta: ArrayLike) -> Floats:
        """Shape functions and derivatives, see :meth:`ElementSpec.shape`."""
        (cubic_x, linear_x), (cubic_y, linear_y) = _polynomials(xi), _polynomials(eta)
        functions = []
        for i, j in self.nodes:
            for p, q in DERIVATIVES:
                phi_x, psi_x = cubic_x[p, 2 * i], cubic_x[p, 2 * i + 1]
                phi_y, psi_y = cubic_y[q, 2 * j], cubic_y[q, 2 * j + 1]
                l_x, l_y = linear_x[p, i], linear_y[q, j]
                functions.append((phi_x * l_y + l_x * phi_y - l_x * l_y, psi_x * l_y, l_x * psi_y))
        values = np.array(functions)
        by_node = np.moveaxis(values.reshape(len(self.nodes), len(DERIVATIVES), *values.shape[1:]), 1, 0)
        return np.moveaxis(by_node.reshape(len(DERIVATIVES), self.n_shape, *values.shape[2:]), 1, -1)


def _polynomials(s: ArrayLike) -> tuple[Floats, Floats]:
    """Cubic Hermite and linear polynomials with two derivatives, shapes (3, 4, ...) and (3, 2, ...)."""
    s = np.asarray(s, float)
    one, zero = np.ones_like(s), np.zeros_like(s)
    return cubic_hermite(s), np.array([[1 - s, s], [-one, one], [zero, zero]])


def expansion() -> Floats:
    """The matrix P of e48 = P e36, the coordinates of a Plate48 of the same shape, both scaled to the unit square.

    The functions of Plate36 are among those of Plate48, so its values and derivatives at the nodes are all that is needed: P
    holds ones where both have the coordinate, and the twists

        r_xieta = change of r_eta along the edge by xi + change of r_xi along that by eta - (r_00 - r_10 + r_11 - r_01)

    Returns:
        Shape (16, 12); one number acts on all three components of a vector.
    """
    rows = {(px, py): d for d, (px, py) in enumerate(DERIVATIVES)}
    full = Plate48()
    at_nodes = [Plate36().shape(*node) for node in full.nodes]
    return np.array([values[rows[name.count("x"), name.count("y")]] for values in at_nodes for name in full.vector_names])
