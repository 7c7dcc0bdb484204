"""What an element is, as data, and the list of all elements."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from lamella.roles import Floats

ROUNDING = 1e-12
"""Share by which elements of a mesh differ that are alike: of coordinates that are a thousand elements away from 0."""


class ElementSpec(ABC):
    """A four-node shell element on the unit square 0 <= xi, eta <= 1 whose coordinates are vectors at the nodes.

    1. Element vectors are ordered node by node, in the order of ``nodes``, at each node in the order of ``vector_names``.
    2. ``r`` comes first and is a position; a name such as ``r_x`` is a derivative by the arc-length parameters x, y of the
       reference.
    3. r(xi, eta) = sum_k S_k(xi, eta) scale_k e_k, with S from ``shape`` and the factors from ``scales``.
    4. Shape functions reproduce rigid-body motion and constant slopes exactly.
    """

    name: ClassVar[str]
    nodes: ClassVar[tuple[tuple[int, int], ...]]
    """Place (xi, eta) of each node."""
    vector_names: ClassVar[tuple[str, ...]]
    """Names of the vectors of a node."""
    conforming: ClassVar[bool] = True
    """Whether the slope across an edge is the same in both elements that share it."""

    @property
    def vectors_per_node(self) -> int:
        """Vectors at each node."""
        return len(self.vector_names)

    @property
    def n_shape(self) -> int:
        """Shape functions, equal to the vectors of an element."""
        return len(self.nodes) * len(self.vector_names)

    @property
    def is_position(self) -> tuple[bool, ...]:
        """For each vector of a node, whether a translation changes it."""
        return tuple(name == "r" for name in self.vector_names)

    def _powers(self) -> list[tuple[int, int]]:
        """Numbers of derivatives by x and y in each vector of a node."""
        return [(name.count("x"), name.count("y")) for name in self.vector_names]

    def magnitudes(self, length: float) -> Floats:
        """Typical size of a change of each vector of a node.

        Args:
            length: size of the body [m].

        Returns:
            length^(1 - derivatives): [m] for r, 1 for r_x and r_y, [1/m] for r_xy, shape (vectors_per_node,).
        """
        return np.array([length ** (1.0 - px - py) for px, py in self._powers()])

    def scales(self, l_x: ArrayLike, l_y: ArrayLike) -> Floats:
        """Factors l_x^px l_y^py that turn derivatives by x, y into derivatives by xi, eta.

        Args:
            l_x: element lengths along x [m], shape (...).
            l_y: element lengths along y [m], shape (...).

        Returns:
            One factor for each element vector, shape (..., n_shape).
        """
        l_x, l_y = np.asarray(l_x, float), np.asarray(l_y, float)
        return np.stack([l_x**px * l_y**py for px, py in self._powers()] * len(self.nodes), axis=-1)

    def repeats(self, coordinates: Floats) -> bool:
        """Whether all elements of a mesh are the first one displaced, but for rounding.

        Args:
            coordinates: scaled coordinates, shape (n_element, 3 n_shape).
        """
        vectors = coordinates.reshape(len(coordinates), self.n_shape, 3)
        change = vectors - vectors[:1]
        change[:, :: self.vectors_per_node] -= change[:, :1]  # of positions, which come first at each node
        corners = vectors[0, :: self.vectors_per_node]
        size = min(np.linalg.norm(corners[1] - corners[0]), np.linalg.norm(corners[3] - corners[0]))
        return bool(np.abs(change).max() <= ROUNDING * size)

    @abstractmethod
    def shape(self, xi: ArrayLike, eta: ArrayLike) -> Floats:
        """Shape functions and their derivatives by xi, eta.

        Args:
            xi: first coordinate in [0, 1], shape (...).
            eta: second coordinate in [0, 1], shape (...).

        Returns:
            S, S_xi, S_eta, S_xixi, S_xieta, S_etaeta, shape (6, ..., n_shape).
        """


ELEMENTS: dict[str, ElementSpec] = {}
"""All elements by name, filled when the package ``lamella.element`` is imported."""
