"""Linear rows that hold points and edges: the vocabulary of supports whose constraints are constant and are eliminated."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from lamella.body.base import Marker
from lamella.body.plate import Edge
from lamella.dofs import Build, DotRow, LinearRow, Motion
from lamella.kinematics import Frame, VectorRows
from lamella.roles import Floats

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


def hold_edge(
    build: Build,
    edge: Edge,
    name: str,
    directions: Mapping[str, Floats],
    values: Mapping[str, float] | None = None,
    motions: Mapping[str, Motion] | None = None,
) -> list[DotRow]:
    """Hold components of the vector ``name`` of every node of an edge.

    Args:
        build: the build.
        edge: the edge.
        name: the nodal vector.
        directions: unit vectors along which it is held, by what messages call them.
        values: what the components are held at; those of the reference configuration when left out.
        motions: what is added to them, by direction.
    """
    mesh = edge.body.compiled(build)
    rows = []
    for node in mesh.edge_nodes(edge.side):
        vector = VectorRows.single(mesh.vector(int(node), name))
        for axis, direction in directions.items():
            value = float(direction @ vector.at(build.initial)) if values is None else values[axis]
            terms = ((1.0, vector, VectorRows.fixed(direction)),)
            rows.append(DotRow(f"{axis} of {name} at node {node} of edge {edge}", terms, value, (motions or {}).get(axis)))
    return rows


def is_fixed(frame: Frame) -> bool:
    """Whether a frame is fixed in space."""
    return not any(len(vector.vectors) for vector in (frame.origin, *frame.axes))


def carried(initial: Floats, value: Floats, frame: Frame) -> VectorRows:
    """A vector with constant components in a frame that has the given value in the reference configuration."""
    if not any(len(axis.vectors) for axis in frame.axes):  # fixed in space
        return VectorRows.fixed(value)
    components = frame.rotation(initial).T @ value
    carried = VectorRows.fixed(np.zeros(3))
    for c, axis in zip(components.tolist(), frame.axes, strict=True):
        if abs(c) > 1e-15 * np.abs(components).max():  # a vector along an axis shall be that axis
            carried += c * axis
    return carried


def centre(build: Build, on: Edge | Marker) -> VectorRows:
    """The point to which a support's torque refers: the marker, or the mean of the edge's nodes."""
    if isinstance(on, Marker):
        return on.rows(build).point
    mesh = on.body.compiled(build)
    vectors = np.array([mesh.vector(int(node), "r") for node in mesh.edge_nodes(on.side)])
    return VectorRows(vectors, np.full(len(vectors), 1.0 / len(vectors)), np.zeros(3))
