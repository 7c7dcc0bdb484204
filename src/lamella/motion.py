"""Motion: integrate a system in time."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from lamella.accepted import EQUATIONS, FAILURE, SINKS, SOLVER, STATE
from lamella.arguments import REAL, WHOLE, accepts, instance, optional
from lamella.assembly.equations import Equations
from lamella.assembly.point import Point
from lamella.compilation import compilation_notice
from lamella.ended_early import error_of
from lamella.errors import DeclarationError, FunctionError, ModelError, ResultFileError
from lamella.integrate.base import Integrator, StepOutcome, Stepper
from lamella.integrate.events import EventWatch
from lamella.integrate.sampling import Sampling
from lamella.model import Model
from lamella.progress import ProgressBar
from lamella.result import Cause, Outcome, Recorder, Result, Sink, Start, Statistics
from lamella.signals import system_signals
from lamella.solve.base import LinearSolver
from lamella.solve.initial import balance, changes, make_consistent, refuse_locked, solve_rates, start_of, with_jump
from lamella.solve.linear import Method, linear_solver
from lamella.state import LateState, State
from lamella.system import System

GROWN = 0.05
"""Share of the largest energy by which the balance may end above zero before the outcome warns; sums over long steps err too."""
BEFORE_JUMP = 1e-9
"""Share of the step by which the last one before a jump stays short of it, so that it does not feel what begins there."""
VIOLATED = 1e-6
"""Violation of a constraint, relative to the size of the bodies, that is no rounding of the constraints it follows from."""
HARD = 12
"""Newton iterations after which a step does not grow: a longer one would take more still, or fail."""
WAIT = 10
"""Steps for which the step does not grow after Newton's method has failed; else it is tried again at once."""
KEEP_STEP = 1.2
"""Growth below which a step keeps its size, and with it the factorisation."""


@accepts(
    system=EQUATIONS,
    t_end=REAL,
    integrator=instance("an integrator such as GeneralizedAlpha(dt=1e-3)", Integrator),
    t_start=REAL,
    initial=STATE,
    frames=WHOLE,
    every=optional(REAL),
    stride=WHOLE,
    sinks=SINKS,
    solver=SOLVER,
    on_failure=FAILURE,
)
def simulate(
    system: System | Model | Equations,
    t_end: float,
    integrator: Integrator,
    *,
    t_start: float = 0.0,
    initial: State | None = None,
    frames: int = 100,
    every: float | None = None,
    stride: int = 1,
    sinks: Sequence[Sink] = (),
    progress: bool = False,
    solver: Method = "auto",
    on_failure: str = "raise",
) -> Result:
    """Integrate the equations of motion from a consistent start.

    Args:
        system: what moves; a :class:`System` is compiled first, and equations that exist already are taken as they are.
        t_end: end time [s].
        integrator: for example ``GeneralizedAlpha(dt=1e-3, rho_inf=0.9)``.
        t_start: time of the initial state [s].
        initial: state to start from, for example ``equilibrium(...).final``; the reference otherwise. What it remembers beside
            positions and velocities goes on: where bristles hold, turns of joints, latches, switched forces, controllers.
        frames: number of equally spaced configurations kept for pictures.
        every: record at multiples of this interval [s] too, besides the steps: interpolated with the order of the method, so
            that long steps give smooth curves. Positions, velocities and accelerations are as accurate as those of the steps.
        stride: record every so manyth step, the last, and those that end at a multiple of ``every``, so that a large one records
            nothing else; work and heat are summed over all. Recording some hundred signals may cost as much as a step does.
        sinks: receive the solution while it runs, for example a result file.
        progress: show a progress bar with the time to go.
        solver: name of the linear solver, see :func:`lamella.solve.linear.linear_solver`.
        on_failure: ``raise`` a :class:`ConvergenceError` that holds the partial result, or ``return`` it with its outcome.

    Returns:
        Signals over time, frames, statistics and outcome.

    Raises:
        ConvergenceError: the smallest step did not converge.
        FunctionError: a control law or force in Python raised an error; it holds the partial result too.
        ConstraintError: constraints contradict each other.
        ModelError: joints lock the system, or it is described in a frame that spins.
    """
    if not math.isfinite(t_start):
        raise DeclarationError("simulate", f"t_start = {t_start}", "accepted is a finite time [s]")
    if not t_start < t_end < math.inf:
        raise DeclarationError("simulate", f"t_end = {t_end}", f"accepted is a finite time later than t_start = {t_start:g} s")
    if every is not None and not every > 0.0:
        raise DeclarationError("simulate", f"every = {every}", "accepted is a positive interval [s], or None for the steps alone")
    if frames < 0:
        raise DeclarationError("simulate", f"frames = {frames}", "accepted is a number of configurations, 0 or more")
    if stride < 1:
        raise DeclarationError("simulate", f"stride = {stride}", "accepted is a number of steps, 1 or more")
    began = time.perf_counter()
    with compilation_notice(progress):
        made = system.compile() if isinstance(system, System) else system
        model = made.model if isinstance(made, Equations) else made
        refuse_spin(model, "simulate")
        model.begin(initial)
        equations, statistics = made if isinstance(made, Equations) else Equations(model), Statistics()
        equations.forget()
        linear = linear_solver(equations.matrix.pattern, solver)
        point, start = consistent_start(equations, linear, t_start, initial)
        if progress:
            sinks = (ProgressBar("motion", t_start, t_end, statistics=statistics), *sinks)
        recorder = Recorder(system_signals(equations), "time", t_start, t_end, frames, sinks)
        march = March(equations, integrator, recorder, statistics, t_end, linear, solver, every, stride)
        march.begin(point)
        statistics.seconds_compile = time.perf_counter() - began
        ended = replace(march.run(), start=start)
        final = model.remembering(march.whole())  # an interruption may come behind a step that is not recorded
        outcome = replace(_judged(ended, equations, final, recorder), final=final)
    statistics.seconds_run = time.perf_counter() - began - statistics.seconds_compile
    recorder.close(outcome, statistics)
    result = Result(model, recorder, final, outcome, statistics)
    if not outcome.completed and on_failure == "raise":
        raise error_of(result, f"the motion {outcome}")
    return result


def refuse_spin(model: Model, item: str) -> None:
    """Refuse a system that is described in a frame that spins.

    Raises:
        ModelError: it is; the message begins with ``item``.
    """
    if model.spin is not None:
        raise ModelError(
            f"{item}: the system is described in a frame that spins (SteadySpin), where motion is not available; "
            "accepted is a system in the inertial frame, driven for example by an AngleDrive"
        )


def consistent_start(equations: Equations, linear: LinearSolver, t: float, initial: State | None) -> tuple[Point, Start]:
    """The consistent point nearest to a state, the reference configuration when left out, and what had to be changed."""
    model = equations.model
    point = start_of(equations, t, initial)
    make_consistent(equations, point, linear)
    refuse_locked(equations)
    if initial is not None:
        return point, changes(equations, point, initial.q, initial.v)
    start = changes(equations, point, model.q0, model.v0)
    return point, replace(start, left_out=(*start.left_out, *model.beginnings))


def _judged(outcome: Outcome, equations: Equations, final: State, recorder: Recorder) -> Outcome:
    """The outcome with words of warning: energy that has grown, and constraints left out at the start that are violated now."""
    if not outcome.completed:
        return outcome
    warnings = [outcome.detail] if outcome.detail else []
    found = equations.left_out(equations.point_of(final, final.t), VIOLATED)
    if found:
        warnings.append(f"left out as redundant in what was a singular position, and violated at the end: {found}")
    samples = recorder.samples()
    kinetic, strain, balance = (samples[f"energy.{name}"][:, 0] for name in ("kinetic", "strain", "balance"))
    grown, size = float(balance[-1]), float(np.max(np.abs(kinetic) + np.abs(strain)))
    if grown > GROWN * size:
        advice = "take a shorter step, a smaller rho_inf, or the stabilised form"
        warnings.append(f"energy has grown by {grown:.2g} J beside {size:.2g} J: {advice}")
    return replace(outcome, detail="; ".join(warnings))


class March:
    """The loop over time: step size, rejection, stops at breakpoints, recording.

    ``dt`` is the step to go on with [s], None after a restart. The arguments are those of :func:`simulate`.
    """

    def __init__(
        self,
        equations: Equations,
        integrator: Integrator,
        recorder: Recorder,
        statistics: Statistics,
        t_end: float,
        linear: LinearSolver,
        solver: Method = "auto",
        every: float | None = None,
        stride: int = 1,
    ) -> None:
        self.equations, self.integrator = equations, integrator
        self.stepper: Stepper = integrator.stepper(equations, statistics, solver)
        self.recorder, self.statistics, self.t_end, self.linear = recorder, statistics, t_end, linear
        self.every, self.stride = every, stride
        self._asked = 1
        """Number of the next time to record, in multiples of ``every`` from the start."""
        self.point: Point | None = None
        self.watch = EventWatch(equations, equations.model.triggers, recorder.signals)
        self.sampling = Sampling(equations.model.samplers, recorder.signals, recorder.start)

    def begin(self, point: Point) -> None:
        """Start from a consistent point."""
        self.t, self.state, self.dt = point.t, self.equations.state(point), None
        self.equations.model.settle(self.state)
        self.stepper.restart(point)
        self.watch.begin(self.state)

    def run(self) -> Outcome:
        """Step to the end; whatever happens, what was recorded stays valid."""
        outcome = self._run()
        if outcome.cause is not Cause.WRITE_FAILED:
            self.recorder.finish(self.t, self.whole())
        return replace(outcome, events=tuple(self.watch.happened)) if self.watch.happened else outcome

    def _run(self) -> Outcome:
        jumps = [s for s in self.equations.model.breakpoints if self.t < s < self.t_end] + [self.t_end]
        try:
            self.recorder.sample(self.t, self.state)
            self.control(None)
            while jumps:
                before = self.t
                stop = min(jumps[0], self.sampling.next(self.t, jumps[0]))
                jumping = stop in self.equations.model.breakpoints  # also at the end, which does not feel what would begin
                failure = self.advance(stop, jumping)
                if failure is not None:
                    return failure
                if stop == jumps[0]:
                    jumps = jumps[1:]
                if stop < self.t_end:
                    if jumping:
                        self.restart()
                    self.control(before)
        except KeyboardInterrupt:
            return Outcome(Cause.INTERRUPTED, self.t, self.t_end)
        except ResultFileError as error:
            return Outcome(Cause.WRITE_FAILED, self.t, self.t_end, str(error))
        except FunctionError as error:
            return Outcome(Cause.FUNCTION_FAILED, self.t, self.t_end, str(error), error=error)
        return Outcome(Cause.COMPLETED, self.t, self.t_end)

    def advance(self, stop: float, jumping: bool) -> Outcome | None:
        """Step to a time; ``jumping`` says that something jumps there. The outcome when it is not reached."""
        dt = self.stepper.first_step(self.integrator.dt) if self.dt is None else self.dt
        wait = 0
        span = self.t_end - self.recorder.start  # of which a first step may be many times
        while self.t < stop - 1e-9 * min(dt, span):
            remaining = stop - self.t
            count = max(1, math.ceil(remaining / dt - 1e-6)) if remaining < 2.0 * dt else 0
            trial = remaining / count if count else dt
            if count == 1 and jumping:
                trial *= 1.0 - BEFORE_JUMP
            outcome = self.stepper.step(trial)
            adaptive = self.integrator.tolerance is not None
            if outcome.point is None or (adaptive and outcome.error > 1.0):
                self.statistics.rejected += 1
                dt = trial * (0.5 if outcome.point is None else outcome.growth)
                wait = WAIT if outcome.point is None else wait
                if dt < self.integrator.dt_min:
                    if self.recorder.at[-1] < self.t:
                        self.recorder.sample(self.t, self.whole())
                    return self._given_up(trial, outcome)
                continue
            outcome, length, triggers = self.watch.locate(self.stepper, outcome, trial, self.t)
            point = self.stepper.accept()
            self.statistics.steps += 1
            due = self._sample_between(self.t, point.t)
            self.t = stop if count == 1 and length == trial else point.t
            recorded = self.statistics.steps % self.stride == 0 or due or bool(triggers) or self.t >= self.t_end
            self.point = point
            self.state = self.equations.state(point) if recorded else self.equations.late_state(point)
            self.equations.model.settle(self.state)
            if recorded:
                self.recorder.sample(self.t, self.state)
            else:
                self.recorder.pass_over(self.state)
            if adaptive:
                factor = min(outcome.growth, 1.0) if wait or outcome.report.iterations > HARD else outcome.growth
                wait = max(wait - 1, 0)
                dt = min(trial * factor, self.integrator.dt_max) if not 1.0 <= factor < KEEP_STEP else max(trial, dt)
            elif dt < self.integrator.dt:
                dt = min(outcome.growth * dt, self.integrator.dt)  # a step cut after a failure grows back
            if triggers:
                for trigger in triggers:
                    if trigger.act is not None:
                        trigger.act()
                ending = [trigger.text for trigger in triggers if trigger.stops]
                if ending:
                    return Outcome(Cause.EVENT, self.t, self.t_end, ending[0])
                self.restart()
                dt = self.stepper.first_step(dt)
        self.t, self.dt = stop, dt  # also where so little was left that no step was made: who asks again would wait for ever
        return None

    def _sample_between(self, before: float, after: float) -> bool:
        """Record at the times asked for within the step just accepted; whether its end is one, which is left to the step."""
        if self.every is None:
            return False
        close = 1e-9 * (after - before)
        while (t := self.recorder.start + self.every * self._asked) < after - close:
            self.recorder.sample(t, self.equations.state(self.stepper.between(t)))
            self._asked += 1
        due = t <= after + close
        self._asked += due
        return due

    def _given_up(self, dt: float, outcome: StepOutcome) -> Outcome:
        """The end at the smallest step, by Newton or by the error estimate."""
        cause, detail = outcome.report.cause, outcome.report.detail
        if outcome.point is not None:
            cause, detail = Cause.INACCURATE, f"error {outcome.error:.1e} times the tolerance"
        return Outcome(cause, self.t, self.t_end, f"step {dt:.1e} s; {detail}")

    def control(self, before: float | None) -> None:
        """Let controllers act whose time has come since ``before`` [s], None at the start; both sides of it are recorded."""
        if self.sampling.due(self.t, before):
            self.jump(lambda: self.sampling.act(self.t, before, self.whole()))

    def jump(self, change: Callable[[], None]) -> None:
        """Let inputs jump: places and velocities go on, and accelerations and multipliers jump with them; record that."""
        point = self.equations.point_of(self.state, self.t)
        before = balance(self.equations, point)
        change()
        point = with_jump(self.equations, point, before, self.linear)
        self.state = self.equations.state(point)
        if self.stepper.jump(point):
            self.dt = None
        self.recorder.sample(self.t, self.state)

    def whole(self) -> State:
        """The present state with what a step that is not recorded leaves out."""
        if self.point is not None and isinstance(self.state, LateState):
            self.state = self.equations.state(self.point)
        return self.state

    def restart(self) -> None:
        """After a jump of a load, whose work goes on from there: velocities go on, accelerations and multipliers solved anew."""
        point = self.equations.point_of(self.state, self.t)
        solve_rates(self.equations, point, self.linear)
        self.state = self.equations.state(point)
        self.recorder.pass_over(self.state)
        self.stepper.restart(point)
        self.dt = None
