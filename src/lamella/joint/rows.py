"""Linear rows that hold points and edges: the vocabulary of supports whose constraints are constant and are eliminated."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from lamella.body.base import Marker
from lamella.body.plate import Edge
from lamella.dofs import Build, LinearRow, Motion
from lamella.kinematics import VectorRows

AXES = "xyz"


def hold_point(
    build: Build, marker: Marker, axes: str, weights: str = "position", motions: Mapping[str, Motion] | None = None
) -> list[LinearRow]:
    """Hold components of a marker's position (or of a tangent there) at their reference values plus motions."""
    rows = marker.rows(build)
    values = getattr(rows, weights)
    used = values != 0.0
    vectors, values = rows.vectors[used], values[used]
    reference = values @ build.initial[vectors]
    return [
        LinearRow(
            f"{axis} of {'the position' if weights == 'position' else weights} at {marker}",
            3 * vectors + AXES.index(axis),
            values,
            float(reference[AXES.index(axis)]),
            (motions or {}).get(axis),
        )
        for axis in axes
    ]


def hold_edge(build: Build, edge: Edge, names: tuple[str, ...], axes: str) -> list[LinearRow]:
    """Hold components of the named nodal vectors at all nodes of an edge at their reference values."""
    mesh = edge.body.compiled(build)
    vectors = [(mesh.vector(int(node), name), f"{name} at node {node}") for node in mesh.edge_nodes(edge.side) for name in names]
    return [
        LinearRow(f"{axis} of {label} of edge {edge}", np.array([3 * vector + c]), np.ones(1), float(build.initial[vector, c]))
        for vector, label in vectors
        for axis, c in ((axis, AXES.index(axis)) for axis in axes)
    ]


def centre(build: Build, on: Edge | Marker) -> VectorRows:
    """The point to which a support's torque refers: the marker, or the mean of the edge's nodes."""
    if isinstance(on, Marker):
        return on.rows(build).point
    mesh = on.body.compiled(build)
    vectors = np.array([mesh.vector(int(node), "r") for node in mesh.edge_nodes(on.side)])
    return VectorRows(vectors, np.full(len(vectors), 1.0 / len(vectors)), np.zeros(3))
