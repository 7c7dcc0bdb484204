"""Statics: equilibrium under full load, and equilibrium paths through limit points."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from lamella.assembly.equations import Equations
from lamella.assembly.point import STATIC, Point
from lamella.errors import ConstraintError, ConvergenceError, DeclarationError, ModelError, ResultFileError, SingularSystemError
from lamella.model import Model
from lamella.progress import ProgressBar, compilation_notice
from lamella.result import Cause, Outcome, Recorder, Result, Sink, Statistics
from lamella.signals import LOAD_FACTOR, system_signals
from lamella.solve.arc_length import ArcLength
from lamella.solve.base import LinearSolver
from lamella.solve.initial import changes, project_positions, refuse_contradiction, refuse_undetermined
from lamella.solve.linear import Method, linear_solver
from lamella.solve.newton import Newton, NewtonSolver
from lamella.system import System

STATIC_NEWTON = Newton(keep=0.0, line_search=True)
"""Newton's method proper: far from the solution a kept factorisation gains nothing."""


def equilibrium(
    system: System | Model,
    *,
    t: float = 0.0,
    steps: Sequence[float] | int = 1,
    newton: Newton = STATIC_NEWTON,
    smallest_step: float = 1e-4,
    sinks: Sequence[Sink] = (),
    progress: bool = False,
    solver: Method = "auto",
    on_failure: str = "raise",
) -> Result:
    """Geometrically nonlinear static equilibrium f(q) = 0 under the loads and support motions at time ``t``.

    Whether it is stable is told by ``result.statistics.negative_pivots`` and in the outcome.

    Loads and motions grow with a load factor from 0 to 1. A step that does not converge is halved, and doubled again after two
    that do; every load factor in ``steps`` is met.

    Args:
        system: what is loaded.
        t: time at which loads and motions are taken [s].
        steps: load factors to solve for, ascending, or a number of equal steps.
        newton: how each step is solved.
        smallest_step: load step below which the solution is given up.
        sinks: receive the solution while it runs.
        progress: show a progress bar.
        solver: name of the linear solver.
        on_failure: ``raise`` or ``return`` the partial result.

    Returns:
        ``result["tip.position"]`` is the value at full load, ``result.history("tip.position")`` over all load steps.

    Raises:
        ConvergenceError: the load cannot be carried, or a limit point was met; :func:`equilibrium_path` passes those.
        ModelError: nothing holds the system, or nothing determines a temperature.
        ConstraintError: constraints contradict each other.
    """
    factors = _checked_steps(steps)
    with compilation_notice(progress):
        run = _Run(system, t, newton, solver)
        run.open(factors[-1], sinks, ProgressBar("statics", 0.0, factors[-1], "", run.statistics) if progress else None)
        outcome = run.guarded(lambda: _climb(run, factors, smallest_step), factors[-1])
    return run.close(outcome, on_failure)


def equilibrium_path(
    system: System | Model,
    *,
    t: float = 0.0,
    until: float = 1.0,
    arc: ArcLength | None = None,
    newton: Newton = STATIC_NEWTON,
    sinks: Sequence[Sink] = (),
    progress: bool = False,
    solver: Method = "auto",
    on_failure: str = "raise",
) -> Result:
    """Follow the equilibrium path by its arc length, through limit points of load (snap-through) and of displacement (snap-back).

    Args:
        system: what is loaded.
        t: time at which loads and motions are taken [s].
        until: load factor at which the path ends, reached exactly.
        arc: step control; see :class:`lamella.solve.arc_length.ArcLength`.
        newton: tolerance and iterations of each step.
        sinks: receive the solution while it runs.
        progress: show a progress bar.
        solver: name of the linear solver.
        on_failure: ``raise`` or ``return`` the partial result.

    Returns:
        Signals over the path, among them ``load_factor``.
    """
    arc = arc or ArcLength()
    with compilation_notice(progress):
        run = _Run(system, t, newton, solver, single=False)
        run.open(until, sinks, ProgressBar("path", 0.0, arc.max_steps, "points", run.statistics) if progress else None)
        outcome = run.guarded(lambda: arc.follow(run.equations, run.newton, run.point, until, run.record, run.statistics), until)
    return run.close(outcome, on_failure)


def _checked_steps(steps: Sequence[float] | int) -> list[float]:
    factors = [float(s) for s in (np.linspace(0.0, 1.0, max(steps, 0) + 1)[1:] if isinstance(steps, int) else steps)]
    if not factors or not np.isfinite(factors).all() or np.any(np.diff([0.0, *factors]) <= 0):
        raise DeclarationError(
            "equilibrium", f"steps = {steps}", "accepted is a positive number of steps or ascending factors above 0"
        )
    return factors


def _climb(run: _Run, factors: Sequence[float], smallest: float) -> Outcome:
    """Meet every factor, with steps cut where Newton fails."""
    largest, good = np.inf, 0
    for target in factors:
        while run.point.factor < target:
            step = min(target - run.point.factor, largest)
            trial = run.point.copy()
            trial.factor = target if step >= 0.999 * (target - run.point.factor) else run.point.factor + step
            report = run.newton.solve(trial, STATIC, run.q)
            if report.converged:
                run.point, good = trial, good + 1
                run.statistics.steps += 1
                run.record(trial)
                if good >= 2 and report.iterations < 10:
                    largest, good = 2.0 * step, 0
                continue
            run.statistics.rejected += 1
            largest, good = 0.5 * step, 0
            if largest < smallest:
                detail = f"load step {step:.1e}; {report.detail}"
                if report.cause is Cause.NOT_CONVERGED:
                    detail += "; the load cannot be carried from here: lower it, or pass a limit point with equilibrium_path"
                return Outcome(report.cause, run.point.factor, factors[-1], detail)
    return Outcome(Cause.COMPLETED, run.point.factor, factors[-1])


class _Run:
    """What both kinds of static solution share: equations, Newton, recording and the end."""

    def __init__(self, system: System | Model, t: float, newton: Newton, solver: Method, *, single: bool = True) -> None:
        self.began = time.perf_counter()
        self.model = system.compile() if isinstance(system, System) else system
        self.model.reset()
        if not self.model.rows and not self.model.constraints:
            raise ModelError(
                "statics: nothing holds the system; add at least one support, for example Clamp(name, plate.edge('x-'))"
            )
        self.equations, self.statistics = Equations(self.model), Statistics()
        linear = linear_solver(self.equations.matrix.pattern, solver)
        self.newton = NewtonSolver(self.equations, linear, newton, self.statistics)
        self.point = self.equations.start(t, factor=0.0, at_rest=True)
        refuse_undetermined(self.equations, self.point)
        self._make_consistent(linear)
        self.axis = "load_factor" if single else "path"

    def _make_consistent(self, linear: LinearSolver) -> None:
        """Meet the constraints by the smallest deformation, and keep what that changed."""
        trial = self.point.copy()
        try:
            project_positions(self.equations, trial, linear, STATIC)
            self.point = trial
        except (ConstraintError, SingularSystemError):
            pass  # Newton's method meets the same with its load steps and line search, and says what is free
        if not self.equations.elimination.moves:  # which are scaled by the load factor, 0 here
            refuse_contradiction(self.equations, self.point, rates=False)
        self.start = changes(self.equations, self.point, self.model.q0, np.zeros(self.model.n_q))

    def open(self, until: float, sinks: Sequence[Sink], bar: ProgressBar | None) -> None:
        """Prepare to record, from the unloaded state on."""
        self.recorder = Recorder(
            [LOAD_FACTOR, *system_signals(self.equations)], self.axis, 0.0, until, sinks=(bar, *sinks) if bar else sinks
        )
        self.q, self.state = self.equations.coordinates(self.point), self.equations.state(self.point)
        self.statistics.seconds_compile = time.perf_counter() - self.began

    def record(self, point: Point) -> None:
        """Take an equilibrium as the state to go on from, and sample it."""
        self.point, self.q = point, self.equations.coordinates(point)
        self.state = self.equations.state(point)
        self.model.settle(self.state)
        count = len(self.recorder.at)
        self.recorder.sample(point.factor if self.axis == "load_factor" else float(count), self.state)

    def guarded(self, solve: Callable[[], Outcome], until: float) -> Outcome:
        """Run a solution; an interruption ends it with what was recorded."""
        try:
            self.record(self.point)
            return solve()
        except KeyboardInterrupt:
            return Outcome(Cause.INTERRUPTED, self.point.factor, until)
        except ResultFileError as error:
            return Outcome(Cause.WRITE_FAILED, self.point.factor, until, str(error))

    def judged(self, outcome: Outcome) -> Outcome:
        """The outcome of a completed solution, with a word of warning when the equilibrium is unstable."""
        if not outcome.completed:
            return outcome
        _, _, k, j = self.equations.linearise(self.point, STATIC)
        try:
            self.newton.linear.factorise(k, j)
        except SingularSystemError:
            return replace(outcome, detail="at a critical point: the stiffness is singular")
        negative = self.newton.linear.negative_pivots or 0
        self.statistics.negative_pivots = negative
        text = f"unstable: the stiffness has {negative} negative eigenvalue{'s' * (negative > 1)}"
        return replace(outcome, detail=text) if negative else outcome

    def close(self, outcome: Outcome, on_failure: str) -> Result:
        """End the recording and give the result, or raise."""
        outcome = replace(self.judged(outcome), start=self.start)
        self.statistics.seconds_run = time.perf_counter() - self.began - self.statistics.seconds_compile
        self.recorder.close(outcome, self.statistics)
        result = Result(self.model, self.recorder, self.state, outcome, self.statistics)
        if outcome.cause is Cause.INTERRUPTED and on_failure == "raise":
            raise KeyboardInterrupt(str(outcome))
        if not outcome.completed and on_failure == "raise":
            raise ConvergenceError(f"the equilibrium {outcome}", outcome, result)
        return result
