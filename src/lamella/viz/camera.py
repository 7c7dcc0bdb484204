"""An orthographic camera that shows every frame of a motion whole."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lamella.errors import DeclarationError
from lamella.roles import Floats

VIEWS = {
    "isometric": (-0.55, 1.0, -0.62),
    "front": (0.0, 1.0, 0.0),
    "side": (-1.0, 0.0, 0.0),
    "top": (0.0, 0.0, -1.0),
}
"""Directions in which the camera looks; z is up, in the top view y is."""

MARGIN = 1.06
SMALLEST = 1e-9


@dataclass(frozen=True)
class Camera:
    """An orthographic camera.

    Args:
        look: unit vector from the camera to the scene, shape (3,).
        right: unit vector to the right of the picture, shape (3,).
        up: unit vector to the top of the picture, shape (3,).
        centre: point in the middle of the picture [m], shape (3,).
        half_width: half of what the picture shows horizontally [m].
        half_height: half of what it shows vertically [m].
    """

    look: Floats
    right: Floats
    up: Floats
    centre: Floats
    half_width: float
    half_height: float

    def project(self, points: Floats) -> tuple[Floats, Floats]:
        """Picture coordinates in [-1, 1], shape (..., 2), and depth along the view [m], shape (...)."""
        x = points - self.centre
        return np.stack([x @ self.right / self.half_width, x @ self.up / self.half_height], axis=-1), x @ self.look


def fit_camera(points: Floats, view: str | tuple[float, float, float], largest_aspect: float = 1.9) -> Camera:
    """The camera that shows all points, as large as they allow.

    Args:
        points: everything that shall be seen [m], shape (n, 3).
        view: a name of :data:`VIEWS` or the direction in which the camera looks.
        largest_aspect: limit of width to height of the picture, and of height to width.

    Raises:
        DeclarationError: no such view, or a direction without length.
    """
    if isinstance(view, str) and view not in VIEWS:
        raise DeclarationError("picture", f"no view '{view}'", f"accepted are {', '.join(VIEWS)} or a direction (x, y, z)")
    look = np.asarray(VIEWS[view] if isinstance(view, str) else view, float)
    if not np.linalg.norm(look) > 0:
        raise DeclarationError("picture", f"view = {view!r} has no length", "accepted is a direction (x, y, z)")
    look = look / np.linalg.norm(look)
    vertical = np.array([0.0, 0.0, 1.0]) if abs(look[2]) < 1 - 1e-9 else np.array([0.0, 1.0, 0.0])
    right = np.cross(look, vertical)
    right /= np.linalg.norm(right)
    up = np.cross(right, look)
    low, high = points.min(axis=0), points.max(axis=0)
    middle = 0.5 * (low + high)
    across, along = (points - middle) @ right, (points - middle) @ up
    half = MARGIN * np.maximum([np.ptp(across) / 2, np.ptp(along) / 2], SMALLEST)
    half = np.maximum(half, half[::-1] / largest_aspect)
    shift = 0.5 * (across.min() + across.max()) * right + 0.5 * (along.min() + along.max()) * up
    return Camera(look, right, up, middle + shift, float(half[0]), float(half[1]))
