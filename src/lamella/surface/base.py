"""What a reference surface tells a mesh: its parameters' lengths, and position and slopes at any of its points."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from lamella.roles import Floats


@dataclass(frozen=True)
class SurfacePoints:
    """A surface at n points, in the axes of the surface; arrays of shape (n, 3).

    Args:
        r: positions [m].
        r_x, r_y: derivatives by the parameters [-].
        r_xy: mixed derivative [1/m].
    """

    r: Floats
    r_x: Floats
    r_y: Floats
    r_xy: Floats

    def vectors(self, names: tuple[str, ...]) -> Floats:
        """The vectors of these names, point by point, shape (n, len(names), 3)."""
        return np.stack([getattr(self, name) for name in names], axis=1)


class Surface(ABC):
    """A smooth surface r(x, y) over the rectangle 0 <= x <= size[0], 0 <= y <= size[1].

    The parameters have the unit of a length and should be near to arc lengths; they need not be orthogonal, and their slopes need
    not have unit length. The normal r_x x r_y points to the top side. What a direction that is ``closed`` ends with is what it
    began with, so that a mesh on it has no edge there.
    """

    python_only: ClassVar[bool] = False
    """Whether it holds Python functions, which no model file can."""

    @property
    @abstractmethod
    def size(self) -> tuple[float, float]:
        """Lengths of the parameters x and y [m]."""

    @property
    def loops(self) -> tuple[bool, bool]:
        """Whether the surface closes on itself along x, and along y."""
        return (False, False)

    @abstractmethod
    def at(self, x: Floats, y: Floats) -> SurfacePoints:
        """Position and derivatives at parameters x, y [m], each of shape (n,)."""


class Rectangle(Surface):
    """The flat rectangle r = (x, y, 0).

    Args:
        size: lengths along x and y [m].
    """

    def __init__(self, size: tuple[float, float]) -> None:
        self._size = size

    @property
    def size(self) -> tuple[float, float]:
        return self._size

    def at(self, x: Floats, y: Floats) -> SurfacePoints:
        one, zero = np.ones_like(x), np.zeros_like(x)
        return SurfacePoints(*(np.stack(v, axis=1) for v in ((x, y, zero), (one, zero, zero), (zero, one, zero), (zero,) * 3)))
