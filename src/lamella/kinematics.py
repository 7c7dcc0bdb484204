"""Points, vectors and frames of bodies as linear functions of the coordinate vectors.

All coordinates are components of vectors, so whatever is fixed in a rigid body, or lies at a material point of a plate, is a sum
of coordinate vectors with constant weights: its derivatives are the weights themselves.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lamella.roles import Floats, Ints


def vectors_of(coordinates: Floats) -> Floats:
    """All coordinates (..., n_q) as vectors, shape (..., n, 3); what lies behind them is never referred to by their numbers."""
    *several, n_q = coordinates.shape
    return coordinates[..., : n_q - n_q % 3].reshape(*several, -1, 3)


@dataclass(frozen=True)
class VectorRows:
    """A vector in space as a linear function of coordinate vectors x_k: sum_k weight_k x_k + constant.

    Args:
        vectors: numbers of the coordinate vectors, each once, shape (n,).
        weights: their weights, shape (n,).
        constant: constant part, shape (3,); the whole of it for what is fixed in space.
    """

    vectors: Ints
    weights: Floats
    constant: Floats

    @classmethod
    def fixed(cls, constant: Floats) -> VectorRows:
        """A vector fixed in the inertial frame."""
        return cls(np.zeros(0, dtype=np.int64), np.zeros(0), np.asarray(constant, float))

    @classmethod
    def single(cls, vector: int) -> VectorRows:
        """One coordinate vector."""
        return cls(np.array([vector], dtype=np.int64), np.ones(1), np.zeros(3))

    def at(self, vectors: Floats) -> Floats:
        """Its value; ``vectors`` are all coordinate vectors, shape (..., n_vectors, 3)."""
        return self.weights.dot(vectors.take(self.vectors, -2)) + self.constant

    def rate(self, velocities: Floats) -> Floats:
        """Its derivative by time from those of all coordinate vectors, shape (..., n_vectors, 3)."""
        return self.weights.dot(velocities.take(self.vectors, -2))

    def __add__(self, other: VectorRows) -> VectorRows:
        return _combined(self, other, 1.0)

    def __sub__(self, other: VectorRows) -> VectorRows:
        return _combined(self, other, -1.0)

    def __mul__(self, factor: float) -> VectorRows:
        return VectorRows(self.vectors, factor * self.weights, factor * self.constant)

    __rmul__ = __mul__

    def __neg__(self) -> VectorRows:
        return self * -1.0


def _combined(a: VectorRows, b: VectorRows, factor: float) -> VectorRows:
    """a + factor b with each coordinate vector listed once and cancelled ones left out."""
    if not len(b.vectors):
        return VectorRows(a.vectors, a.weights, a.constant + factor * b.constant)
    vectors, weights = np.concatenate([a.vectors, b.vectors]), np.concatenate([a.weights, factor * b.weights])
    largest = np.abs(weights).max(initial=0.0)
    if len(a.vectors) and len(b.vectors):
        vectors, inverse = np.unique(vectors, return_inverse=True)
        weights = np.bincount(inverse, weights, minlength=len(vectors)).astype(float)
    used = np.abs(weights) > 1e-14 * largest  # differences of equal weights are rounding
    return VectorRows(vectors[used], weights[used], a.constant + factor * b.constant)


class StackedRows:
    """Several linear functions of coordinate vectors, evaluated in one product.

    Args:
        rows: the functions.
    """

    def __init__(self, rows: Sequence[VectorRows]) -> None:
        self._vectors = np.unique(np.concatenate([np.zeros(0, np.int64), *(row.vectors for row in rows)]))
        self._weights = np.zeros((len(rows), len(self._vectors)))
        for weights, row in zip(self._weights, rows, strict=True):
            weights[np.searchsorted(self._vectors, row.vectors)] = row.weights
        self._constants = np.array([row.constant for row in rows]).reshape(-1, 3)

    def at(self, vectors: Floats) -> Floats:
        """Their values, shape (n_rows, 3); ``vectors`` are all coordinate vectors, shape (n_vectors, 3)."""
        return self._weights.dot(vectors.take(self._vectors, 0)) + self._constants


@dataclass(frozen=True)
class Frame:
    """A point with three orthonormal axes that move with a body; each is a linear function of coordinate vectors.

    Args:
        origin: position.
        axes: the axes x, y, z.
    """

    origin: VectorRows
    axes: tuple[VectorRows, VectorRows, VectorRows]

    @property
    def x(self) -> VectorRows:
        """First axis."""
        return self.axes[0]

    @property
    def y(self) -> VectorRows:
        """Second axis."""
        return self.axes[1]

    @property
    def z(self) -> VectorRows:
        """Third axis."""
        return self.axes[2]

    def rotation(self, vectors: Floats) -> Floats:
        """Rotation matrix R_WF, whose columns are the axes; ``vectors`` are all coordinate vectors, shape (n_vectors, 3)."""
        return np.stack([axis.at(vectors) for axis in self.axes], axis=1)


@dataclass(frozen=True)
class PointRows:
    """A material point as a linear function of coordinate vectors x_k: r = sum_k position_k x_k + offset.

    Args:
        vectors: numbers of the coordinate vectors, shape (n,).
        position: weights of the position, shape (n,).
        slope_x: weights of the first tangent r_x at the point, shape (n,).
        slope_y: weights of the second tangent r_y, shape (n,).
        offset: constant part of the position [m], shape (3,).
    """

    vectors: Ints
    position: Floats
    slope_x: Floats
    slope_y: Floats
    offset: Floats

    def at(self, vectors: Floats) -> Floats:
        """Position [m] of the point; ``vectors`` are all coordinate vectors, shape (..., n_vectors, 3)."""
        return self.position.dot(vectors.take(self.vectors, -2)) + self.offset

    def moved(self, velocities: Floats) -> Floats:
        """Velocity [m/s] (or virtual displacement) of the point from those of all vectors, shape (..., n_vectors, 3)."""
        return self.position.dot(velocities.take(self.vectors, -2))

    @property
    def point(self) -> VectorRows:
        """The position."""
        used = self.position != 0.0
        return VectorRows(self.vectors[used], self.position[used], self.offset)

    @property
    def tangents(self) -> tuple[VectorRows, VectorRows]:
        """The tangents r_x and r_y."""
        none = np.zeros(3)
        used_x, used_y = self.slope_x != 0.0, self.slope_y != 0.0
        return (
            VectorRows(self.vectors[used_x], self.slope_x[used_x], none),
            VectorRows(self.vectors[used_y], self.slope_y[used_y], none),
        )

    def normal(self, vectors: Floats) -> Floats:
        """Unit normal r_x x r_y / |r_x x r_y| at the point."""
        n = np.cross(self.slope_x @ vectors[self.vectors], self.slope_y @ vectors[self.vectors])
        return n / np.linalg.norm(n)
