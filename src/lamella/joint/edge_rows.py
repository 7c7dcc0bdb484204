"""Nodes of plate edges as vectors, and edges laid upon each other."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lamella.body.mesh import PlateMesh
from lamella.body.plate import Edge
from lamella.body.quadrature import edge_quadrature, edge_weights
from lamella.dofs import Build
from lamella.errors import DeclarationError
from lamella.kinematics import PointRows, VectorRows
from lamella.roles import Floats

ROUNDING = 1e-6
"""Distances as a share of the bodies' size, and angles [rad], that are taken as rounding of the input."""


def node_vectors(mesh: PlateMesh, edge: Edge) -> dict[tuple[int, str], VectorRows]:
    """The coordinate vectors of an edge's nodes, by node number and name."""
    return {
        (int(node), name): VectorRows.single(mesh.vector(int(node), name))
        for node in mesh.edge_nodes(edge.side)
        for name in mesh.element.vector_names
    }


def edge_length(mesh: PlateMesh, edge: Edge) -> float:
    """Length of the parameter along an edge [m], which is that of the edge itself where the slope along it is a unit vector."""
    return mesh.size[1] if edge.side[0] == "x" else mesh.size[0]


def edge_mean(mesh: PlateMesh, edge: Edge, initial: Floats) -> VectorRows:
    """The mean position of an edge over its reference length, int r ds / int ds."""
    points, weights = edge_quadrature(mesh, edge.side, initial)
    shares = weights.reshape(-1) / weights.sum()
    return sum((share * rows.point for share, rows in zip(shares, points, strict=True)), VectorRows.fixed(np.zeros(3)))


def edge_place(mesh: PlateMesh, edge: Edge, s: float) -> tuple[float, float]:
    """Parameters (x, y) [m] of the point at the parameter s [m] along an edge."""
    fixed = 0.0 if edge.side[1] == "-" else mesh.size[0 if edge.side[0] == "x" else 1]
    return (fixed, s) if edge.side[0] == "x" else (s, fixed)


def along_and_outward(edge: Edge, rows: PointRows) -> tuple[VectorRows, VectorRows]:
    """Tangent along an edge, and the tangent across it that points out of the plate."""
    r_x, r_y = rows.tangents
    along, across = (r_y, r_x) if edge.side[0] == "x" else (r_x, r_y)
    return along, across if edge.side[1] == "+" else -across


@dataclass(frozen=True)
class EdgePair:
    """Two edges that lie upon each other in the reference configuration, where their parameters are proportional.

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
        """Length of the parameter along a [m]."""
        return edge_length(self.mesh_a, self.a)

    @property
    def rate(self) -> float:
        """Derivative of the parameter along b by that along a."""
        return (-1.0 if self.reversed else 1.0) * edge_length(self.mesh_b, self.b) / self.length

    def on_a(self, s: float) -> PointRows:
        """The point of a at the parameter s along a's edge."""
        return self.mesh_a.locate(edge_place(self.mesh_a, self.a, s))

    def on_b(self, s: float) -> PointRows:
        """The point of b that lies upon the point of a at the parameter s."""
        return self.mesh_b.locate(edge_place(self.mesh_b, self.b, abs(self.rate) * (self.length - s if self.reversed else s)))

    def gap(self, s: float) -> VectorRows:
        """Position of b less that of a at the parameter s."""
        return self.on_b(s).point - self.on_a(s).point

    def tangent_gap(self, s: float) -> VectorRows:
        """Derivative of ``gap`` by s."""
        tangent_a, tangent_b = (along_and_outward(e, r)[0] for e, r in ((self.a, self.on_a(s)), (self.b, self.on_b(s))))
        return self.rate * tangent_b - tangent_a

    @property
    def nodes(self) -> Floats:
        """Parameters along a at which the finer edge has nodes; the coarser edge is a cubic curve between them."""
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
    mesh_a, mesh_b, initial = a.body.compiled(build), b.body.compiled(build), build.initial
    lengths = [float(edge_weights(mesh, edge.side, initial).sum()) for mesh, edge in ((mesh_a, a), (mesh_b, b))]
    # cubic edges of different meshes differ by the fourth power of the elements' angle where they are curved
    if abs(lengths[0] - lengths[1]) > ROUNDING * max(lengths):
        raise DeclarationError(
            item, f"{a} is {lengths[0]:.8g} m and {b} {lengths[1]:.8g} m long", "accepted are edges of one length"
        )
    found: dict[float, EdgePair] = {}
    for backwards in (True, False):
        pair = EdgePair(a, b, mesh_a, mesh_b, backwards)
        found[max(float(np.linalg.norm(pair.gap(s).at(initial))) for s in pair.nodes.tolist())] = pair
    gap = min(found)
    if gap > ROUNDING * max(lengths):
        raise DeclarationError(
            item, f"{a} and {b} lie {gap:.3g} m apart", "accepted are edges that coincide in the reference configuration"
        )
    pair = found[gap]
    stretch = lengths[0] / pair.length
    kink = max(float(np.linalg.norm(pair.tangent_gap(s).at(initial))) for s in pair.nodes.tolist()) / stretch
    if kink > ROUNDING:
        raise DeclarationError(
            item,
            f"the tangents of {a} and {b} differ by {kink:.3g} of their length",
            "accepted are edges whose parameters are proportional",
        )
    return pair
