"""Derivatives of a solution: one factorisation of the exact matrix, and one substitution for each parameter."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from lamella.assembly.point import STATIC, Point
from lamella.differentiation.exact_matrix import ExactMatrix
from lamella.differentiation.neighbours import Neighbours
from lamella.differentiation.parts import Side
from lamella.roles import Floats
from lamella.solve.base import LinearSolver
from lamella.solve.initial import MASS_ONLY, is_consistent, make_consistent, start_of
from lamella.solve.linear import linear_solver


@dataclass
class PointDerivative:
    """Derivative of a :class:`Point` by a parameter.

    Args:
        u, ud, udd: of the independent coordinates, their velocities and accelerations, shape (n_u,).
        lam: of the multipliers, shape (n_lam,).
    """

    u: Floats
    ud: Floats
    udd: Floats
    lam: Floats

    def moved(self, point: Point, distance: float) -> Point:
        """The point with coordinates and velocities that belong to a value of the parameter at a distance."""
        there = point.copy()
        there.u += distance * self.u
        there.ud += distance * self.ud
        return there


def residual_difference(neighbours: Neighbours, point: Point, x: PointDerivative | None = None) -> tuple[Floats, Floats]:
    """Derivatives of r and Phi by the parameter with u and lam as they are, and velocities and accelerations that follow ``x``.

    Coordinates stay: along a straight line in them a plate that turns is stretched with the square of the step, and its
    membrane is stiffer than its bending by 12 (length / thickness)^2, which would spoil a difference. In velocities and
    accelerations forces are linear or nearly so.
    """
    return neighbours.residual(point, None, None) if x is None else neighbours.residual(point, x.ud, x.udd)


def static_derivatives(matrix: ExactMatrix, point: Point, neighbours: Sequence[Neighbours]) -> list[PointDerivative]:
    """Derivatives of an equilibrium by each parameter: K du + J^T dlam = -dr/dp, J du = -dPhi/dp.

    Raises:
        ModelError: the stiffness is singular, as at a critical point.
    """
    matrix.factorise(point, STATIC)
    found, still = [], np.zeros_like(point.u)
    for each in neighbours:
        du, dlam = matrix.solve(*residual_difference(each, point))
        found.append(PointDerivative(du, still, still, dlam))
    return found


def start_derivative(neighbours: Neighbours, point: Point, given: PointDerivative | None) -> PointDerivative:
    """Derivative of the start of a motion: coordinates and velocities; accelerations and multipliers vanish yet.

    Args:
        neighbours: of the parameter.
        point: the start.
        given: derivative of the state it was given; None for the reference configuration.
    """

    def evaluate(side: Side) -> Floats:
        equations = side.equations
        there = start_of(equations, point.t) if given is None else given.moved(point, side.distance)
        if not is_consistent(equations, there):
            make_consistent(equations, there, linear_solver(equations.matrix.pattern))
        return np.concatenate([there.u, there.ud])

    du, dud = np.split(neighbours.difference(evaluate), 2)
    return PointDerivative(du if given is None else given.u, dud, np.zeros_like(du), np.zeros(len(point.lam)))


def rates_derivative(
    matrix: ExactMatrix,
    point: Point,
    neighbours: Sequence[Neighbours],
    found: Sequence[PointDerivative],
    held: LinearSolver | None = None,
) -> list[PointDerivative]:
    """Derivatives of accelerations, multipliers and rates of fields at a consistent start, from those of u and ud.

        M dudd + J^T dlam = -(dr/dp + K du + D dud),     J dudd = -d(J udd + gamma)

    Args:
        matrix: of the equations; factorised here.
        point: the start.
        neighbours: of each parameter.
        found: derivatives of u and ud.
        held: the solver that has found the rates of the start, with its factorisation.
    """
    n = matrix.equations.n_motion
    moved = [np.zeros_like(known.u) for known in found]
    if any(known.u.any() for known in found):
        K = matrix.stiffness(point)
        moved = [K(known.u) for known in found]
    if held is None or not matrix.equations.is_exact:
        matrix.factorise(point, MASS_ONLY)
        held = None
    derivatives = []
    for each, known, Ku in zip(neighbours, found, moved, strict=True):
        dud = np.concatenate([known.ud[:n], np.zeros(len(known.ud) - n)])  # rates of fields are what is looked for
        dr = residual_difference(each, point, PointDerivative(known.u, dud, np.zeros_like(dud), known.lam))[0] + Ku

        def needed(side: Side, known: PointDerivative = known) -> Floats:
            there, at = side.equations, known.moved(point, side.distance)
            return there.acceleration_rest(at) + there.constraints.times(at.t, there.coordinates(at), there.expand(at.udd))

        ds = each.difference(needed)
        rates, dlam = matrix.solve(dr, ds) if held is None else held.solve(-dr, -ds)
        dud[n:] = rates[n:]
        derivatives.append(PointDerivative(known.u, dud, np.concatenate([rates[:n], np.zeros(len(rates) - n)]), dlam))
    return derivatives


def projected_velocities(
    matrix: ExactMatrix, before: Point, after: Point, neighbours: Sequence[Neighbours], found: Sequence[PointDerivative]
) -> list[PointDerivative]:
    """Derivatives of velocities that were projected onto the constraints where a motion begins anew.

    With x = ud' - ud the projection is M x + J^T kappa = 0, J (ud + x) + Phi_t = 0, and its derivative

        M dx + J^T dkappa = -d(M x + J^T kappa),     J dx = -d(J (ud + x) + Phi_t)

    with x and kappa as they are on the right.

    Args:
        matrix: of the equations; factorised here.
        before, after: the point with the velocities before and after.
        neighbours: of each parameter.
        found: derivatives of u and ud before.
    """
    equations = matrix.equations
    if not equations.n_lam:
        return list(found)
    matrix.factorise(after, MASS_ONLY)
    at = replace(before, t=after.t)
    x, kappa = matrix.solve(np.zeros(equations.n_u), equations.velocity_violation(at))
    none = replace(after, udd=np.zeros_like(x), lam=np.zeros_like(kappa))
    moving = replace(after, udd=x, lam=kappa)

    def of_forces(side: Side, known: PointDerivative) -> Floats:
        ends = [side.equations.residual(replace(p, u=known.moved(p, side.distance).u))[0] for p in (moving, none)]
        return ends[0] - ends[1]

    derivatives = []
    for each, known in zip(neighbours, found, strict=True):
        forces = each.difference(lambda side, known=known: of_forces(side, known))
        rates = each.difference(lambda side, known=known: side.equations.velocity_violation(known.moved(after, side.distance)))
        derivatives.append(replace(known, ud=known.ud + matrix.solve(forces, rates)[0]))
    return derivatives
