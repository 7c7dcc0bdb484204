"""Equilibrium with a free load factor: r(u, factor) = 0 together with one equation g(u, factor) = 0."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from lamella.assembly.equations import Equations
from lamella.assembly.point import STATIC, Point
from lamella.errors import SingularSystemError
from lamella.result import Statistics
from lamella.roles import Floats
from lamella.solve.newton import NewtonSolver

Condition = Callable[[Point], tuple[float, Floats, float]]
"""g at a point with its derivatives by u and by the load factor."""
Between = Callable[[float], Point | None]
"""The equilibrium at a share 0 to 1 of the way from one point of a path to the next; None where it is not found."""
Record = Callable[[Point, Between | None], bool]
"""Receives a new point of a path, and how to find those between it and the one before; False where there are none, because the
point lies on another path, and it was not taken."""


class BorderedNewton:
    """Newton's method for r(u, factor) = 0, g(u, factor) = 0 by two solutions with the stiffness alone (Riks 1979).

        K du_r = -r,   K du_f = -dr/dfactor,   dfactor = -(g + g_u . du_r) / (g_u . du_f + g_f),   du = du_r + dfactor du_f

    Args:
        equations: residual and matrix.
        newton: linear solver, norms and tolerance.
        statistics: counts the work.
    """

    def __init__(self, equations: Equations, newton: NewtonSolver, statistics: Statistics) -> None:
        self.equations, self.newton, self.statistics = equations, newton, statistics
        self.metric = 1.0 / (equations.magnitude**2 * equations.n_u)
        """Weights of |du|^2, the mean square of changes relative to the magnitude of each coordinate."""

    def tangent(self, point: Point) -> tuple[Floats, Floats]:
        """du/dfactor and dlam/dfactor along the path at an equilibrium.

        Raises:
            SingularSystemError: a limit point of the load, exactly.
        """
        self._linearise(point, point)
        return self._solve(-self.equations.load_direction(point))

    def solve(self, predicted: Point, before: Point, condition: Condition, most: int) -> tuple[int, Point | None]:
        """Correct a predicted point; (iterations, None) when it does not converge.

        Args:
            predicted: where to start.
            before: the equilibrium before, from which stress is extrapolated.
            condition: g with its derivatives.
            most: largest number of iterations.
        """
        new, last, iteration = predicted, np.inf, 0
        for iteration in range(1, min(self.newton.options.max_iterations, most) + 1):
            try:
                r, phi = self._linearise(new, before)
                if not np.isfinite(r).all():
                    return iteration, None
                du_r, dlam_r = self._solve(-r, -phi)
                du_f, dlam_f = self._solve(-self.equations.load_direction(new))
            except SingularSystemError:
                return iteration, None
            g, g_u, g_f = condition(new)
            df = -(g + float(g_u @ du_r)) / (float(g_u @ du_f) + g_f)
            du = du_r + df * du_f
            size = self.newton.size(du)
            before = new.copy()
            new.u, new.lam, new.factor = new.u + du, new.lam + dlam_r + df * dlam_f, new.factor + df
            self.statistics.newton_iterations += 1
            contraction = size / last if np.isfinite(last) else 0.5
            if not np.isfinite(size) or size > 1e6:
                return iteration, None
            if contraction < 1 and size * contraction / (1 - contraction) <= self.newton.options.tolerance:
                return iteration, new
            last = size
        return iteration, None

    def _linearise(self, point: Point, before: Point) -> tuple[Floats, Floats]:
        previous = self.equations.coordinates(before) if self.newton.options.extrapolate else None
        r, phi, k, j = self.equations.linearise(point, STATIC, previous)
        self.newton.linear.factorise(k, j)
        self.newton.forget()
        self.statistics.tangents += 1
        self.statistics.factorisations += 1
        return r, phi

    def _solve(self, r: Floats, s: Floats | None = None) -> tuple[Floats, Floats]:
        self.statistics.solves += 1
        return self.newton.linear.solve(r, np.zeros(self.equations.n_lam) if s is None else s)
