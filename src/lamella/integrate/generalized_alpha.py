"""The generalised-alpha method for constrained systems."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, Literal

import numpy as np
from pydantic import Field

from lamella._jit import njit
from lamella.assembly.equations import Equations
from lamella.assembly.point import Point, Weights
from lamella.declaration import declaration
from lamella.integrate.base import Integrator, StepOutcome, Stepper, allowed_growth
from lamella.integrate.change import ChangeSize, refuse_folding
from lamella.integrate.first_order import FirstOrderRule
from lamella.integrate.stabilised import StabilisedEquations
from lamella.integrate.staggered import StaggeredNewton
from lamella.result import Statistics
from lamella.roles import Floats
from lamella.solve.linear import Method, linear_solver
from lamella.solve.newton import Newton, NewtonSolver
from lamella.solve.turned import Vectors
from lamella.units import quantity

if TYPE_CHECKING:
    Step = Longest = Tolerance = float
else:
    Step = quantity("s", gt=0)
    Longest = quantity("s", gt=0, unlimited=True)
    Tolerance = Annotated[float, Field(gt=0, lt=1)]


DYNAMIC_NEWTON = Newton(tolerance=1e-6, max_iterations=50, keep=0.6)
"""A factorisation serves as long as it brings the error down well: an iteration without a new one costs a tenth of one with it.
On swinging plates this takes up to twice the iterations of Newton's method proper, and a third to an eleventh of its
factorisations."""


@declaration
class GeneralizedAlpha(Integrator):
    """Generalised-alpha (Chung and Hulbert 1993) in the form of Arnold and Bruels (2007) for index-3 systems.

        q' = q + dt v + dt^2 ((1/2 - beta) a + beta a'),   v' = v + dt ((1 - gamma) a + gamma a')
        (1 - alpha_m) a' + alpha_m a = (1 - alpha_f) vdot' + alpha_f vdot,   M vdot' + f(t', q', v') + Phi_q^T lam' = 0

    with alpha_m = (2 rho - 1)/(rho + 1), alpha_f = rho/(rho + 1), gamma = 1/2 + alpha_f - alpha_m, beta = (gamma + 1/2)^2/4:
    second order, unconditionally stable for linear problems, with spectral radius rho at infinite frequency. Constraints hold at
    the level of positions, Phi(t', q') = 0 (index 3); ``stabilised`` adds that of velocities, Phi_q v' + Phi_t = 0, by the
    multipliers eta of Gear, Gupta and Leimkuhler (1985; Arnold, Bruels and Cardona 2015):

        q' = q + dt v + dt^2 ((1/2 - beta) a + beta a') + B^T eta

    Temperatures follow their rates by the first-order generalised-alpha method (:class:`~.first_order.FirstOrderRule`); one
    Newton iteration solves for positions, temperatures and multipliers, or two one after the other (``coupling``).

    Args:
        dt: step [s]; the first one under error control.
        rho_inf: spectral radius at infinite frequency, 0 (strong numerical damping) to 1 (none).
        tolerance: root mean square of the local error of displacements allowed in a step, relative to the size of the body;
            None for steps of fixed size.
        dt_min: smallest step a rejected one is cut to [s]; dt / 1024 when left out.
        dt_max: largest step under error control [s]; unlimited when left out.
        newton: how each step is solved.
        stabilised: hold the constraints of positions and of velocities (stabilised index 2); without multipliers it changes
            nothing.
        heat: rule for temperatures: ``generalized_alpha`` with the same ``rho_inf``, or ``central_difference``, the trapezoidal
            rule, which has no numerical damping.
        coupling: ``monolithic``, one iteration for motion and temperatures, or ``staggered``: in each step first the temperatures
            with the predicted motion, then the motion with the new temperatures, one pass each. The predicted motion is off by
            dt^2, which keeps the second order; the matrices are smaller, and symmetric where only the coupling is not. Nothing
            is iterated between the two, so that a strong coupling may need shorter steps. A panel of 7.5 m that turns in the sun
            (tip 0.12 m off the straight line, coupled flux, dt 0.1, 0.05, 0.025 s): the two differ by 1.1e-4, 2.9e-5, 7.7e-6 m,
            where the steps themselves leave 7e-3, 2.4e-3, 1.2e-3 m; staggered steps take 1.1 of the time with
            10 x 1 elements and as long with 20 x 4.
    """

    dt: Step
    rho_inf: Annotated[float, Field(ge=0.0, le=1.0)] = 0.9
    tolerance: Tolerance | None = None
    dt_min: Step = 0.0
    dt_max: Longest = np.inf
    newton: Newton = DYNAMIC_NEWTON
    stabilised: bool = False
    heat: Literal["generalized_alpha", "central_difference"] = "generalized_alpha"
    coupling: Literal["monolithic", "staggered"] = "monolithic"
    type: Literal["generalized_alpha"] = "generalized_alpha"

    def __post_init__(self) -> None:
        if self.dt_min == 0.0:
            object.__setattr__(self, "dt_min", self.dt / 1024)

    def stepper(self, equations: Equations, statistics: Statistics, solver: Method = "auto") -> GeneralizedAlphaStepper:
        """A stepper for these equations."""
        return GeneralizedAlphaStepper(self, equations, statistics, solver)


class GeneralizedAlphaStepper(Stepper):
    """Steps of :class:`GeneralizedAlpha` in independent coordinates; moving supports enter through q, v and vdot exactly."""

    remembered = ("point", "a", "fields", "_smooth")

    def __init__(self, options: GeneralizedAlpha, equations: Equations, statistics: Statistics, solver: Method) -> None:
        self.options, self.equations, self.statistics = options, equations, statistics
        self.alpha_m = (2 * options.rho_inf - 1) / (options.rho_inf + 1)
        self.alpha_f = options.rho_inf / (options.rho_inf + 1)
        self.gamma = 0.5 + self.alpha_f - self.alpha_m
        self.beta = 0.25 * (self.gamma + 0.5) ** 2
        self.stabilised = StabilisedEquations(equations) if options.stabilised and equations.n_lam else None
        self.n = n = equations.n_motion
        form = self.stabilised or equations
        if options.coupling == "staggered" and 0 < n < equations.n_u:
            self.newton = StaggeredNewton(form, equations, options.newton, statistics, solver)
            self.linear = self.newton.linear
        else:
            self.linear = linear_solver(equations.matrix.pattern, solver)
            self.vectors = Vectors(equations)
            self.newton = NewtonSolver(form, self.linear, options.newton, statistics, self.vectors)
        self.fields = FirstOrderRule(1.0 if options.heat == "central_difference" else options.rho_inf)
        self.change = ChangeSize(equations)
        self._per_size = 1.0 / equations.magnitude[:n]
        self._shares = (
            (1 - self.alpha_f) / (1 - self.alpha_m),
            self.alpha_f / (1 - self.alpha_m),
            -self.alpha_m / (1 - self.alpha_m),
        )

    def restart(self, point: Point) -> None:
        """Start from a consistent point: the algorithmic acceleration is the true one."""
        self.point, self.a = point, point.udd.copy()
        self.q = self.equations.coordinates(point)
        self.fields.restart(point.ud[self.n :])
        self.newton.forget()
        self._new: tuple[Point, Floats, Floats, float, bool] | None = None
        self._smooth = False

    def jump(self, point: Point) -> bool:
        """The algorithmic acceleration jumps by as much as the true one, and is otherwise left in peace.

        It is the true one of a time beside that of the point, and in modes much faster than the step it is neither. To begin with
        the true one at each of many samples takes most of the numerical damping away: of an undamped fast mode 0.98 is left from
        one sample to the next instead of 0.81, at rho_inf = 0.9 and two steps a sample. Carried on, it is off by dt times the
        jump of its rate, as the true one would be: once a sample, so that the order stays.
        """
        self.a = self.a + (point.udd - self.point.udd)
        self.fields.jump(point.ud[self.n :] - self.point.ud[self.n :])
        self.point, self._new = point, None
        return False

    def weights(self, dt: float) -> Weights:
        """How the unknown, the new independent coordinates, moves velocities and accelerations."""
        ratio = (1 - self.alpha_m) / (1 - self.alpha_f)
        rate = self.fields.weight(dt) if self.n < self.equations.n_u else 0.0
        return Weights(1.0, self.gamma / (self.beta * dt), ratio / (self.beta * dt**2), rate)

    def step(self, dt: float) -> StepOutcome:
        """Predict, then solve.

        The prediction is that of constant velocity or of constant acceleration, whichever came nearer in the last step. In smooth
        motion the acceleration is worth having: without the centripetal part, a turning plate is predicted stretched. In violent
        motion it holds much of the plate's stiff stretching, which is better not extrapolated.
        """
        old, a, weights = self.point, self.a, self.weights(dt)
        share = dt**2 * (self.beta if self._smooth else self.beta - 0.5)  # du = share a beyond q + dt v + dt^2 (1/2 - beta) a
        factors = (
            dt,
            dt**2 * (0.5 - self.beta) + share,
            dt * (1 - self.gamma) + weights.alpha_v * share,
            self.alpha_m / (1 - self.alpha_f) + weights.alpha_a * share,
            -self.alpha_f / (1 - self.alpha_f),
        )
        new = Point(old.t + dt, np.empty_like(a), np.empty_like(a), np.empty_like(a), old.lam.copy())
        _predict(old.u, old.ud, old.udd, a, *factors, new.u, new.ud, new.udd)
        n = self.n
        if n < len(a):
            new.u[n:], new.ud[n:] = self.fields.predicted(dt, old.u[n:], old.ud[n:])
        if self.stabilised:
            self.stabilised.begin(old, weights)
        report = self.newton.solve(new, weights, self.q)
        if self.stabilised and report.converged:
            new = self.stabilised.finished(new)
        a_new, sizes = np.empty_like(a), (self._per_size, self.change.per_slope)
        smooth, turn = _finish(old.u, old.ud, old.udd, a, new.u, new.udd, dt, *self._shares, *sizes, a_new)
        report = refuse_folding(report, turn)
        if not report.converged:
            self._new = None
            return StepOutcome(report, None)
        s_new = self.fields.algorithmic(old.ud[n:], new.ud[n:])
        self._new = new, a_new, s_new, dt, smooth
        if self.options.tolerance is None:
            return StepOutcome(report, new)
        local = np.concatenate([self._local_error(dt, a_new - a, weights), self.fields.error(dt, s_new)])
        error = self.change.error(local) / self.options.tolerance
        return StepOutcome(report, new, error, allowed_growth(error, 2))

    def _local_error(self, dt: float, change: Floats, weights: Weights) -> Floats:
        """Local error of the coordinates of motion, from the change of the algorithmic acceleration.

        The first term that the update of q leaves out is (beta - 1/6) dt^2 (a' - a) (Zienkiewicz and Xie 1991). In modes much
        faster than the step it is large although they hardly move, so it is filtered by (alpha_a M + K)^-1 alpha_a M, which keeps
        slow modes and shrinks fast ones, as Shampine's filter does for stiff equations (Hairer and Wanner 1996, section IV.8).
        """
        local = (self.beta - 1.0 / 6.0) * dt**2 * change
        inertia = weights.alpha_a * self.equations.inertia_force(local)
        filtered, _ = self.newton.linear.solve(inertia[: self.linear.pattern.n], np.zeros(self.equations.n_lam))
        self.statistics.solves += 1
        return filtered[: self.n]

    def accept(self) -> Point:
        """Make the step final."""
        assert self._new is not None, "accept follows a converged step"
        self._before = self.point
        self.point, self.a, s, dt, self._smooth = self._new
        self.fields.accept(dt, s)
        self.q = self.equations.coordinates(self.point)
        return self.point

    def forget(self) -> None:
        """Drop the factorisation."""
        self.newton.forget()

    def recall(self, memory: dict[str, Any]) -> None:
        """Go on from what was remembered."""
        super().recall(memory)
        self.q, self._new = self.equations.coordinates(self.point), None
        self.forget()

    def between(self, t: float) -> Point:
        """Cubic Hermite interpolation of coordinates, linear of all else: errors of dt^4 and dt^2."""
        old, new = self._before, self.point
        dt = new.t - old.t
        x = (t - old.t) / dt
        y = 1.0 - x
        u = y**2 * (1 + 2 * x) * old.u + x**2 * (1 + 2 * y) * new.u + dt * x * y * (y * old.ud - x * new.ud)
        ud, udd, lam = (y * a + x * b for a, b in ((old.ud, new.ud), (old.udd, new.udd), (old.lam, new.lam)))
        return Point(t, u, ud, udd, lam)


@njit
def _predict(
    u: Floats, ud: Floats, udd: Floats, a: Floats, dt: float, of_q: float, of_v: float, of_a: float, of_old: float,
    q_new: Floats, v_new: Floats, a_new: Floats,
) -> None:  # fmt: skip
    """Coordinates q + dt v, velocities v and accelerations of_old vdot, each with its share of the algorithmic acceleration a."""
    for i in range(len(u)):
        q_new[i] = u[i] + dt * ud[i] + of_q * a[i]
        v_new[i] = ud[i] + of_v * a[i]
        a_new[i] = of_a * a[i] + of_old * udd[i]


@njit
def _finish(
    u: Floats, ud: Floats, udd: Floats, a: Floats, u_new: Floats, udd_new: Floats, dt: float,
    of_new: float, of_old: float, of_a: float, per_size: Floats, per_slope: Floats, a_new: Floats,
) -> tuple[bool, float]:  # fmt: skip
    """The new algorithmic acceleration, from the true one: the difference of positions would divide their rounding by dt^2.

    Returns:
        Whether the prediction with the old one came nearer than that without, and the largest change of a slope.
    """
    for i in range(len(u)):
        a_new[i] = of_new * udd_new[i] + of_old * udd[i] + of_a * a[i]
    with_it = without = turn = 0.0
    for i in range(len(per_size)):
        moved = u_new[i] - u[i] - dt * ud[i]
        with_it += abs(moved - 0.5 * dt**2 * a[i]) * per_size[i]
        without += abs(moved) * per_size[i]
        turn = max(turn, abs((u_new[i] - u[i]) * per_slope[i]))
    return with_it < without, turn
