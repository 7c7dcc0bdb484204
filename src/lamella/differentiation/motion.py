"""Derivatives of a motion: the recursion of generalised-alpha differentiated, step by step along the run."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from copy import copy
from dataclasses import dataclass, replace
from functools import partial
from typing import NamedTuple

import numpy as np

from lamella._jit import kernel, njit
from lamella.assembly.equations import Equations
from lamella.assembly.point import Point, Weights
from lamella.differentiation.exact_matrix import Change, ExactMatrix, Remainder
from lamella.differentiation.neighbours import Neighbours
from lamella.differentiation.parts import moved
from lamella.differentiation.prediction import Prediction
from lamella.differentiation.solution import (
    PointDerivative,
    projected_velocities,
    rates_derivative,
    start_derivative,
)
from lamella.errors import DeclarationError
from lamella.integrate.base import Integrator
from lamella.integrate.generalized_alpha import GeneralizedAlpha, GeneralizedAlphaStepper
from lamella.integrate.staggered import StaggeredNewton
from lamella.motion import March, consistent_start, refuse_spin
from lamella.result import Recorder, Result, Statistics
from lamella.roles import Floats
from lamella.solve.base import LinearSolver
from lamella.solve.linear import Method, linear_solver
from lamella.solve.turned_nodes import NodeTurns
from lamella.state import State

SHARE = 0.1
"""Of the tolerance of Newton's method, which the derivative of a damped motion may lack. With all of it forces across the stiff
direction, which nearly vanish, lose up to a hundred times what Newton's own error takes from them."""
OF_ENERGY = 4.0
"""The same of a motion without damping, for the square root of the energy by the diagonal of M: that error takes as much from it
and more (docs/decisions/0022-gradients.md)."""


class Guess(NamedTuple):
    """What a derivative may be near to, if anything is known, and its energy as far as it is known."""

    du: Floats | None
    energy: float = 0.0


Sample = Callable[[Point, Sequence[PointDerivative]], None]
"""Takes each point of a run with its derivatives."""


@dataclass(frozen=True)
class DifferentiatedAlpha(Integrator):
    """Generalised-alpha that carries derivatives along; the run itself is the same within the tolerance of Newton's method.

    Args:
        options: the method.
        neighbours: of each parameter.
        start: derivatives of the initial state; None for the reference configuration.
        sample: takes each point with its derivatives.
        beside: what the models beside each parameter remember at the start.
        held: the solver that has made the start consistent, with its factorisation.
    """

    options: GeneralizedAlpha
    neighbours: Sequence[Neighbours]
    start: Sequence[PointDerivative] | None
    sample: Sample
    beside: Sequence[Sequence[State]] | None = None
    held: LinearSolver | None = None

    def __post_init__(self) -> None:
        for name in ("dt", "dt_min", "dt_max", "tolerance"):
            object.__setattr__(self, name, getattr(self.options, name))

    def stepper(self, equations: Equations, statistics: Statistics, solver: Method) -> DifferentiatedStepper:
        """A stepper for these equations."""
        return DifferentiatedStepper(self, equations, statistics, solver)


def differentiated_run(
    equations: Equations, method: DifferentiatedAlpha, t_start: float, t_end: float, initial: State | None
) -> Result:
    """Run a motion for its derivatives: what is not sampled with them is not recorded.

    To record all signals would take a fifth of a run and more. Signals that depend on all states are evaluated in each.

    Args:
        equations: what moves.
        method: the integrator.
        t_start, t_end: time at the start and at the end [s].
        initial: state to start from; the reference configuration when left out.

    Raises:
        ModelError: the system is locked, or described in a frame that spins.
        ConstraintError: constraints contradict each other.
    """
    model, statistics = equations.model, Statistics()
    refuse_spin(model, "gradient")
    model.begin(initial)
    equations.forget()
    linear = linear_solver(equations.matrix.pattern)
    point, _ = consistent_start(equations, linear, t_start, initial)
    recorder = Recorder([signal for signal in model.signals if signal.cumulative], "time", t_start, t_end, frames=1)
    march = March(equations, replace(method, held=linear), recorder, statistics, t_end, linear, stride=sys.maxsize)
    march.begin(point)
    outcome = march.run()
    return Result(model, recorder, model.remembering(march.whole()), outcome, statistics)


class DifferentiatedStepper(GeneralizedAlphaStepper):
    """Differentiates each accepted step.

    With the new unknowns u' the step is r(u', v0 + alpha_v u', a0 + alpha_a u', lam'; p) = 0, where v0 and a0 are linear in the
    state before. Its derivative is

        A du' + J^T dlam' = -(dr/dp at u' + D dv0 + M da0),    J du' = -dPhi/dp,    A = K + alpha_v D + alpha_a M

    with the exact matrix A at u', for all parameters by one factorisation, that of the step or of one before
    (:class:`~lamella.differentiation.exact_matrix.ExactMatrix`), and the right-hand side by central differences of residuals at
    u' (:mod:`~lamella.differentiation.difference`). It is solved to a tenth of the tolerance of Newton's
    method: the error in u' moves a derivative by more. Steps keep the lengths that they have. What the estimate by constant
    acceleration was off by in the last steps tells how far it is off now, where motion is damped
    (:class:`~lamella.differentiation.prediction.Prediction`).

    Where it is not, a derivative is measured by its energy, and what a step lacks, b - A du', is added to the b of the next: a
    force that a slow vibration would answer to hundreds of times is followed by its opposite. The estimate alone is near by
    energy, most of which is inertia. The derivative by a parameter that moves places is measured beside that of the start, turned
    with the nodes of the plates: a length stretches the membrane wherever it is. Newton's method goes on with a matrix that the
    derivatives have factorised; where they do with its own, the run is the same to the last digit.
    """

    def __init__(self, made: DifferentiatedAlpha, equations: Equations, statistics: Statistics, solver: Method) -> None:
        super().__init__(made.options, equations, statistics, solver)
        newton = self.newton
        if self.stabilised is not None or isinstance(newton, StaggeredNewton):
            problem = "the derivatives of a motion with 'stabilised' or with coupling 'staggered' are not available"
            raise DeclarationError("gradient", problem, "accepted is generalized_alpha without them")
        self.neighbours, self.given, self.sample, self.beside = made.neighbours, made.start, made.sample, made.beside
        self.held = made.held
        self.matrix = ExactMatrix(equations, newton.linear)
        self._tolerance = made.options.newton.tolerance
        self._adopt, self._turn_to = newton.adopt, newton.turn_to
        newton.patience = int(self.linear.pattern.symmetric and equations.is_exact)  # undamped, derivatives renew the matrix
        self.derivatives: list[PointDerivative] = []
        self._predictions = [Prediction(equations.magnitude) for _ in self.neighbours]
        nodes = self.vectors.nodes
        self._turns = NodeTurns(nodes) if nodes is not None and len(nodes.slopes) else None
        self._at_first: list[Floats | None] = []
        self._done = statistics.newton_iterations, statistics.factorisations
        self._owed: list[Remainder | None] = []
        self._owed_for: Weights | None = None
        self._none = np.zeros(equations.n_u)

    def restart(self, point: Point) -> None:
        """As the method does; at the start of a run the derivatives are those of the initial state."""
        first = not self.derivatives
        before = point if first else self.point
        super().restart(point)
        if first:
            for k, each in enumerate(self.neighbours):
                each.begin(None if self.beside is None else self.beside[k])
            given = self.given or [None] * len(self.neighbours)
            self.derivatives = [
                start_derivative(*pair) for pair in zip(self.neighbours, [point] * len(given), given, strict=True)
            ]
        else:
            self.derivatives = projected_velocities(self.matrix, before, point, self.neighbours, self.derivatives)
        self.derivatives = rates_derivative(self.matrix, point, self.neighbours, self.derivatives, self.held if first else None)
        for each in self._predictions:
            each.forget()
        self._owed = []
        self._algorithmic = [each.udd.copy() for each in self.derivatives]
        self._rules = [copy(self.fields) for _ in self.derivatives]
        for rule, each in zip(self._rules, self.derivatives, strict=True):
            rule.restart(each.ud[self.n :])
        if first:
            self._at_first = [each.u if each.u.any() else None for each in self.derivatives]
            if self._turns is not None:
                self._turns.begin(point.u)
            self._take_note(point)

    def accept(self) -> Point:
        """Make the step final, and differentiate it."""
        assert self._new is not None, "accept follows a converged step"
        dt = self._new[3]
        point = super().accept()
        weights = self.weights(dt)
        if self._turn_to(point, weights):
            self.matrix.follow(point, weights, self._iterations())
        else:
            self.matrix.factorise(point, weights)
        n, alpha_m, alpha_f = self.n, self.alpha_m, self.alpha_f
        shares = (
            dt,
            dt**2 * (0.5 - self.beta),
            dt * (1 - self.gamma),
            alpha_m / (1 - alpha_f),
            -alpha_f / (1 - alpha_f),
            weights.alpha_v,
            weights.alpha_a,
        )
        rates = []
        for old, a, rule in zip(self.derivatives, self._algorithmic, self._rules, strict=True):
            base, ud0, udd0 = np.empty_like(a), np.empty_like(a), np.empty_like(a)
            _carried(old.u, old.ud, old.udd, a, *shares, base, ud0, udd0)
            if n < len(a):
                value, rate = rule.predicted(dt, old.u[n:], old.ud[n:])
                ud0[n:], udd0[n:] = rate - weights.rate * value, 0.0
            rates.append((base, ud0, udd0))
        owed = self._paid(weights)
        guesses = self._guesses([base for base, *_ in rates], owed, point, weights)
        parts = zip(self.neighbours, rates, guesses, owed, strict=True)
        changes = [self._change(*each, point, weights) for each in parts]
        for k, ((du, dlam), (base, ud, udd)) in enumerate(zip(self.matrix.solve_each(changes), rates, strict=True)):
            if (lacking := owed[k]) is not None:
                du = du - lacking.left
            self._predictions[k].learn(base, du)
            old, a, rule, a_new = self.derivatives[k], self._algorithmic[k], self._rules[k], np.empty_like(du)
            _renewed(du, old.udd, a, n, weights.alpha_v, weights.rate, weights.alpha_a, *self._shares, ud, udd, a_new)
            self.derivatives[k], self._algorithmic[k] = PointDerivative(du, ud, udd, dlam), a_new
            if n < len(a):
                rule.accept(dt, rule.algorithmic(old.ud[n:], ud[n:]))
        self._owed, self._owed_for = self.matrix.remainders, weights
        if self.matrix.renewed is not None:
            self._adopt(self.matrix.renewed, point, weights)
        self._take_note(point)
        return point

    def _iterations(self) -> int:
        """Iterations since the last step by the factorisation at hand; none where Newton's method has made one of its own."""
        (iterations, factorisations), self._done = self._done, (self.statistics.newton_iterations, self.statistics.factorisations)
        return self._done[0] - iterations if self._done[1] == factorisations else 0

    def _paid(self, weights: Weights) -> list[Remainder | None]:
        """What the last step lacks and this one makes up for: nothing after a step of another length, with another matrix."""
        owed, paid = self._owed, self._owed_for == weights
        return owed if owed and paid else [None] * len(self.neighbours)

    def _change(
        self,
        neighbours: Neighbours,
        rates: tuple[Floats, Floats, Floats],
        guess: Guess,
        owed: Remainder | None,
        point: Point,
        weights: Weights,
    ) -> Change:
        """What a parameter changes, along the guess where that costs less than a product of its own."""
        (_, ud, udd), parts, (du, energy) = rates, neighbours.parts, guess
        if du is None or parts is None or not (parts.follows or self.equations.multiplies):
            found = Change(*neighbours.residual(point, ud, udd), du, energy=energy)
        elif parts.follows:
            ahead = self.matrix.ahead(point, weights)
            found = Change(*parts.along(point, ud, udd, du, weights, ahead), du, along=True, energy=energy)
        else:
            r, s, a = parts.apart(point, ud, udd)
            found = Change(r, s, du, False, moved(udd if a is None else a, weights.alpha_a, du), energy)
        if owed is not None:
            np.subtract(found.r, owed.force, out=found.r)
        return found

    def _guesses(self, bases: Sequence[Floats], owed: Sequence[Remainder | None], point: Point, weights: Weights) -> list[Guess]:
        """What derivatives may be near to. Chooses how they are measured, and how much they may lack.

        Where motion is damped they are predicted. Where it is not, the estimate is near in energy. By energy the derivative by a
        parameter that moves places is all stretch of the membrane: it is measured beside that of the start.

        Args:
            bases: the estimates by constant acceleration.
            owed: what the last step lacks.
            point, weights: of the end of the step.
        """
        matrix, unsteady = self.matrix, all(prediction.unsteady for prediction in self._predictions)
        matrix.enough = (1.0 if unsteady else SHARE) * self._tolerance
        if matrix.direct:
            return [Guess(None)] * len(bases)
        guesses = [prediction.guess(base) for prediction, base in zip(self._predictions, bases, strict=True)]
        if any(guess is not None for guess in guesses):
            matrix.measure_by_energy(False)
            return [Guess(guess) for guess in guesses]
        starts = [self._from_first(k, point) for k in range(len(bases))]
        by_energy = all((one is None) == (other is None) for one, other in zip(starts, self._at_first, strict=True))
        if not matrix.measure_by_energy(by_energy):
            return [Guess(start) for start in starts]
        matrix.enough = OF_ENERGY * self._tolerance
        return [self._near(*each, weights) for each in zip(bases, starts, owed, strict=True)]

    def _near(self, base: Floats, start: Floats | None, owed: Remainder | None, weights: Weights) -> Guess:
        """The estimate, with what is owed; its energy beside the start, nearly all of which is inertia."""
        none, du = self._none, np.empty_like(base)
        beside, more = none if start is None else start, none if owed is None else owed.left
        return Guess(du, weights.alpha_a * _sum_with_energy(base, beside, more, self.equations.mass.diagonal, du))

    def _from_first(self, k: int, point: Point) -> Floats | None:
        """What the derivative by parameter number k may be near to, from that at the start, if it moves places."""
        at_first = self._at_first[k]
        if at_first is None or self._turns is None:
            return None
        self._turns.turn(point.u)
        return self._turns.forth(at_first)

    def _take_note(self, point: Point) -> None:
        self.sample(point, self.derivatives)
        for each, derivative in zip(self.neighbours, self.derivatives, strict=True):
            each.settle(partial(derivative.moved, point))


@kernel
def _sum_with_energy(base: Floats, start: Floats, more: Floats, masses: Floats, du: Floats) -> float:
    """base + more, and the sum of masses times (base - start)^2."""
    energy = 0.0
    for i in range(len(base)):
        du[i] = base[i] + more[i]
        energy += masses[i] * (base[i] - start[i]) ** 2
    return energy


@njit
def _carried(
    u: Floats, ud: Floats, udd: Floats, a: Floats,
    dt: float, of_q: float, of_v: float, of_a: float, of_old: float, alpha_v: float, alpha_a: float,
    base: Floats, ud0: Floats, udd0: Floats,
) -> None:  # fmt: skip
    """Coordinates q + dt v + of_q a, and what velocities and accelerations would be if the new coordinates were zero."""
    for i in range(len(u)):
        base[i] = u[i] + dt * ud[i] + of_q * a[i]
        ud0[i] = ud[i] + of_v * a[i] - alpha_v * base[i]
        udd0[i] = of_a * a[i] + of_old * udd[i] - alpha_a * base[i]


@njit
def _renewed(
    u: Floats, udd_old: Floats, a: Floats, n: int, alpha_v: float, rate: float, alpha_a: float,
    of_new: float, of_old: float, of_a: float, ud: Floats, udd: Floats, a_new: Floats,
) -> None:  # fmt: skip
    """Add to velocities and accelerations what the coordinates, of which ``n`` are of motion, give; the algorithmic ones."""
    for i in range(len(u)):
        ud[i] += (alpha_v if i < n else rate) * u[i]
        udd[i] = udd[i] + alpha_a * u[i] if i < n else 0.0
        a_new[i] = of_new * udd[i] + of_old * udd_old[i] + of_a * a[i]
