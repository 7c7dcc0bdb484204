"""The distance joint: two points keep their distance, as held by a massless rod with ball ends."""

from __future__ import annotations

import numpy as np

from lamella.body.base import Marker
from lamella.declaration import declaration
from lamella.dofs import Build, Signal
from lamella.errors import DeclarationError
from lamella.kinematics import PointRows
from lamella.roles import ConstraintBlock, Declaration, Floats, Ints
from lamella.state import State
from lamella.units import Thickness


@declaration
class DistanceJoint(Declaration):
    """Keep the distance of two markers: Phi = |r_b - r_a| - L = 0.

    The constraint is nonlinear and takes a Lagrange multiplier, which is the rod's axial force.

    Args:
        name: unique name; the result holds ``<name>.tension`` [N], positive in tension, and ``<name>.force`` [N] on marker b.
        a: first marker (may be on the ground).
        b: second marker.
        length: distance L [m]; the initial distance when left out.
    """

    name: str
    a: Marker
    b: Marker
    length: Thickness | None = None

    def contribute(self, build: Build) -> None:
        """Add one nonlinear constraint and its signals."""
        a, b = self.a.rows(build), self.b.rows(build)
        vectors = build.initial
        distance = float(np.linalg.norm(b.at(vectors) - a.at(vectors)))
        if distance == 0.0:
            raise DeclarationError(
                f"DistanceJoint '{self.name}'", f"{self.a} and {self.b} coincide", "accepted are two distinct points"
            )
        block = DistanceBlock(self.name, a, b, self.length or distance)
        build.constraints.append(block)
        build.signals.append(
            Signal(f"{self.name}.tension", "N", (), lambda s: float(s.lam[block.first]), f"axial force in {self.name}")
        )
        build.signals.append(
            Signal(
                f"{self.name}.force",
                "N",
                ("x", "y", "z"),
                lambda s: -s.lam[block.first] * block.direction(s),
                f"force on {self.b}",
            )
        )


class DistanceBlock(ConstraintBlock):
    """Phi = |d| - L with d = r_b - r_a = sum_k w_k x_k + constant; Phi_q = w_k n^T with n = d / |d|."""

    def __init__(self, name: str, a: PointRows, b: PointRows, length: float) -> None:
        self.name, self.n_lam, self.length = name, 1, length
        vectors, inverse = np.unique(np.concatenate([a.vectors, b.vectors]), return_inverse=True)
        self.weights = np.bincount(inverse, np.concatenate([-a.position, b.position]), minlength=len(vectors))
        self.constant = b.offset - a.offset
        self.coords: Ints = (3 * vectors[:, None] + np.arange(3)).reshape(-1)
        self.j_rows, self.j_cols = np.zeros(len(self.coords), dtype=np.int64), self.coords
        self._upper = np.triu_indices(len(self.coords))
        self.k_rows, self.k_cols = self.coords[self._upper[0]], self.coords[self._upper[1]]

    def _join(self, q: Floats) -> Floats:
        return self.weights @ q[self.coords].reshape(-1, 3)

    def direction(self, state: State) -> Floats:
        """Unit vector from a to b."""
        d = self._join(state.q) + self.constant
        return d / np.linalg.norm(d)

    def phi(self, t: float, q: Floats, out: Floats) -> None:
        out[0] = np.linalg.norm(self._join(q) + self.constant) - self.length

    def jacobian(self, t: float, q: Floats, out: Floats) -> None:
        d = self._join(q) + self.constant
        out[:] = np.outer(self.weights, d / np.linalg.norm(d)).reshape(-1)

    def curvature(self, t: float, q: Floats, lam: Floats, out: Floats) -> None:
        d = self._join(q) + self.constant
        distance = np.linalg.norm(d)
        n = d / distance
        block = lam[0] * (np.eye(3) - np.outer(n, n)) / distance
        out[:] = np.kron(np.outer(self.weights, self.weights), block)[self._upper]

    def phi_t(self, t: float, q: Floats, out: Floats) -> None:
        out[0] = 0.0

    def gamma(self, t: float, q: Floats, v: Floats, out: Floats) -> None:
        d, rate = self._join(q) + self.constant, self._join(v)
        distance = np.linalg.norm(d)
        out[0] = (rate @ rate - (rate @ d / distance) ** 2) / distance
