"""Nodes of plate edges as vectors, and edges laid upon each other."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lamella.body.mesh import PlateMesh
from lamella.body.plate import Edge
from lamella.dofs import Build
from lamella.errors import DeclarationError
from lamella.kinematics import PointRows, VectorRows
from lamella.roles import Floats


def node_vectors(mesh: PlateMesh, edge: Edge) -> dict[tuple[int, str], VectorRows]:
    """The coordinate vectors of an edge's nodes, by node number and name."""
    return {
        (int(node), name): VectorRows.single(mesh.vector(int(node), name))
        for node in mesh.edge_nodes(edge.side)
        for name in mesh.element.vector_names
    }


def edge_length(mesh: PlateMesh, edge: Edge) -> float:
    """Reference length of an edge [m]."""
    return mesh.size[1] if edge.side[0] == "x" else mesh.size[0]


def edge_place(mesh: PlateMesh, edge: Edge, s: float) -> tuple[float, float]:
    """Parameters (x, y) [m] of the point at the length s [m] along an edge."""
    fixed = 0.0 if edge.side[1] == "-" else mesh.size[0 if edge.side[0] == "x" else 1]
    return (fixed, s) if edge.side[0] == "x" else (s, fixed)


def along_and_outward(edge: Edge, rows: PointRows) -> tuple[VectorRows, VectorRows]:
    """Tangent along an edge, and the tangent across it that points out of the plate."""
    r_x, r_y = rows.tangents
    along, across = (r_y, r_x) if edge.side[0] == "x" else (r_x, r_y)
    return along, across if edge.side[1] == "+" else -across


@dataclass(frozen=True)
class EdgePair:
    """Two edges that lie upon each other in the reference configuration.

    Args:
        a, b: the edges.
        mesh_a, mesh_b: the plates they belong to.
        reversed: whether their parameters run in opposite directions.
    """

    a: Edge
    b: Edge
    mesh_a: PlateMesh
    mesh_b: PlateMesh
    reversed: bool

    @property
    def length(self) -> float:
        """Their length [m]."""
        return edge_length(self.mesh_a, self.a)

    def on_a(self, s: float) -> PointRows:
        """The point of a at the length s along a's edge."""
        return self.mesh_a.locate(edge_place(self.mesh_a, self.a, s))

    def on_b(self, s: float) -> PointRows:
        """The point of b that lies upon the point of a at the length s."""
        return self.mesh_b.locate(edge_place(self.mesh_b, self.b, self.length - s if self.reversed else s))

    @property
    def nodes(self) -> Floats:
        """Lengths along a at which the finer edge has nodes; the coarser edge is a cubic curve between them."""
        n_a, n_b = (mesh.ny if edge.side[0] == "x" else mesh.nx for mesh, edge in ((self.mesh_a, self.a), (self.mesh_b, self.b)))
        return np.linspace(0.0, self.length, max(n_a, n_b) + 1)

    @property
    def nested(self) -> bool:
        """Whether every node of the coarser edge meets one of the finer."""
        n_a, n_b = (mesh.ny if edge.side[0] == "x" else mesh.nx for mesh, edge in ((self.mesh_a, self.a), (self.mesh_b, self.b)))
        return max(n_a, n_b) % min(n_a, n_b) == 0


def edge_pair(item: str, build: Build, a: Edge, b: Edge) -> EdgePair:
    """Lay two edges upon each other.

    Raises:
        DeclarationError: they belong to one plate, differ in length, or do not coincide in the reference configuration.
    """
    if a.body.name == b.body.name:
        raise DeclarationError(item, f"{a} and {b} are edges of one plate", "accepted are edges of two plates")
    mesh_a, mesh_b = a.body.compiled(build), b.body.compiled(build)
    lengths = edge_length(mesh_a, a), edge_length(mesh_b, b)
    if abs(lengths[0] - lengths[1]) > 1e-6 * max(lengths):
        raise DeclarationError(item, f"{a} is {lengths[0]:g} m and {b} {lengths[1]:g} m long", "accepted are edges of one length")
    initial = build.initial
    gaps = []
    for backwards in (False, True):
        pair = EdgePair(a, b, mesh_a, mesh_b, backwards)
        gaps.append(max(float(np.linalg.norm(pair.on_a(s).at(initial) - pair.on_b(s).at(initial))) for s in (0.0, lengths[0])))
    if min(gaps) > 1e-6 * max(lengths):
        raise DeclarationError(
            item, f"{a} and {b} lie {min(gaps):.3g} m apart", "accepted are edges that coincide in the reference configuration"
        )
    return EdgePair(a, b, mesh_a, mesh_b, bool(gaps[1] < gaps[0]))
