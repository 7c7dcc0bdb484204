"""Consistent start: positions and velocities that obey the constraints, and the accelerations and multipliers that follow."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lamella.assembly.equations import Equations
from lamella.assembly.point import Point, Weights
from lamella.errors import ConstraintError, SingularSystemError
from lamella.roles import Floats
from lamella.solve.base import LinearSolver

MASS_ONLY = Weights(alpha_q=0.0, alpha_v=0.0, alpha_a=1.0)


@dataclass(frozen=True)
class Projection:
    """Largest change of a coordinate and of a velocity, relative to the size of the body, that made the start consistent."""

    position: float
    velocity: float


def make_consistent(equations: Equations, point: Point, linear: LinearSolver) -> Projection:
    """Project ``point`` onto the constraints in the metric of the mass matrix, then solve for accelerations and multipliers.

        M dq + Phi_q^T kappa = 0,  Phi_q dq = -Phi                positions, repeated until Phi vanishes
        M dv + Phi_q^T kappa = 0,  Phi_q dv = -(Phi_q v + Phi_t)  velocities
        M a + Phi_q^T lam = -f,    Phi_q a = -gamma               accelerations

    Raises:
        ConstraintError: the constraints cannot be met from here.
    """
    before = point.u.copy()
    if equations.n_lam:
        for attempt in range(20):
            phi = equations.residual(point)[1]
            if np.abs(phi).max() < 1e-12 * equations.magnitude.max():
                break
            try:
                _factorise_mass(equations, point, linear)
            except SingularSystemError as error:
                if attempt == 0:
                    raise
                raise _out_of_reach(phi) from error  # what was regular at the start became singular far away from it
            point.u += linear.solve(np.zeros(equations.n_u), -phi)[0]
        else:
            raise _out_of_reach(equations.residual(point)[1])
    moved = float(np.max(np.abs(point.u - before) / equations.magnitude, initial=0.0))
    turned = solve_rates(equations, point, linear)
    return Projection(moved, turned)


def _out_of_reach(phi: Floats) -> ConstraintError:
    return ConstraintError(
        f"no position near the initial one satisfies the constraints; they are violated by {np.abs(phi).max():.2g}"
    )


def solve_rates(equations: Equations, point: Point, linear: LinearSolver) -> float:
    """Velocities that obey the constraints, and the accelerations and multipliers that follow; gives the change of velocity."""
    _factorise_mass(equations, point, linear)
    change = 0.0
    if equations.n_lam:
        dv, _ = linear.solve(np.zeros(equations.n_u), -equations.velocity_violation(point))
        point.ud += dv
        change = float(np.max(np.abs(dv) / equations.magnitude, initial=0.0))
    point.udd[:] = 0.0
    point.lam[:] = 0.0
    r, _ = equations.residual(point)
    point.udd[:], point.lam[:] = linear.solve(-r, -equations.acceleration_rest(point))
    return change


def _factorise_mass(equations: Equations, point: Point, linear: LinearSolver) -> None:
    _, _, k, j = equations.linearise(point, MASS_ONLY)
    try:
        linear.factorise(k, j)
    except SingularSystemError as error:
        raise SingularSystemError(f"the mass matrix is singular: {error}", getattr(error, "index", None)) from error
