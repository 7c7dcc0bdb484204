"""The compiled form of a plate: node numbers, element tables, and where its points are."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from lamella.body.sample import PlateSample
from lamella.element.base import ElementSpec
from lamella.element.plate48.recovery import ShellRecovery
from lamella.element.plate48.section import Curvature, Section
from lamella.kinematics import PointRows
from lamella.material.laminate import Laminate
from lamella.roles import Floats, Ints


class TemperatureSource(Protocol):
    """A temperature field of a plate; ``reference`` is the absolute temperature T_0 of T = T_0 + T_N + z T_M."""

    reference: float

    def at(self, q: Floats, x: Floats, y: Floats) -> tuple[Floats, Floats]:
        """T_N [K] and T_M [K/m] at points (x, y) [m], from all coordinates."""
        ...


class PlateMesh:
    """A rectangle of nx times ny elements; node (i, j) has number j (nx + 1) + i, its vectors are contiguous.

    Args:
        name: the plate's name.
        size: lengths along x and y [m].
        counts: numbers of elements along x and y.
        element: the finite element.
        laminate: the section.
        strain: the strain model's name.
        curvature: the definition of curvature.
        membrane_gauss: Gauss points for the in-plane forces, see :class:`Section`.
    """

    def __init__(
        self,
        name: str,
        size: tuple[float, float],
        counts: tuple[int, int],
        element: ElementSpec,
        laminate: Laminate,
        strain: str,
        curvature: Curvature = "unit_normal",
        membrane_gauss: int | None = None,
    ) -> None:
        self.name, self.size, self.element, self.laminate, self.strain = name, size, element, laminate, strain
        self.section = Section(laminate.stiffness, curvature=curvature, membrane_gauss=membrane_gauss)
        self.temperature: TemperatureSource | None = None
        self.nx, self.ny = counts
        self.lx, self.ly = size[0] / self.nx, size[1] / self.ny
        self.n_nodes = (self.nx + 1) * (self.ny + 1)
        per_node = element.vectors_per_node
        self.is_position = np.tile(np.asarray(element.is_position, bool), self.n_nodes)
        self.magnitude = np.tile(element.magnitudes(max(size)), self.n_nodes)
        i, j = np.meshgrid(np.arange(self.nx), np.arange(self.ny))
        corner = np.stack([(j + dj) * (self.nx + 1) + i + di for di, dj in element.nodes], axis=-1).reshape(
            -1, len(element.nodes)
        )
        self._element_vectors = (per_node * corner[:, :, None] + np.arange(per_node)).reshape(len(corner), -1)
        self.scale = np.tile(np.repeat(element.scales(self.lx, self.ly), 3), (len(corner), 1))

    def flat_vectors(self) -> Floats:
        """Nodal vectors of the flat rectangle in its own axes, shape (n_nodes * vectors_per_node, 3)."""
        j, i = np.divmod(np.arange(self.n_nodes), self.nx + 1)
        values = {"r": np.stack([i * self.lx, j * self.ly, 0.0 * i], axis=1), "r_x": (1.0, 0.0, 0.0), "r_y": (0.0, 1.0, 0.0)}
        return np.stack(
            [np.broadcast_to(values.get(name, (0.0, 0.0, 0.0)), (self.n_nodes, 3)) for name in self.element.vector_names], axis=1
        ).reshape(-1, 3)

    def place(self, first: int, vectors: Floats) -> None:
        """Take the number of the first vector and the reference configuration, shape (n_vectors, 3)."""
        self.first = first
        local = (3 * self._element_vectors[:, :, None] + np.arange(3)).reshape(len(self._element_vectors), -1)
        self.coords: Ints = (local + 3 * first).astype(np.int64)
        self.reference: Floats = vectors.reshape(-1)[local]

    def vector(self, node: int, name: str) -> int:
        """Number of a nodal vector, by the node's number and the vector's name."""
        return self.first + self.element.vectors_per_node * node + self.element.vector_names.index(name)

    def describe(self, vector: int) -> str:
        """A nodal vector of this plate in words, by its number."""
        node, place = divmod(vector - self.first, self.element.vectors_per_node)
        j, i = divmod(node, self.nx + 1)
        return f"{self.element.vector_names[place]} at node ({i}, {j}) of plate '{self.name}'"

    def find(self, x: float, y: float) -> tuple[int, float, float]:
        """Element and its coordinates xi, eta in [0, 1] of a point of the plate."""
        i, j = min(int(x / self.lx), self.nx - 1), min(int(y / self.ly), self.ny - 1)
        return j * self.nx + i, x / self.lx - i, y / self.ly - j

    def locate(self, at: tuple[float, float]) -> PointRows:
        """Weights of the coordinate vectors at a point (x, y) [m]; weights at rounding level are dropped."""
        index, xi, eta = self.find(*at)
        values, d_xi, d_eta = self.element.shape(np.array([xi]), np.array([eta]))[:3, 0]
        scale = self.scale[index, ::3]
        rows = np.stack([values * scale, d_xi * scale / self.lx, d_eta * scale / self.ly])
        rows[np.abs(rows) < 1e-13 * np.abs(rows).max(axis=1, keepdims=True)] = 0.0
        used = np.any(rows != 0.0, axis=0)
        vectors = self.coords[index, ::3][used] // 3
        return PointRows(vectors, rows[0, used], rows[1, used], rows[2, used], np.zeros(3))

    def edge_nodes(self, side: str) -> Ints:
        """Numbers of the nodes on an edge, in ascending order of the parameter along it."""
        row = np.arange(self.nx + 1)
        column = np.arange(self.ny + 1) * (self.nx + 1)
        return {"x-": column, "x+": column + self.nx, "y-": row, "y+": row + self.ny * (self.nx + 1)}[side]

    def edge_slope(self, side: str) -> tuple[str, str]:
        """Names of the nodal slopes along and across an edge."""
        return ("r_y", "r_x") if side[0] == "x" else ("r_x", "r_y")

    def edge_points(self, side: str, per_element: Floats) -> tuple[list[tuple[float, float]], float]:
        """Points at the relative places ``per_element`` in [0, 1] of each element on an edge, and the elements' length."""
        along, count, length = (1, self.ny, self.ly) if side[0] == "x" else (0, self.nx, self.lx)
        fixed = 0.0 if side[1] == "-" else self.size[1 - along]
        places = [(k + s) * length for k in range(count) for s in per_element]
        return [(fixed, s) if along else (s, fixed) for s in places], length

    def sample(self, q: Floats, per_element: int = 4) -> PlateSample:
        """Positions, normals and strains on a structured grid in the configuration ``q`` (n_q,)."""
        xi = np.linspace(0.0, self.nx, self.nx * per_element + 1)
        eta = np.linspace(0.0, self.ny, self.ny * per_element + 1)
        i, j = np.minimum(xi.astype(int), self.nx - 1), np.minimum(eta.astype(int), self.ny - 1)
        index = (j[:, None] * self.nx + i[None, :]).reshape(-1)
        points_xi = np.broadcast_to(xi - i, (len(eta), len(xi))).reshape(-1)
        points_eta = np.broadcast_to((eta - j)[:, None], (len(eta), len(xi))).reshape(-1)
        recovery = ShellRecovery(
            self.element, self.coords, self.scale, self.reference, self.section.direction, self.section.curvature
        )
        found = recovery.at(q, index, points_xi, points_eta)
        shape = (len(eta), len(xi), -1)
        heat: tuple[Floats, Floats] | tuple[()] = ()
        if self.temperature is not None:
            y, x = np.meshgrid(eta * self.ly, xi * self.lx, indexing="ij")
            T_N, T_M = self.temperature.at(q, x.reshape(-1), y.reshape(-1))
            heat = T_N.reshape(x.shape), T_M.reshape(x.shape)
        return PlateSample(
            self.laminate,
            xi * self.lx,
            eta * self.ly,
            found.r.reshape(shape),
            found.n.reshape(shape),
            found.strains.reshape(shape),
            *heat,
        )
