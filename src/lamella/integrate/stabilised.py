"""The stabilised index-2 form of a step: positions and velocities both obey the constraints."""

from __future__ import annotations

import numpy as np
from scipy.sparse.linalg import SuperLU, splu

from lamella.assembly.equations import Equations
from lamella.assembly.point import Point, Weights
from lamella.roles import Floats

ROUNDING = 1e-15
"""Violation of a constraint, relative to the size of the bodies, at which a correction has nothing left to do."""
SLOW = 0.3
"""Contraction above which the matrix of the position correction is made anew."""
CORRECTIONS = 30
"""Corrections of a position before it is given up."""


class StabilisedEquations:
    """The equations of one step for the unknown (w, lam), from which positions follow by a second set of multipliers eta.

        u = w + B^T eta,   Phi(t, u) = 0,      r(u, ud, udd, lam) = 0,      psi = Phi_q ud + Phi_t = 0,      B = Phi_q W

    w, ud and udd follow each other by the formulas of the integrator; eta is solved for, to rounding, whenever the equations are
    evaluated. Phi_q in B is that of the last accepted point, and W = diag(magnitude^2) makes corrections of slopes and positions
    comparable. Newton's method sees psi / alpha_v in place of Phi. Its matrix stays [[S, Phi_q^T], [Phi_q, 0]]: the derivative
    of psi / alpha_v is Phi_q plus (Phi_q v)_q / alpha_v, which is of the order of the turn in a step and left out.

    Sources: C. W. Gear, B. Leimkuhler, G. K. Gupta, J. Comput. Appl. Math. 12-13 (1985) 77-90; M. Arnold, O. Bruels, A. Cardona,
    Numer. Math. 129 (2015) 149-179.

    Args:
        equations: the equations of the model.
    """

    def __init__(self, equations: Equations) -> None:
        self.equations, self.magnitude, self.n_motion = equations, equations.magnitude, equations.n_motion

    def begin(self, old: Point, weights: Weights) -> None:
        """Prepare a step from an accepted point."""
        self.alpha_v = weights.alpha_v
        jacobian = self.equations.jacobian(old)
        jacobian.data *= self.magnitude[jacobian.indices] ** 2
        self._directions = jacobian.T
        self._at_old = self._factorised(old)
        self._eta = np.zeros(self.equations.n_lam)
        self._last = np.zeros(0), old.u

    def corrected(self, point: Point) -> Point:
        """The point with w replaced by positions that obey the constraints; NaN where there are none near by."""
        if point.u is self._last[0]:
            return point.moved_to(self._last[1])
        eta, lu, last = self._eta, self._at_old, np.inf
        for _ in range(CORRECTIONS):
            found = point.moved_to(point.u + self._directions @ eta)
            phi = self.equations.position_violation(found)
            size = self.equations.relative(phi)
            if size <= ROUNDING or (size >= 0.5 * last and size <= 1e3 * ROUNDING):
                self._eta, self._last = eta, (point.u, found.u)
                return found
            if not np.isfinite(size) or lu is None:
                break
            if size > SLOW * last:
                lu, size = self._factorised(found), np.inf
                if lu is None:
                    break
            eta, last = eta - lu.solve(phi), size
        return point.moved_to(np.full_like(point.u, np.nan))

    def _factorised(self, point: Point) -> SuperLU | None:
        """Phi_q B^T, the derivative of Phi by eta; None when the constraints depend on each other at a point."""
        try:
            return splu((self.equations.jacobian(point) @ self._directions).tocsc())
        except RuntimeError:
            return None

    def finished(self, point: Point) -> Point:
        """The accepted point: positions as corrected, velocities freed of what Newton's tolerance leaves of psi."""
        found = self.corrected(point)
        lu = self._factorised(found)
        if lu is not None:
            found.ud = found.ud - self._directions @ lu.solve(self.equations.velocity_violation(found))
        return found

    def coordinates(self, point: Point) -> Floats:
        """All coordinates q, shape (n_q,)."""
        return self.equations.coordinates(self.corrected(point))

    def residual(self, point: Point) -> tuple[Floats, Floats]:
        """r (n_u,) and psi / alpha_v (n_lam,)."""
        found = self.corrected(point)
        return self.equations.residual(found)[0], self.equations.velocity_violation(found) / self.alpha_v

    def linearise(self, point: Point, weights: Weights, previous: Floats | None = None) -> tuple[Floats, Floats, Floats, Floats]:
        """r, psi / alpha_v and the values of the matrix and of Phi_q T; see :class:`lamella.assembly.equations.Equations`."""
        found = self.corrected(point)
        r, _, k, j = self.equations.linearise(found, weights, previous)
        return r, self.equations.velocity_violation(found) / self.alpha_v, k, j

    def violation(self, point: Point) -> float:
        """Nothing that Newton's method must wait for: positions hold to rounding, and :meth:`finished` sees to velocities."""
        return 0.0

    def free(self, unknown: int) -> str:
        """An unknown that nothing determines, in words."""
        return self.equations.free(unknown)
