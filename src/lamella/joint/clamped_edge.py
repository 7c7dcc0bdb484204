"""How firmly an edge is clamped: what of its nodes is held, and what is left free to strain in the plane."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal

import numpy as np

from lamella.body.plate import Edge
from lamella.body.plate_frame import standing, vanishing
from lamella.dofs import Build, DotRow, Motion
from lamella.errors import DeclarationError
from lamella.joint.edge_axes import EdgeAxes, edge_axes
from lamella.joint.edge_rows import ROUNDING, edge_mean, node_vectors
from lamella.joint.equations import Rows
from lamella.joint.motion_sum import MotionSum
from lamella.joint.rows import carried, is_fixed
from lamella.kinematics import Frame, VectorRows
from lamella.roles import Floats

Clamping = Literal["full", "restrained", "sliding"]
"""How firmly an edge is clamped. With the directions e_s along the edge, e_t across it and e_n normal to the plate at each node,
and the plate's slopes r_s and r_t along and across the edge:

- ``full``: r, r_s, r_t and r_xy of every node. This holds the strain at the edge at zero, more than a clamp does.
- ``restrained``: r and r_s, and e_n.r_t and its derivative along the edge, e_n.r_xy + e_n'.r_t. The edge keeps its place and its
  normal, and what crosses it may strain in the plane, as in the boundary value problem of a clamped plate.
- ``sliding``: r and r_s along e_t and e_n, r_t and r_xy along e_n, and the mean of r over the edge along e_s. The edge stays
  straight and keeps its normal, and grows or shrinks along itself. A load along the edge is carried by an even shear.

An element without r_xy has no such row.
"""

_HELD: dict[Clamping, dict[str, str]] = {
    "full": {"r": "all", "along": "all", "across": "all", "r_xy": "all"},
    "restrained": {"r": "all", "along": "all", "across": "n", "r_xy": "n"},
    "sliding": {"r": "tn", "along": "tn", "across": "n", "r_xy": "n"},
}
"""What is held of a node's position, slopes and twist: all of it, or components along e_t (t) and e_n (n)."""
_WORDS = {"s": "component along the edge", "t": "component across the edge", "n": "normal component"}


def clamped_rows(
    item: str,
    build: Build,
    edge: Edge,
    frame: Frame,
    kind: Clamping,
    where: str,
    motions: Mapping[str, Motion] | None = None,
) -> Rows:
    """The rows that clamp an edge in a frame, where it stands in the reference configuration.

    Rows of ``full`` are linear, and all are in a frame that is fixed in space; the others are dot products of vectors of the edge
    and axes of the frame. A rigid plate has no strain to leave free, so every kind holds it as ``full`` does.

    Args:
        item: what clamps it, for messages.
        build: the build.
        edge: the edge.
        frame: what it is clamped to.
        kind: how firmly.
        where: the frame in words, for messages.
        motions: displacements [m] along x, y, z, for a frame whose axes are the inertial ones.

    Raises:
        DeclarationError: an edge that is not straight is to slide along itself.
    """
    mesh, motions, initial = edge.body.compiled(build), motions or {}, build.initial
    names, nodes = mesh.element.vector_names, mesh.edge_nodes(edge.side)

    def labelled(node: int, name: str) -> str:
        return f"{name} at node {node} of edge {edge} {where}"

    held = _HELD["full" if mesh.strain == "rigid" else kind]
    if set(held.values()) == {"all"} and is_fixed(frame):
        numbers = (mesh.vector(0, names[0]) + len(names) * nodes[:, None] + np.arange(len(names))).reshape(-1)
        labels = [labelled(node, name) for node in nodes.tolist() for name in names]
        return [*standing(numbers, initial[numbers], labels, [motions if name == "r" else {} for name in names] * len(nodes))]
    roles = dict(zip(mesh.edge_slope(edge.side), ("along", "across"), strict=True))
    axes = {} if set(held.values()) == {"all"} else edge_axes(mesh, edge, initial)
    if held["r"] != "all":
        _check_straight(item, edge, axes)
        axes = dict.fromkeys(axes, next(iter(axes.values())))  # rounding apart they are the same
    rows: Rows = []

    def hold_along(direction: Floats, vector: VectorRows, label: str, *, moves: bool) -> None:
        axis = carried(initial, direction, frame)
        value = float(vector.at(initial) @ axis.at(initial))
        rows.append(DotRow(label, ((1.0, vector, axis),), value, _motion_along(direction, motions) if moves else None))

    vectors = node_vectors(mesh, edge)
    for (node, name), vector in vectors.items():
        position, label = name == "r", labelled(node, name)
        moved = vector - frame.origin if position else vector
        letters = held[roles.get(name, name)]
        if letters == "all":
            rows += vanishing(moved - carried(initial, moved.at(initial), frame), label, motions=motions if position else None)
            continue
        at = axes[node]
        if name == "r_xy" and np.any(at.n_s):
            n, n_s = carried(initial, at.n, frame), carried(initial, at.n_s, frame)
            across = vectors[node, mesh.edge_slope(edge.side)[1]]
            rows.append(DotRow(f"{_WORDS['n']} of {label}", ((1.0, vector, n), (1.0, across, n_s))))
        else:
            for letter in letters:
                hold_along(getattr(at, letter), moved, f"{_WORDS[letter]} of {label}", moves=position)
    if held["r"] != "all":
        mean, (first, *_) = edge_mean(mesh, edge, initial), axes.values()
        label = f"{_WORDS['s']} of the mean position of edge {edge} {where}"
        hold_along(first.s, mean - frame.origin, label, moves=True)
    return rows


def _check_straight(item: str, edge: Edge, axes: Mapping[int, EdgeAxes]) -> None:
    """An edge slides along itself only where that is one direction, and its normal does not turn on the way."""
    first, *others = axes.values()
    turn = max(float(np.linalg.norm(v - w)) for at in others for v, w in ((at.s, first.s), (at.n, first.n)))
    if turn > ROUNDING:
        raise DeclarationError(
            item,
            f"kind 'sliding' of edge {edge}, along which tangent or normal turn by {np.degrees(turn):.3g} deg",
            "accepted are straight edges with one normal, or the kinds 'full' and 'restrained'",
        )


def _motion_along(direction: Floats, motions: Mapping[str, Motion]) -> MotionSum | None:
    parts = tuple((float(e), motions[axis]) for e, axis in zip(direction, "xyz", strict=True) if axis in motions and e)
    return MotionSum(parts) if parts else None
