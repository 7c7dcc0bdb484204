"""Shapes with a number each: what natural modes and buckling shapes have in common."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import ClassVar

from lamella.model import Model
from lamella.roles import Floats


class Shapes(ABC):
    """Shapes about a state, each with a value.

    Class attributes say how they are written: ``title`` of tables and pictures, ``quantity`` the name, unit and meaning of the
    values, ``scaling`` how the shapes are normalised.
    """

    title: ClassVar[str]
    quantity: ClassVar[tuple[str, str, str]]
    scaling: ClassVar[str]
    model: Model
    shapes: Floats
    state: Floats

    @property
    @abstractmethod
    def values(self) -> Floats:
        """The values, shape (n,)."""

    def imperfection(self, number: int, amplitude: float) -> Floats:
        """Shape ``number`` (from 0) with a largest displacement of ``amplitude`` [m], all coordinates, shape (n_q,).

        A rigid body that turns about its origin is displaced as far as its points at its reach are.
        """
        shape = self.shapes[:, number]
        return amplitude / self.model.largest_displacement(shape) * shape

    def displaced(self, mode: int, amplitude: float) -> Floats:
        """Coordinates with shape number ``mode`` (from 0) added, its largest displacement being ``amplitude`` [m]."""
        return self.state + self.imperfection(mode, amplitude)
