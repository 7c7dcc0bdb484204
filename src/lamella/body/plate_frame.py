"""A frame at a point of a plate, and the equations that make a plate rigid."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from lamella.body.mesh import PlateMesh
from lamella.body.rigid_frame import Axes, turned, unit_length_rows
from lamella.dofs import DotRow, LinearRow, Motion
from lamella.kinematics import Frame, VectorRows
from lamella.math.rotation import polar
from lamella.roles import Floats, Ints

if TYPE_CHECKING:
    from lamella.dofs import Build


def plate_frame(build: Build, mesh: PlateMesh, at: tuple[float, ...], axes: Floats) -> Frame:
    """A frame at the point (x, y) of a plate with the given axes (3, 3) in the reference configuration.

    The frame is three further vectors d_1, d_2, d_3 without mass, tied to the tangents of the point by

        d_i . d_j = delta_ij,    d_3 . r_x = d_3 . r_y = 0,    d_1 . r_y = d_2 . r_x

    so that d_3 is the exact normal and d_1, d_2 are the rotation of the tangents' polar decomposition. Everything that joins
    frames of rigid bodies thereby joins points of plates as well. One frame is made for each point, whoever asks for it.
    """
    x, y = at[0], at[1]
    key = f"frame on {mesh.name} at ({x:g}, {y:g}) m"
    rows = mesh.locate((x, y))
    if key not in build.frames:
        r_x, r_y = rows.tangents
        initial, speed = build.initial, np.concatenate(build.v)
        rotation, _ = polar(np.stack([r_x.at(initial), r_y.at(initial)], axis=1))
        rates = _turning(rotation, r_x.rate(speed), r_y.rate(speed))
        first = build.vectors(mesh.name, rotation.T, rates, np.zeros(3, dtype=bool), np.ones(3))
        d: Axes = (VectorRows.single(first), VectorRows.single(first + 1), VectorRows.single(first + 2))
        across = [
            DotRow(f"right angle of axis 3 and {name} of the {key}", ((1.0, d[2], tangent),))
            for name, tangent in (("r_x", r_x), ("r_y", r_y))
        ]
        even = DotRow(f"axes 1 and 2 along r_x and r_y of the {key}", ((1.0, d[0], r_y), (-1.0, d[1], r_x)))
        build.tie([*unit_length_rows(f"the {key}", d), *across, even])
        build.frames[key] = Frame(rows.point, d)
    made = build.frames[key]
    return Frame(made.origin, turned(made.axes, made.rotation(build.initial).T @ axes))


def _turning(rotation: Floats, r_x_rate: Floats, r_y_rate: Floats) -> Floats:
    """Rates of the axes for tangents that turn rigidly with the given rates, shape (3, 3)."""
    d_1, d_2, d_3 = rotation.T
    spin = np.array([d_3 @ r_y_rate, -(d_3 @ r_x_rate), 0.5 * (d_2 @ r_x_rate - d_1 @ r_y_rate)])
    return np.cross(rotation @ spin, rotation.T)


def rigid_rows(mesh: PlateMesh, first_node: int = 0) -> list[LinearRow | DotRow]:
    """The equations of a plate that keeps its shape: every node moves with one node's position p and tangents d_1, d_2.

    r = p + x d_1 + y d_2,  r_x = d_1,  r_y = d_2,  r_xy = 0,      d_1 . d_1 = d_2 . d_2 = 1,  d_1 . d_2 = 0
    """
    p, d_1, d_2 = (VectorRows.single(mesh.vector(first_node, name)) for name in ("r", "r_x", "r_y"))
    rows: list[LinearRow | DotRow] = []
    for node in range(mesh.n_nodes):
        j, i = divmod(node, mesh.nodes_x)
        wanted = {"r": p + i * mesh.lx * d_1 + j * mesh.ly * d_2, "r_x": d_1, "r_y": d_2}
        for name in mesh.element.vector_names:
            vector = mesh.vector(node, name)
            if node == first_node and name in wanted:
                continue
            difference = VectorRows.single(vector) - wanted[name] if name in wanted else VectorRows.single(vector)
            rows += vanishing(difference, mesh.describe(vector))
    label = f"plate '{mesh.name}'"
    rows += [DotRow(f"unit length of {name} of {label}", ((0.5, d, d),), 0.5) for name, d in (("r_x", d_1), ("r_y", d_2))]
    return [*rows, DotRow(f"right angle of r_x and r_y of {label}", ((1.0, d_1, d_2),))]


def standing(vectors: Ints, values: Floats, labels: Sequence[str], motions: Sequence[Mapping[str, Motion]]) -> list[LinearRow]:
    """All components of some coordinate vectors (n,) held at their values (n, 3), or moved as functions of time."""
    coords, one = (3 * vectors[:, None] + np.arange(3)).reshape(-1, 1), np.ones(1)
    axes = [(f"{axis} of {label}", moves.get(axis)) for label, moves in zip(labels, motions, strict=True) for axis in "xyz"]
    return [
        LinearRow(label, coord, one, value, motion)
        for (label, motion), coord, value in zip(axes, coords, values.reshape(-1).tolist(), strict=True)
    ]


def vanishing(vector: VectorRows, label: str, axes: str = "xyz", motions: Mapping[str, Motion] | None = None) -> list[LinearRow]:
    """Components of a vector that are zero, or move as functions of time."""
    return [
        LinearRow(f"{axis} of {label}", 3 * vector.vectors + c, vector.weights, -float(vector.constant[c]), motion)
        for axis, c, motion in ((axis, "xyz".index(axis), (motions or {}).get(axis)) for axis in axes)
    ]
