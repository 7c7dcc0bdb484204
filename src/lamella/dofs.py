"""Numbering: the build that declarations contribute to while a system is compiled."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Protocol

import numpy as np

from lamella.errors import ModelError
from lamella.roles import Bools, ConstraintBlock, Floats, ForceBlock, InertiaBlock, Ints

if TYPE_CHECKING:
    from lamella.state import State


class Motion(Protocol):
    """A function of time with its first two derivatives (see ``lamella.math.profile``)."""

    def value(self, t: float) -> float: ...
    def rate(self, t: float) -> float: ...
    def acceleration(self, t: float) -> float: ...
    @property
    def breakpoints(self) -> tuple[float, ...]: ...


@dataclass(frozen=True)
class LinearRow:
    """One constant linear constraint ``coefs . q[coords] = constant + motion(t)``, eliminated before the solution.

    Args:
        label: says in words what is held, for messages.
        coords: coordinates, shape (n,).
        coefs: coefficients, shape (n,).
        constant: right-hand side without motion.
        motion: prescribed motion added to the right-hand side.
    """

    label: str
    coords: Ints
    coefs: Floats
    constant: float
    motion: Motion | None = None


@dataclass(frozen=True)
class Signal:
    """A quantity recorded while a solution runs.

    Args:
        name: for example ``tip.position``.
        unit: for example ``m``.
        labels: names of the components, empty for a scalar.
        evaluate: gives the value from a state, shape (len(labels),) or scalar.
        description: a short sentence for the result file.
    """

    name: str
    unit: str
    labels: tuple[str, ...]
    evaluate: Callable[[State], Floats | float]
    description: str = ""


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
        """Its value; ``vectors`` are all coordinate vectors, shape (n_vectors, 3)."""
        return self.weights @ vectors[self.vectors] + self.constant

    def rate(self, velocities: Floats) -> Floats:
        """Its derivative by time from those of all coordinate vectors, shape (n_vectors, 3)."""
        return self.weights @ velocities[self.vectors]

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
    vectors, inverse = np.unique(np.concatenate([a.vectors, b.vectors]), return_inverse=True)
    weights = np.bincount(inverse, np.concatenate([a.weights, factor * b.weights]), minlength=len(vectors)).astype(float)
    largest = max(np.abs(a.weights).max(initial=0.0), np.abs(b.weights).max(initial=0.0))
    used = np.abs(weights) > 1e-14 * largest  # differences of equal weights are rounding
    return VectorRows(vectors[used], weights[used], a.constant + factor * b.constant)


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
        """Position [m] of the point; ``vectors`` are all coordinate vectors, shape (n_vectors, 3)."""
        return self.position @ vectors[self.vectors] + self.offset

    def moved(self, velocities: Floats) -> Floats:
        """Velocity [m/s] (or virtual displacement) of the point from those of all vectors, shape (n_vectors, 3)."""
        return self.position @ velocities[self.vectors]

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


@dataclass(frozen=True)
class Support:
    """The rows of one support, with the point its reaction torque refers to."""

    name: str
    rows: tuple[int, ...]
    centre: PointRows


@dataclass
class Build:
    """What declarations have contributed so far. Vectors are numbered in the order of declaration."""

    q: list[Floats] = field(default_factory=list)
    v: list[Floats] = field(default_factory=list)
    is_position: list[Bools] = field(default_factory=list)
    magnitude: list[Floats] = field(default_factory=list)
    forces: list[ForceBlock] = field(default_factory=list)
    loads: list[ForceBlock] = field(default_factory=list)
    inertias: list[InertiaBlock] = field(default_factory=list)
    constraints: list[ConstraintBlock] = field(default_factory=list)
    rows: list[LinearRow] = field(default_factory=list)
    supports: list[Support] = field(default_factory=list)
    signals: list[Signal] = field(default_factory=list)
    bodies: dict[str, object] = field(default_factory=dict)
    breakpoints: list[float] = field(default_factory=list)
    n_vectors: int = 0

    def vectors(self, q: Floats, v: Floats, is_position: Bools, magnitude: Floats) -> int:
        """Number a body's coordinate vectors.

        Args:
            q: initial values, shape (n, 3).
            v: initial velocities, shape (n, 3).
            is_position: True where a vector is a position (moved by a translation), shape (n,).
            magnitude: typical size of a change of each vector (length for a position, 1 for a slope), for convergence
                criteria that do not depend on the unit system, shape (n,).

        Returns:
            The number of the first vector.
        """
        first = self.n_vectors
        self.q.append(np.asarray(q, float))
        self.v.append(np.asarray(v, float))
        self.is_position.append(np.asarray(is_position, bool))
        self.magnitude.append(np.asarray(magnitude, float))
        self.n_vectors += len(q)
        return first

    def hold(self, name: str, rows: list[LinearRow], centre: PointRows) -> None:
        """Add a support: linear rows whose reaction force, and torque about ``centre``, are reported under ``name``."""
        first = len(self.rows)
        for row in rows:
            if row.motion is not None:
                self.breakpoints.extend(row.motion.breakpoints)
        self.rows.extend(rows)
        self.supports.append(Support(name, tuple(range(first, first + len(rows))), centre))

    def body(self, name: str) -> object:
        """The compiled form of a body, by its name."""
        if name not in self.bodies:
            raise ModelError(f"body '{name}' is referred to but was not added to the system; call system.add({name}) first")
        return self.bodies[name]
