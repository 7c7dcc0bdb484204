"""A model's equations in its independent coordinates: residual, matrix and constraints, as the solvers see them."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from scipy import sparse

from lamella.assembly.elimination import eliminate
from lamella.assembly.forces import ForceSum
from lamella.assembly.matrix import MatrixAssembly
from lamella.assembly.point import Point, Weights
from lamella.model import Model
from lamella.roles import Floats
from lamella.state import State


class Equations:
    """r(u) = T^T (M a + f(t, q, v) + Phi_q^T lam), Phi(t, q) with q = T u + G c(t).

    Args:
        model: the compiled model.
        symmetric: store the upper triangle only; by default when every block allows it. The symmetric part of a ``nearly``
            symmetric block is then used by Newton; ``symmetric=False`` gives the exact matrix.
    """

    def __init__(self, model: Model, symmetric: bool | None = None) -> None:
        self.model = model
        self.elimination = eliminate(model.rows, model.n_q)
        self.T, self.T_transposed = self.elimination.T, sparse.csr_array(self.elimination.T.T)
        self.n_u, self.n_lam = self.T.shape[1], model.n_lam
        self.magnitude = model.magnitude[self.elimination.independent]
        self.forces, self.loads = ForceSum(model.forces, model.n_q), ForceSum(model.loads, model.n_q)
        blocks = (*model.forces, *model.loads)
        self.symmetric = all(block.symmetry != "none" for block in blocks) if symmetric is None else symmetric
        self.depends_on_velocity = any(block.depends_on_velocity for block in blocks)

    @cached_property
    def matrix(self) -> MatrixAssembly:
        """The assembly of matrices; made when first needed."""
        return MatrixAssembly(self.model, self.T, self.symmetric)

    def start(self, t: float = 0.0, *, factor: float = 1.0, at_rest: bool = False) -> Point:
        """The reference configuration with the initial velocities (none at rest); supports take precedence over both."""
        chosen = self.elimination.independent
        zero = np.zeros(self.n_u)
        ud = zero.copy() if at_rest else self.model.v0[chosen].copy()
        return Point(t, self.model.q0[chosen].copy(), ud, zero, np.zeros(self.n_lam), factor, at_rest)

    def point_of(self, state: State, t: float) -> Point:
        """The point at time ``t`` with the coordinates, velocities, accelerations and multipliers of a state."""
        chosen = self.elimination.independent
        return Point(t, state.q[chosen].copy(), state.v[chosen].copy(), state.a[chosen].copy(), state.lam.copy())

    def coordinates(self, point: Point) -> Floats:
        """All coordinates q, shape (n_q,)."""
        return self.T @ point.u + self.elimination.G @ self.elimination.right_hand_side(point.t, point.factor)

    def velocities(self, point: Point) -> Floats:
        """All velocities, shape (n_q,)."""
        v = self.T @ point.ud
        return v + self.elimination.G @ self.elimination.rates(point.t) if self.elimination.moves and not point.at_rest else v

    def accelerations(self, point: Point) -> Floats:
        """All accelerations, shape (n_q,)."""
        a = self.T @ point.udd
        return (
            a + self.elimination.G @ self.elimination.accelerations(point.t)
            if self.elimination.moves and not point.at_rest
            else a
        )

    def residual(self, point: Point) -> tuple[Floats, Floats]:
        """r (n_u,) and Phi (n_lam,)."""
        q, v = self.coordinates(point), self.velocities(point)
        return self._reduce(point, q, self.forces(point.t, q, v), self.loads(point.t, q, v))

    def linearise(self, point: Point, weights: Weights, previous: Floats | None = None) -> tuple[Floats, Floats, Floats, Floats]:
        """r, Phi and the values of the matrix alpha_q K + alpha_v D + alpha_a M and of Phi_q T, in the pattern's order.

        Args:
            point: where.
            weights: how the unknown moves q, v and a.
            previous: coordinates q of Newton's previous iterate; see :class:`lamella.roles.ForceBlock`.
        """
        q, v = self.coordinates(point), self.velocities(point)
        k, j = self.matrix.values(self.forces, self.loads, point, q, v, weights, q if previous is None else previous)
        r, phi = self._reduce(point, q, self.forces.summed(), self.loads.summed())
        return r, phi, k, j

    def velocity_violation(self, point: Point) -> Floats:
        """Phi_q v + Phi_t, shape (n_lam,)."""
        q, v = self.coordinates(point), self.velocities(point)
        out, at = np.zeros(self.n_lam), 0
        for block in self.model.constraints:
            part, values = out[at : at + block.n_lam], np.empty(len(block.j_rows))
            block.phi_t(point.t, q, part)
            block.jacobian(point.t, q, values)
            np.add.at(part, block.j_rows, values * v[block.j_cols])
            at += block.n_lam
        return out

    def acceleration_rest(self, point: Point) -> Floats:
        """gamma plus Phi_q times the accelerations of moving supports, so that Phi_q T udd = -rest, shape (n_lam,)."""
        q, v = self.coordinates(point), self.velocities(point)
        a = self.elimination.G @ self.elimination.accelerations(point.t)
        out, at = np.zeros(self.n_lam), 0
        for block in self.model.constraints:
            part, values = out[at : at + block.n_lam], np.empty(len(block.j_rows))
            block.gamma(point.t, q, v, part)
            block.jacobian(point.t, q, values)
            np.add.at(part, block.j_rows, values * a[block.j_cols])
            at += block.n_lam
        return out

    def load_direction(self, point: Point) -> Floats:
        """Derivative of r by the load factor, shape (n_u,): -f_ext, and the stiffness times the supports' motion if they move."""
        q, v = self.coordinates(point), self.velocities(point)
        direction = self.T_transposed @ self.loads(point.t, q, v)
        if self.elimination.moves:  # by difference: exact derivatives of moved supports would need the eliminated columns of K
            step, ahead = 1e-7, point.copy()
            ahead.factor += step
            base = self.residual(point)[0]
            direction = (self.residual(ahead)[0] - base) / step
        return direction

    def state(self, point: Point) -> State:
        """All coordinates, velocities, accelerations and the reactions of the eliminated constraints."""
        q, v, a = self.coordinates(point), self.velocities(point), self.accelerations(point)
        total = self._total(point, q, self.forces(point.t, q, v), self.loads(point.t, q, v))
        return State(point.t, q, v, a, point.lam.copy(), self.elimination.row_forces(total), point.factor)

    def _reduce(self, point: Point, q: Floats, f: Floats, f_load: Floats) -> tuple[Floats, Floats]:
        phi, at = np.zeros(self.n_lam), 0
        for block in self.model.constraints:
            block.phi(point.t, q, phi[at : at + block.n_lam])
            at += block.n_lam
        return self.T_transposed @ self._total(point, q, f, f_load), phi

    def _total(self, point: Point, q: Floats, f: Floats, f_load: Floats) -> Floats:
        """M a + f + Phi_q^T lam in all coordinates; zero but for the reactions when the equations hold."""
        total = f + point.factor * f_load
        if not point.at_rest:
            total += self.model.mass @ self.accelerations(point)
        at = 0
        for block in self.model.constraints:
            values = np.empty(len(block.j_rows))
            block.jacobian(point.t, q, values)
            np.add.at(total, block.j_cols, values * point.lam[at + block.j_rows])
            at += block.n_lam
        return total
