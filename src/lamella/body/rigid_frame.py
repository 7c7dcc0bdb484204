"""The compiled form of a rigid body: where its vectors are, and its constant mass matrix."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from lamella.dofs import DotRow
from lamella.kinematics import Frame, PointRows, VectorRows, vectors_of
from lamella.roles import Floats, InertiaBlock, Ints

if TYPE_CHECKING:
    from lamella.body.shape import Solid

Axes = tuple[VectorRows, VectorRows, VectorRows]


class RigidFrame:
    """The vectors p, d_1, d_2, d_3 of a rigid body, numbered one after the other.

    Args:
        name: the body's name.
        first: number of the position's vector.
        reference: rotation matrix R_WB of the reference configuration, shape (3, 3).
        shape: the solid that is drawn, None for nothing.
        centre: centre of mass in the body's axes [m], shape (3,).
    """

    def __init__(self, name: str, first: int, reference: Floats, shape: Solid | None, centre: Floats) -> None:
        self.name, self.first, self.reference, self.shape, self.centre = name, first, reference, shape, centre
        self.axes: Axes = (VectorRows.single(first + 1), VectorRows.single(first + 2), VectorRows.single(first + 3))

    def locate(self, at: tuple[float, ...]) -> PointRows:
        """Weights of the vectors at a point (x, y, z) [m]; its tangents are the body's axes d_1 and d_2."""
        vectors = self.first + np.arange(4)
        return PointRows(vectors, np.array([1.0, *at]), np.eye(4)[1], np.eye(4)[2], np.zeros(3))

    def frame(self, at: tuple[float, ...], axes: Floats) -> Frame:
        """A frame fixed in the body whose axes in the reference configuration are the columns of ``axes`` (3, 3)."""
        return Frame(self.locate(at).point, turned(self.axes, self.reference.T @ axes))

    def rotation(self, q: Floats) -> Floats:
        """Rotation matrix R_WB in the configuration ``q`` (n_q,), shape (3, 3)."""
        return vectors_of(q)[self.first + 1 : self.first + 4].T

    def surface(self, q: Floats) -> tuple[Floats, Ints] | None:
        """Vertices [m] (n, 3) and quadrilaterals (m, 4) of the shape in the configuration ``q`` (n_q,), None without a shape."""
        if self.shape is None:
            return None
        vertices, faces = self.shape.surface()
        return vectors_of(q)[self.first] + (vertices + self.centre) @ self.rotation(q).T, faces


def turned(axes: Axes, columns: Floats) -> Axes:
    """The axes whose components along the given ones are the columns of a matrix (3, 3)."""

    def axis(k: int) -> VectorRows:
        c = np.where(np.abs(columns[:, k]) > 1e-15, columns[:, k], 0.0)  # an axis along a given one shall be that one
        return c[0] * axes[0] + c[1] * axes[1] + c[2] * axes[2]

    return axis(0), axis(1), axis(2)


def unit_length_rows(label: str, axes: Axes) -> list[DotRow]:
    """The equations d_i . d_j = delta_ij, six for three axes; those of squares are halved, so that Phi is a strain."""
    rows = []
    for i, u in enumerate(axes):
        rows.append(DotRow(f"unit length of axis {i + 1} of {label}", ((0.5, u, u),), 0.5))
        rows += [DotRow(f"right angle of axes {i + 1} and {j + 1} of {label}", ((1.0, u, w),)) for j, w in enumerate(axes[:i])]
    return rows


class RigidInertia(InertiaBlock):
    """Mass matrix of a rigid body in its vectors (p, d_1, d_2, d_3), each entry times the 3 x 3 identity:

        [ m    m c^T ]
        [ m c  J     ],      J = J_c + m c c^T

    with J_c = int x x^T dm about the centre of mass c.

    Args:
        name: the body's name.
        first: number of the position's vector.
        mass: m [kg].
        centre: c in the body's axes [m], shape (3,).
        second_moments: J_c [kg m^2], shape (3, 3).
    """

    def __init__(self, name: str, first: int, mass: float, centre: Floats, second_moments: Floats) -> None:
        self.name, self._first = name, first
        self._matrix = np.zeros((4, 4))
        self._matrix[0, 0] = mass
        self._matrix[0, 1:] = self._matrix[1:, 0] = mass * centre
        self._matrix[1:, 1:] = second_moments + mass * np.outer(centre, centre)

    def mass(self) -> tuple[Ints, Ints, Floats]:
        """Vectors and masses of all entries."""
        i, j = np.nonzero(self._matrix)
        return self._first + i, self._first + j, self._matrix[i, j]
