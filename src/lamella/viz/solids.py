"""The surfaces of rigid bodies, frame by frame, for pictures and for files."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from lamella.body.rigid_frame import RigidFrame
from lamella.roles import Floats, Ints

if TYPE_CHECKING:
    from lamella.model import Model
    from lamella.result import Result

SHARP = np.cos(np.radians(30.0))
"""An edge is drawn where the normals of its faces differ by more than 30 degrees: at a box, at the rims of a cylinder."""


@dataclass(frozen=True)
class SolidShot:
    """One rigid body at one frame, or at several (...).

    Args:
        name: the body's name.
        points: vertices [m], shape (..., n, 3).
        reference: the same in the reference configuration [m], shape (n, 3).
        velocity: velocities of the vertices [m/s]; NaN where the frames keep none.
        faces: quadrilaterals of vertex numbers, outward by the right-hand rule; a triangle repeats its last vertex, shape (m, 4).
        edges: sharp edges as pairs of vertex numbers, shape (k, 2).
    """

    name: str
    points: Floats
    reference: Floats
    velocity: Floats
    faces: Ints
    edges: Ints

    @property
    def displacement(self) -> Floats:
        """Displacement from the reference configuration [m], shape (..., n, 3)."""
        return self.points - self.reference


class SolidSampler:
    """All rigid bodies of a result that have a shape.

    Args:
        result: of a solution, or read from a file.
    """

    def __init__(self, result: Result) -> None:
        from lamella.io.results import frame_velocities

        self._result, self._velocities = result, frame_velocities(result)
        self._bodies = [(body, *surface(body, result.model.q0)) for body in shaped(result.model)]
        self._edges = [sharp_edges(points, faces) for _, points, faces in self._bodies]

    def at(self, frame: int | slice) -> list[SolidShot]:
        """The bodies at one frame or several; positions are linear in q, so a velocity is the difference of two positions."""
        q, v = self._result.frame_q[frame], self._velocities[frame]
        shots = []
        for (body, reference, faces), edges in zip(self._bodies, self._edges, strict=True):
            points, moved = (np.apply_along_axis(lambda one, body=body: surface(body, one)[0], -1, at) for at in (q, q + v))
            shots.append(SolidShot(body.name, points, reference, moved - points, faces, edges))
        return shots


def shaped(model: Model) -> list[RigidFrame]:
    """The rigid bodies of a model that have a shape."""
    return [body for body in model.rigid_bodies if body.shape is not None]


def drawable(model: Model) -> bool:
    """Whether there is something to draw: a plate, or a rigid body with a shape."""
    return bool(model.plates or shaped(model))


def surface(body: RigidFrame, q: Floats) -> tuple[Floats, Ints]:
    """Vertices (n, 3) [m] and faces (m, 4) of a body with a shape in the configuration ``q`` (n_q,)."""
    found = body.surface(q)
    assert found is not None
    return found


def sharp_edges(points: Floats, faces: Ints) -> Ints:
    """Pairs of vertices between faces that meet at an angle, and at the boundary of the surface; shape (k, 2)."""
    normals = face_normals(points[faces])
    ends = np.sort(np.stack([faces, np.roll(faces, -1, axis=1)], axis=-1).reshape(-1, 2), axis=1)
    owner = np.repeat(np.arange(len(faces)), faces.shape[1])
    length = np.linalg.norm(points[ends[:, 0]] - points[ends[:, 1]], axis=1)
    real = length > 1e-9 * np.ptp(points, axis=0).max()  # a side of a triangle, or of a face at a pole, may have no length
    edges, inverse, counts = np.unique(ends[real], axis=0, return_inverse=True, return_counts=True)
    sorted_owner = owner[real][np.argsort(inverse.reshape(-1), kind="stable")]
    last = np.cumsum(counts) - 1
    along = np.sum(normals[sorted_owner[last - counts + 1]] * normals[sorted_owner[last]], axis=1)
    return edges[(counts == 1) | (along < SHARP)]


def face_normals(corners: Floats) -> Floats:
    """Unit normals of faces with corners (m, 4, 3), shape (m, 3)."""
    normal = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    return normal / np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-300)
