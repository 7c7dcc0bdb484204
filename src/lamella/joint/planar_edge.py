"""Edges that lie in a plane: the symmetry plane of a structure, and the diaphragm that stiffens the end of a shell."""

from __future__ import annotations

import numpy as np

from lamella.body.plate import Edge
from lamella.declaration import declaration
from lamella.dofs import Build
from lamella.errors import DeclarationError
from lamella.joint.base import Axis, axes_with
from lamella.joint.edge_rows import ROUNDING
from lamella.joint.rows import centre, hold_edge
from lamella.roles import Declaration, Floats


@declaration
class Symmetry(Declaration):
    """An edge lies in a plane of symmetry: the plate is one half of a body whose other half is its mirror image.

    With the unit normal N of the plane, the parameter s along the edge and n across it, the body is

        r(s, -n) = M r(s, n),      M = I - 2 N N^T   (about a point of the plane)

    so on the edge N.r keeps its place, N.r_s = 0, and from -r_n = M r_n and the same for r_sn

        r_n = (N.r_n) N,   r_sn = (N.r_sn) N:   their two components in the plane are zero.

    Six of the twelve coordinates of each node are held; of an element without r_xy, four of nine. Loads must be symmetric too;
    a force at a point of the plane, or along the edge, counts only the half that acts on this side. The image of a layup is the
    mirrored layup: fibres at an angle to the edge continue at the opposite angle.

    Args:
        name: unique name; the result holds ``<name>.force`` [N] and ``<name>.torque`` [N m] about the middle of the edge, which
            the other half exerts on this one.
        on: the edge; its parameter lines of constant s must meet the plane at a right angle.
        normal: normal of the plane, ``x``, ``y``, ``z`` or a vector.
    """

    name: str
    on: Edge
    normal: Axis

    def contribute(self, build: Build) -> None:
        """Hold what mirroring leaves no freedom."""
        item = f"Symmetry '{self.name}'"
        axes = axes_with(item, self.normal)
        level = plane_of(item, build, self.on, axes[:, 2])
        _check_crossing(item, build, self.on, axes)
        mesh = self.on.body.compiled(build)
        along, across = mesh.edge_slope(self.on.side)
        normal = {"normal component": axes[:, 2]}
        tangential = {"first component in the plane": axes[:, 0], "second component in the plane": axes[:, 1]}
        rows = [
            *hold_edge(build, self.on, "r", normal, {"normal component": level}),
            *hold_edge(build, self.on, along, normal, dict.fromkeys(normal, 0.0)),
            *hold_edge(build, self.on, across, tangential, dict.fromkeys(tangential, 0.0)),
        ]
        if "r_xy" in mesh.element.vector_names:
            rows += hold_edge(build, self.on, "r_xy", tangential, dict.fromkeys(tangential, 0.0))
        build.hold(self.name, rows, centre(build, self.on), edge=True)


@declaration
class Diaphragm(Declaration):
    """An edge is held in its plane, and free out of it and to turn: by a thin wall that is rigid in its plane and limp across.

    It is the :class:`EdgeSupport` along both directions of the plane: with the normal N, (I - N N^T) r and (I - N N^T) r_s of
    every node keep their reference values. This is the end of the roof of Scordelis and Lo (1964), u_y = u_z = 0 for N = e_x.

    Args:
        name: unique name; the result holds ``<name>.force`` [N] and ``<name>.torque`` [N m] about the middle of the edge.
        on: the edge.
        normal: normal of the diaphragm, ``x``, ``y``, ``z`` or a vector.
    """

    name: str
    on: Edge
    normal: Axis

    def contribute(self, build: Build) -> None:
        """Hold position and tangential slope in the plane."""
        item = f"Diaphragm '{self.name}'"
        axes = axes_with(item, self.normal)
        plane_of(item, build, self.on, axes[:, 2])
        held = {"first component in the plane": axes[:, 0], "second component in the plane": axes[:, 1]}
        along, _ = self.on.body.compiled(build).edge_slope(self.on.side)
        rows = [*hold_edge(build, self.on, "r", held), *hold_edge(build, self.on, along, held)]
        build.hold(self.name, rows, centre(build, self.on), edge=True)


def plane_of(item: str, build: Build, edge: Edge, normal: Floats) -> float:
    """Distance N.r [m] of the plane with the unit normal N in which an edge lies in the reference configuration.

    Raises:
        DeclarationError: the edge does not lie in such a plane.
    """
    mesh, initial = edge.body.compiled(build), build.initial
    nodes = [int(node) for node in mesh.edge_nodes(edge.side)]
    r = initial[[mesh.vector(node, "r") for node in nodes]]
    r_s = initial[[mesh.vector(node, mesh.edge_slope(edge.side)[0]) for node in nodes]]
    level, size = float(np.mean(r @ normal)), float(np.linalg.norm(np.ptp(r, axis=0)))
    off = float(np.abs(r @ normal - level).max())
    tilt = float(np.max(np.abs(r_s @ normal) / np.linalg.norm(r_s, axis=1)))
    if off > ROUNDING * size or tilt > ROUNDING:
        raise DeclarationError(
            item,
            f"edge {edge} leaves the plane with the normal {_shown(normal)} by {off:.3g} m and {np.degrees(tilt):.3g} deg",
            "accepted is an edge that lies in a plane with this normal in the reference configuration",
        )
    return level


def _check_crossing(item: str, build: Build, edge: Edge, axes: Floats) -> None:
    """Refuse a slope across an edge, or a twist, that has components in the plane, the first two axes."""
    mesh, initial = edge.body.compiled(build), build.initial
    nodes = [int(node) for node in mesh.edge_nodes(edge.side)]
    across = initial[[mesh.vector(node, mesh.edge_slope(edge.side)[1]) for node in nodes]]
    stretch = np.linalg.norm(across, axis=1)
    lean, change = float(np.max(np.linalg.norm(across @ axes[:, :2], axis=1) / stretch)), 0.0
    if "r_xy" in mesh.element.vector_names:
        twist = initial[[mesh.vector(node, "r_xy") for node in nodes]]
        length = max(mesh.size)  # of the parameters, by which r_xy differs from a slope
        change = float(np.max(length * np.linalg.norm(twist @ axes[:, :2], axis=1) / stretch))
    if max(lean, change) > ROUNDING:
        angle = (
            f"at {90 - np.degrees(np.arcsin(min(lean, 1.0))):.6g} deg" if lean > ROUNDING else "at angles that change along it"
        )
        raise DeclarationError(
            item,
            f"the lines of {edge.body.name} that cross edge {edge} meet the plane with the normal {_shown(axes[:, 2])} {angle}",
            "accepted are parameter lines that meet a symmetry plane at a right angle",
        )


def _shown(direction: Floats) -> str:
    return "(" + ", ".join(f"{x:.4g}" for x in direction + 0.0) + ")"
