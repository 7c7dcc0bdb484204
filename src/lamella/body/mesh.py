"""The compiled form of a plate or shell: node numbers, element tables, and where its points are."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Protocol

import numpy as np

from lamella.body.grid import Grid
from lamella.body.mesh_checks import check_folds, check_loops
from lamella.body.sample import PlateSample
from lamella.element.base import ElementSpec
from lamella.element.plate48.section import Curvature, Section
from lamella.kinematics import PointRows
from lamella.material.laminate import Laminate
from lamella.roles import Floats, Ints
from lamella.surface.base import Surface, SurfacePoints


class TemperatureSource(Protocol):
    """A temperature field of a plate; ``reference`` is the absolute temperature T_0 of T = T_0 + T_N + z T_M."""

    reference: float

    def at(self, q: Floats, x: Floats, y: Floats) -> tuple[Floats, Floats]:
        """T_N [K] and T_M [K/m] at points (x, y) [m], from all coordinates."""
        ...


class PlateMesh:
    """A rectangle of nx times ny elements; node (i, j) has number j nodes_x + i, its vectors are contiguous.

    Where the surface closes on itself, the last elements end at the first nodes.

    Args:
        name: the body's name.
        surface: the reference surface in the body's axes.
        counts: numbers of elements along x and y.
        element: the finite element.
        laminate: the section.
        strain: the strain model's name.
        curvature: the definition of curvature.
        membrane_gauss: Gauss points for the in-plane forces, see :class:`Section`.

    Raises:
        DeclarationError: a surface whose ends should meet and do not, or too few elements around.
    """

    def __init__(
        self,
        name: str,
        surface: Surface,
        counts: tuple[int, int],
        element: ElementSpec,
        laminate: Laminate,
        strain: str,
        curvature: Curvature = "unit_normal",
        membrane_gauss: int | None = None,
    ) -> None:
        self.name, self.surface, self.element, self.laminate, self.strain = name, surface, element, laminate, strain
        self.size = size = surface.size
        self.section = Section(laminate.stiffness, curvature=curvature, membrane_gauss=membrane_gauss)
        self.mass_per_area: float | Floats = laminate.mass_per_area
        self.thickness_factors: Floats | None = None
        self.temperature: TemperatureSource | None = None
        self.turns: Callable[[Floats], Floats] | None = None
        """Turns of the frames of a small-deformation model in a configuration (n_q,), shape (n_element, 3, 3) or (1, 3, 3)."""
        self._grids: dict[int, Grid] = {}
        self._located: dict[tuple[float, float], PointRows] = {}
        self.nx, self.ny = counts
        self.lx, self.ly = size[0] / self.nx, size[1] / self.ny
        self.loops = surface.loops
        check_loops(name, surface, counts)
        self.nodes_x, self.nodes_y = self.nx + (not self.loops[0]), self.ny + (not self.loops[1])
        self.n_nodes = self.nodes_x * self.nodes_y
        per_node = element.vectors_per_node
        self.is_position = np.tile(np.asarray(element.is_position, bool), self.n_nodes)
        self.magnitude = np.tile(element.magnitudes(max(size)), self.n_nodes)
        j, i = np.divmod(np.arange(self.nx * self.ny), self.nx)
        self._corner_i, self._corner_j = (np.stack([k + node[d] for node in element.nodes], axis=1) for d, k in enumerate((i, j)))
        self.corners: Ints = self.node(self._corner_i, self._corner_j)
        """Numbers of the nodes of each element, shape (n_element, 4)."""
        self.element_vectors: Ints = (per_node * self.corners[:, :, None] + np.arange(per_node)).reshape(len(i), -1)
        """Numbers of the vectors of each element among those of the body, shape (n_element, n_shape)."""
        self.scale = np.tile(np.repeat(element.scales(self.lx, self.ly), 3), (len(i), 1))

    def node(self, i: Ints, j: Ints) -> Ints:
        """Number of the node (i, j); beyond the end of a closed direction it is counted from the beginning."""
        return (j % self.nodes_y) * self.nodes_x + i % self.nodes_x

    def node_vectors(self) -> Floats:
        """Nodal vectors of the reference surface in the body's axes, shape (n_nodes * vectors_per_node, 3)."""
        j, i = np.divmod(np.arange(self.n_nodes), self.nodes_x)
        return self.surface.at(i * self.lx, j * self.ly).vectors(self.element.vector_names).reshape(-1, 3)

    def corner_vectors(self, surface: Surface) -> Floats:
        """Vectors of every element's nodes on a surface, by their share of its lengths, shape (n_element, n_shape, 3).

        Slopes are derivatives by the parameters of this mesh. Elements on both sides of a seam have their own values there.
        """
        shares = self._corner_i.reshape(-1) / self.nx, self._corner_j.reshape(-1) / self.ny
        points = surface.at(shares[0] * surface.size[0], shares[1] * surface.size[1])
        f_x, f_y = (own / length for own, length in zip(surface.size, self.size, strict=True))
        scaled = SurfacePoints(points.r, f_x * points.r_x, f_y * points.r_y, f_x * f_y * points.r_xy)
        return scaled.vectors(self.element.vector_names).reshape(len(self.corners), -1, 3)

    def thicken(self, factors: Floats) -> None:
        """Multiply all heights of the section, element by element, shape (n_element,)."""
        self.thickness_factors = factors
        powers = np.array([[1.0, 2.0], [2.0, 3.0]]).repeat(3, axis=0).repeat(3, axis=1)  # of the height in A, B, D
        self.section = replace(self.section, stiffness=factors[:, None, None] ** powers * self.laminate.stiffness)
        self.mass_per_area = factors * self.laminate.mass_per_area

    def orient(self, direction: Floats | None, prestrain: tuple[float, float, float] | None) -> None:
        """Take the material direction, in the inertial frame, and the strains of the reference configuration."""
        strains = None if prestrain is None else np.asarray(prestrain, float)
        self.section = replace(self.section, direction=direction, prestrain=strains)

    def place(self, first: int, rest: Floats) -> None:
        """Take the number of the first vector and the stress-free configuration, shape (n_element, n_shape, 3).

        Raises:
            DeclarationError: it folds or degenerates.
        """
        self.first = first
        local = (3 * self.element_vectors[:, :, None] + np.arange(3)).reshape(len(self.element_vectors), -1)
        self.coords: Ints = (local + 3 * first).astype(np.int64)
        self.reference: Floats = rest.reshape(len(rest), -1)
        check_folds(self)

    def vector(self, node: int, name: str) -> int:
        """Number of a nodal vector, by the node's number and the vector's name."""
        return self.first + self.element.vectors_per_node * node + self.element.vector_names.index(name)

    def describe(self, vector: int) -> str:
        """A nodal vector of this plate in words, by its number."""
        node, place = divmod(vector - self.first, self.element.vectors_per_node)
        j, i = divmod(node, self.nodes_x)
        return f"{self.element.vector_names[place]} at node ({i}, {j}) of plate '{self.name}'"

    def find(self, x: float, y: float) -> tuple[int, float, float]:
        """Element and its coordinates xi, eta in [0, 1] of a point of the plate."""
        i, j = min(int(x / self.lx), self.nx - 1), min(int(y / self.ly), self.ny - 1)
        return j * self.nx + i, x / self.lx - i, y / self.ly - j

    def locate(self, at: tuple[float, float]) -> PointRows:
        """Weights of the coordinate vectors at a point (x, y) [m]; weights at rounding level are dropped."""
        return self.locate_each([at])[0]

    def locate_each(self, places: Sequence[tuple[float, float]]) -> list[PointRows]:
        """The same at several points, in one evaluation of the shape functions."""
        missing = [at for at in dict.fromkeys(places) if at not in self._located]
        if missing:
            self._located.update(zip(missing, self._locate(missing), strict=True))
        return [self._located[at] for at in places]

    def _locate(self, places: Sequence[tuple[float, float]]) -> list[PointRows]:
        index, xi, eta = (np.array(each) for each in zip(*(self.find(*at) for at in places), strict=True))
        scale, vectors = self.scale[index, ::3], self.coords[index, ::3] // 3
        rows = self.element.shape(xi, eta)[:3] * scale / np.array([1.0, self.lx, self.ly])[:, None, None]
        rows[np.abs(rows) < 1e-13 * np.abs(rows).max(axis=2, keepdims=True)] = 0.0
        used = np.any(rows != 0.0, axis=0)
        return [
            PointRows(vectors[k, own], rows[0, k, own], rows[1, k, own], rows[2, k, own], np.zeros(3))
            for k, own in enumerate(used)
        ]

    def edge_nodes(self, side: str) -> Ints:
        """Numbers of the nodes on an edge, in ascending order of the parameter along it."""
        along_x = side[0] == "y"
        k = np.arange(self.nodes_x if along_x else self.nodes_y)
        end = np.full_like(k, 0 if side[1] == "-" else (self.ny if along_x else self.nx))
        return self.node(k, end) if along_x else self.node(end, k)

    def edge_slope(self, side: str) -> tuple[str, str]:
        """Names of the nodal slopes along and across an edge."""
        return ("r_y", "r_x") if side[0] == "x" else ("r_x", "r_y")

    def edge_points(self, side: str, per_element: Floats) -> tuple[list[tuple[float, float]], float]:
        """Points at the relative places ``per_element`` in [0, 1] of each element on an edge, and the elements' length."""
        along, count, length = (1, self.ny, self.ly) if side[0] == "x" else (0, self.nx, self.lx)
        fixed = 0.0 if side[1] == "-" else self.size[1 - along]
        places = [(k + s) * length for k in range(count) for s in per_element]
        return [(fixed, s) if along else (s, fixed) for s in places], length

    def grid(self, per_element: int = 4) -> Grid:
        """A regular grid over the whole plate, with so many intervals along each side of an element; made once."""
        if per_element not in self._grids:
            xi, eta = (np.linspace(0.0, n, n * per_element + 1) for n in (self.nx, self.ny))
            self._grids[per_element] = Grid(self, xi, eta)
        return self._grids[per_element]

    def sample(self, q: Floats, per_element: int = 4) -> PlateSample:
        """Positions, normals and strains on a regular grid in the configuration ``q`` (n_q,)."""
        return self.grid(per_element).sample(q)
