"""How firmly an edge is clamped: what of its nodes is held, and what is left free to strain in the plane."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from lamella.body.mesh import PlateMesh
from lamella.body.plate import Edge
from lamella.body.plate_frame import vanishing
from lamella.body.rigid_frame import Axes, turned
from lamella.dofs import Build, DotRow, Motion
from lamella.joint.edge_rows import node_vectors
from lamella.joint.equations import Rows
from lamella.kinematics import Frame, VectorRows
from lamella.math.gauss import gauss_rule
from lamella.roles import Floats

Clamping = Literal["full", "restrained", "sliding"]
"""How firmly an edge is clamped. With the clamp's directions e_s along the edge, e_t across it and e_n normal to the plate, and
the plate's slopes r_s and r_t along and across the edge:

- ``full``: r, r_s, r_t and r_xy of every node. This holds the strain at the edge at zero, more than a clamp does.
- ``restrained``: r and r_s, and r_t and r_xy along e_n. The edge keeps its place and its normal, and what crosses it may strain
  in the plane, as in the boundary value problem of a clamped plate.
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


@dataclass(frozen=True)
class DirectedMotion:
    """The component sum_k e_k m_k(t) of a motion along a direction e.

    Args:
        parts: pairs (e_k, m_k).
    """

    parts: tuple[tuple[float, Motion], ...]

    def value(self, t: float) -> float:
        """Displacement [m]."""
        return sum(e * motion.value(t) for e, motion in self.parts)

    def rate(self, t: float) -> float:
        """Velocity [m/s]."""
        return sum(e * motion.rate(t) for e, motion in self.parts)

    def acceleration(self, t: float) -> float:
        """Acceleration [m/s^2]."""
        return sum(e * motion.acceleration(t) for e, motion in self.parts)

    @property
    def breakpoints(self) -> tuple[float, ...]:
        """Times [s] at which the value or a derivative jumps."""
        return tuple(sorted({t for _, motion in self.parts for t in motion.breakpoints}))


def clamped_rows(
    build: Build, edge: Edge, frame: Frame, kind: Clamping, where: str, motions: Mapping[str, Motion] | None = None
) -> Rows:
    """The rows that clamp an edge in a frame, where it stands in the reference configuration.

    Rows of ``full`` are linear, and all are in a frame that is fixed in space; the others are dot products of vectors of the edge
    and axes of the frame. A rigid plate has no strain to leave free, so every kind holds it as ``full`` does.

    Args:
        build: the build.
        edge: the edge.
        frame: what it is clamped to.
        kind: how firmly.
        where: the frame in words, for messages.
        motions: displacements [m] along x, y, z, for a frame whose axes are the inertial ones.
    """
    mesh, motions = edge.body.compiled(build), motions or {}
    held = _HELD["full" if mesh.strain == "rigid" else kind]
    directions = _directions(build, mesh, edge, frame)
    motion_along = {letter: _motion_along(axis.at(build.initial), motions) for letter, axis in directions.items()}
    roles = dict(zip(mesh.edge_slope(edge.side), ("along", "across"), strict=True))
    rows: Rows = []

    def hold_along(letter: str, vector: VectorRows, label: str, *, moves: bool) -> None:
        axis = directions[letter]
        value = float(vector.at(build.initial) @ axis.at(build.initial))
        motion = motion_along[letter] if moves else None
        rows.append(DotRow(f"{_WORDS[letter]} of {label}", ((1.0, vector, axis),), value, motion))

    for (node, name), vector in node_vectors(mesh, edge).items():
        position, label = name == "r", f"{name} at node {node} of edge {edge} {where}"
        moved = vector - frame.origin if position else vector
        letters = held[roles.get(name, name)]
        if letters == "all":
            fixed = vanishing(moved - _standing(build, moved, frame), label)
            rows += [replace(row, motion=motions.get(axis) if position else None) for row, axis in zip(fixed, "xyz", strict=True)]
        else:
            for letter in letters:
                hold_along(letter, moved, label, moves=position)
    if held["r"] != "all":
        hold_along("s", _mean(mesh, edge) - frame.origin, f"the mean position of edge {edge} {where}", moves=True)
    return rows


def _standing(build: Build, vector: VectorRows, frame: Frame) -> VectorRows:
    """A vector with constant components in a frame: those that the given one has in the reference configuration."""
    components = frame.rotation(build.initial).T @ vector.at(build.initial)
    fixed = VectorRows.fixed(np.zeros(3))
    for c, axis in zip(components.tolist(), frame.axes, strict=True):
        if c:
            fixed += c * axis
    return fixed


def _directions(build: Build, mesh: PlateMesh, edge: Edge, frame: Frame) -> dict[str, VectorRows]:
    """e_s, e_t and e_n in the frame, by the letters s, t and n. Edges of plates are straight in the reference configuration."""
    node = int(mesh.edge_nodes(edge.side)[0])
    slopes = {name: build.initial[mesh.vector(node, name)] for name in ("r_x", "r_y")}
    along = slopes[mesh.edge_slope(edge.side)[0]]
    normal = np.cross(slopes["r_x"], slopes["r_y"])
    across = np.cross(along, normal)
    columns = np.stack([vector / np.linalg.norm(vector) for vector in (along, across, normal)], axis=1)
    axes: Axes = turned(frame.axes, frame.rotation(build.initial).T @ columns)
    return dict(zip("stn", axes, strict=True))


def _mean(mesh: PlateMesh, edge: Edge) -> VectorRows:
    """The mean position of an edge, exact for the cubic curve it is in each element."""
    places, weights = gauss_rule(2)
    points, _ = mesh.edge_points(edge.side, places)
    n_element = len(points) // len(places)
    mean = VectorRows.fixed(np.zeros(3))
    for point, weight in zip(points, np.tile(weights, n_element), strict=True):
        mean += weight / n_element * mesh.locate(point).point
    return mean


def _motion_along(direction: Floats, motions: Mapping[str, Motion]) -> DirectedMotion | None:
    parts = tuple((float(e), motions[axis]) for e, axis in zip(direction, "xyz", strict=True) if axis in motions and e)
    return DirectedMotion(parts) if parts else None
