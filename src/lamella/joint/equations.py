"""The vocabulary of joints: what two frames may have in common, as rows of linear or dot-product equations."""

from __future__ import annotations

import numpy as np

from lamella.body.plate_frame import vanishing
from lamella.dofs import DotRow, LinearRow
from lamella.errors import DeclarationError
from lamella.kinematics import Frame, VectorRows
from lamella.roles import Floats

Rows = list[LinearRow | DotRow]

X, Y, Z = 0, 1, 2


def coincident(name: str, a: Frame, b: Frame) -> Rows:
    """The origins coincide: r_b - r_a = 0, three rows."""
    return [*vanishing(b.origin - a.origin, f"the distance of the points of {name}")]


def perpendicular(name: str, a: Frame, i: int, b: Frame, j: int) -> DotRow:
    """Axis i of a is perpendicular to axis j of b."""
    label = f"{name}: right angle of axis {'xyz'[i]} of a and axis {'xyz'[j]} of b"
    return DotRow(label, ((1.0, a.axes[i], b.axes[j]),))


def parallel_axes(name: str, a: Frame, b: Frame) -> Rows:
    """The z axes are parallel, two rows."""
    return [perpendicular(name, a, Z, b, X), perpendicular(name, a, Z, b, Y)]


def same_orientation(name: str, a: Frame, b: Frame) -> Rows:
    """All axes are parallel, three rows."""
    return [*parallel_axes(name, a, b), perpendicular(name, a, X, b, Y)]


def on_axis(name: str, a: Frame, b: Frame, axes: tuple[int, ...] = (X, Y)) -> Rows:
    """The origin of b has no component along the given axes of a: it lies on a's z axis when they are x and y."""
    offset = b.origin - a.origin
    return [DotRow(f"{name}: {'xyz'[i]} of b in the frame of a", ((1.0, offset, a.axes[i]),)) for i in axes]


def axes_along(item: str, direction: tuple[float, float, float], second: tuple[float, float, float] | None = None) -> Floats:
    """Orthonormal axes whose z is along a direction, as columns (3, 3); their x is as near to ``second`` as that allows.

    Without ``second``, x is perpendicular to the inertial axis from which the direction differs most.

    Raises:
        DeclarationError: the direction has no length, or the two directions are parallel.
    """
    z = np.asarray(direction, float)
    length = np.linalg.norm(z)
    if not length > 0:
        raise DeclarationError(item, f"axis = {direction}", "accepted is a direction of any length but zero")
    z = z / length
    start = np.cross(np.eye(3)[int(np.argmin(np.abs(z)))], z) if second is None else np.asarray(second, float)
    x = start - (start @ z) * z
    if not np.linalg.norm(x) > 1e-6 * max(float(np.linalg.norm(start)), 1e-300):
        raise DeclarationError(item, f"the directions {direction} and {second} are parallel", "accepted are two that are not")
    x = x / np.linalg.norm(x)
    return np.stack([x, np.cross(z, x), z], axis=1)


def check_coincide(item: str, build_initial: Floats, a: VectorRows, b: VectorRows, names: str, size: float) -> None:
    """Refuse points that must coincide and do not.

    Args:
        item: the joint, for the message.
        build_initial: all coordinate vectors in the reference configuration, shape (n_vectors, 3).
        a, b: the points.
        names: their names.
        size: size of the bodies [m]; a gap of a millionth of it is taken as rounding of the input.
    """
    gap = float(np.linalg.norm(b.at(build_initial) - a.at(build_initial)))
    if gap > 1e-6 * size:
        raise DeclarationError(
            item, f"{names} lie {gap:.3g} m apart", "accepted are points that coincide in the reference configuration"
        )


def check_guided(item: str, build_initial: Floats, rows: Rows, size: float) -> None:
    """Refuse a point that must lie on an axis or in a plane and does not.

    Args:
        item: the joint, for the message.
        build_initial: all coordinate vectors in the reference configuration, shape (n_vectors, 3).
        rows: the joint's rows; those that say that axes are perpendicular hold anyway in the reference configuration.
        size: size of the bodies [m]; see :func:`check_coincide`.
    """
    for row in rows:
        off = row.sum(build_initial) - row.constant if isinstance(row, DotRow) else 0.0
        if abs(off) > 1e-6 * size:
            raise DeclarationError(
                item,
                f"{row.label.rpartition(': ')[2]} is {off:.3g} m in the reference configuration",
                "accepted is a marker b on the axis or in the plane",
            )
