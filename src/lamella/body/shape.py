"""Simple solids: the look of a rigid body, and its inertia when it is filled evenly."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Literal

import numpy as np

from lamella.declaration import declaration
from lamella.roles import Floats, Ints
from lamella.units import Thickness

FACETS = 24
"""Facets around a cylinder or sphere."""


class Solid(ABC):
    """A solid about the centre of mass of a rigid body, in the body's axes.

    1. ``volume`` is positive; ``gyration`` are the principal moments of inertia for a mass of 1 kg, filled evenly.
    2. ``surface`` gives vertices (n, 3) [m] and quadrilaterals (m, 4) of vertex numbers, outward by the right-hand rule; a
       triangle repeats its last vertex.
    """

    @property
    @abstractmethod
    def volume(self) -> float:
        """Volume [m^3]."""

    @property
    @abstractmethod
    def gyration(self) -> Floats:
        """Principal moments of inertia per mass [m^2], shape (3,)."""

    @abstractmethod
    def surface(self) -> tuple[Floats, Ints]:
        """Vertices and quadrilaterals."""


@declaration
class Box(Solid):
    """A box.

    Args:
        size: edge lengths along the body's axes [m].
    """

    size: tuple[Thickness, Thickness, Thickness]
    kind: Literal["box"] = "box"

    @property
    def volume(self) -> float:
        return self.size[0] * self.size[1] * self.size[2]

    @property
    def gyration(self) -> Floats:
        squares = np.square(self.size)
        return (squares.sum() - squares) / 12.0

    def surface(self) -> tuple[Floats, Ints]:
        corners = np.array([[x, y, z] for z in (-0.5, 0.5) for y in (-0.5, 0.5) for x in (-0.5, 0.5)]) * self.size
        faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
        return corners, np.array(faces, dtype=np.int64)


@declaration
class Cylinder(Solid):
    """A cylinder about the body's z axis.

    Args:
        radius: radius [m].
        length: length along z [m].
    """

    radius: Thickness
    length: Thickness
    kind: Literal["cylinder"] = "cylinder"

    @property
    def volume(self) -> float:
        return np.pi * self.radius**2 * self.length

    @property
    def gyration(self) -> Floats:
        across = self.radius**2 / 4.0 + self.length**2 / 12.0
        return np.array([across, across, self.radius**2 / 2.0])

    def surface(self) -> tuple[Floats, Ints]:
        angle = 2.0 * np.pi * np.arange(FACETS) / FACETS
        ring = self.radius * np.stack([np.cos(angle), np.sin(angle), 0.0 * angle], axis=1)
        up = np.array([0.0, 0.0, 0.5 * self.length])
        k, following = np.arange(FACETS), np.roll(np.arange(FACETS), -1)
        bottom, top = np.full(FACETS, 2 * FACETS), np.full(FACETS, 2 * FACETS + 1)
        sides = np.stack([k, following, following + FACETS, k + FACETS], axis=1)
        caps = [np.stack([bottom, following, k, k], axis=1), np.stack([top, k + FACETS, *2 * [following + FACETS]], axis=1)]
        return np.concatenate([ring - up, ring + up, [-up, up]]), np.concatenate([sides, *caps])


@declaration
class Sphere(Solid):
    """A sphere.

    Args:
        radius: radius [m].
    """

    radius: Thickness
    kind: Literal["sphere"] = "sphere"

    @property
    def volume(self) -> float:
        return 4.0 / 3.0 * np.pi * self.radius**3

    @property
    def gyration(self) -> Floats:
        return np.full(3, 0.4 * self.radius**2)

    def surface(self) -> tuple[Floats, Ints]:
        angle = 2.0 * np.pi * np.arange(FACETS) / FACETS
        height = np.linspace(-0.5 * np.pi, 0.5 * np.pi, FACETS // 2 + 1)
        rings = [
            np.stack([np.cos(b) * np.cos(angle), np.cos(b) * np.sin(angle), np.sin(b) + 0.0 * angle], axis=1) for b in height
        ]
        k, following = np.arange(FACETS), np.roll(np.arange(FACETS), -1)
        faces = [
            FACETS * ring + np.stack([k, following, following + FACETS, k + FACETS], axis=1) for ring in range(len(height) - 1)
        ]
        return self.radius * np.concatenate(rings), np.concatenate(faces)
