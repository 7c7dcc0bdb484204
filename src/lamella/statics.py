"""Statics: equilibrium under load or over time, and equilibrium paths through limit points and bifurcations."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import pairwise
from math import isfinite

import numpy as np

from lamella.accepted import EQUATIONS, FAILURE, SINKS, SOLVER, SYSTEM
from lamella.arguments import REAL, WHOLE, accepts, either, instance, numbers, optional
from lamella.assembly.equations import Equations
from lamella.assembly.point import STATIC, Point
from lamella.compilation import compilation_notice
from lamella.critical import Branch
from lamella.errors import DeclarationError, ModelError
from lamella.model import Model
from lamella.progress import ProgressBar
from lamella.result import Cause, Outcome, Result, Sink
from lamella.roles import Floats
from lamella.solve.arc_length import ArcLength
from lamella.solve.bordered import BorderedNewton
from lamella.solve.displacement_control import DisplacementControl
from lamella.solve.linear import Method
from lamella.solve.newton import Newton
from lamella.static_run import StaticRun
from lamella.system import System

STATIC_NEWTON = Newton(keep=0.0, line_search=True)
"""Newton's method proper: far from the solution a kept factorisation gains nothing."""
BRANCH_ITERATIONS = 30
"""Newton's iterations allowed onto a branch, whose first point is guessed along the null vector."""

STATIC_ARGUMENTS = {
    "t": REAL,
    "imperfection": optional(instance("an array with a number for each coordinate", np.ndarray)),
    "newton": instance("Newton(...)", Newton),
    "sinks": SINKS,
    "solver": SOLVER,
    "on_failure": FAILURE,
}


@accepts(
    system=EQUATIONS,
    steps=either(WHOLE, numbers("ascending numbers")),
    times=optional(numbers("ascending numbers")),
    smallest_step=REAL,
    **STATIC_ARGUMENTS,
)
def equilibrium(
    system: System | Model | Equations,
    *,
    t: float = 0.0,
    steps: Sequence[float] | int = 1,
    times: Sequence[float] | None = None,
    imperfection: Floats | None = None,
    newton: Newton = STATIC_NEWTON,
    smallest_step: float = 1e-4,
    sinks: Sequence[Sink] = (),
    progress: bool = False,
    solver: Method = "auto",
    on_failure: str = "raise",
) -> Result:
    """Geometrically nonlinear static equilibrium f(q) = 0 under the loads and support motions at time ``t``.

    Whether it is stable is told by ``result.statistics.negative_pivots`` and in the outcome; where the stiffness became singular
    on the way by ``result.critical_points``.

    Loads and motions grow with a load factor from 0 to 1. A step that does not converge is halved, and doubled again after two
    that do; every load factor in ``steps`` is met. With ``times`` the loads then follow their profiles, one equilibrium after
    another: loads with different profiles are applied one after the other.

    Args:
        system: what is loaded; of equations that exist already, those are solved.
        t: time at which loads and motions are taken [s].
        steps: load factors to solve for, ascending, or a number of equal steps.
        times: ascending times [s]: after the load steps to the first of them, the result is over time; ``t`` is not used.
        imperfection: added to the stress-free geometry, such as ``modes.imperfection(0, 1e-4)``, shape (n_q,).
        newton: how each step is solved.
        smallest_step: step, as a share of the load or of the time from first to last, below which the solution is given up.
        sinks: receive the solution while it runs.
        progress: show a progress bar.
        solver: name of the linear solver.
        on_failure: ``raise`` or ``return`` the partial result.

    Returns:
        ``result["tip.position"]`` is the value at full load, ``result.history("tip.position")`` over all load steps or times.

    Raises:
        ConvergenceError: the load cannot be carried, or a limit point was met; :func:`equilibrium_path` passes those.
        ModelError: nothing holds the system, or nothing determines a temperature.
        ConstraintError: constraints contradict each other.
        DeclarationError: impossible ``steps`` or ``times``, or an imperfection that does not fit the system.
    """
    factors, instants = _checked_steps(steps), None if times is None else _checked_times(times)
    if instants is None:
        with compilation_notice(progress):
            run = StaticRun(system, t, newton, solver, "load_factor", imperfection)
            end = factors[-1]
            run.open(0.0, end, sinks, ProgressBar("statics", 0.0, end, "", run.statistics) if progress else None)
            outcome = run.guarded(lambda: _climb(run, _set_factor, run.point.factor, factors, smallest_step, run.record), end)
        return run.close(outcome, on_failure)
    with compilation_notice(progress):
        run = StaticRun(system, instants[0], newton, solver, "time", imperfection)
        first, last = instants[0], instants[-1]
        run.open(first, last, sinks, ProgressBar("statics", first, last, "s", run.statistics) if progress else None)
        loaded = _climb(run, _set_factor, 0.0, [1.0], smallest_step, run.take)
        if loaded.completed:
            smallest = smallest_step * (last - first)
            outcome = run.guarded(lambda: _climb(run, _set_time, first, instants[1:], smallest, run.record), last)
        else:
            detail = (
                f"the loads of the first time, {first:g} s, were reached by a factor of {loaded.reached:g} only; {loaded.detail}"
            )
            outcome = run.guarded(lambda: replace(loaded, reached=first, target=last, detail=detail), last)
    return run.close(outcome, on_failure)


@accepts(
    system=SYSTEM,
    until=optional(REAL),
    arc=optional(instance("ArcLength(...)", ArcLength)),
    control=optional(instance("DisplacementControl(...)", DisplacementControl)),
    branch=optional(instance("a branch of a critical point", Branch)),
    **STATIC_ARGUMENTS,
)
def equilibrium_path(
    system: System | Model,
    *,
    t: float = 0.0,
    until: float | None = None,
    arc: ArcLength | None = None,
    control: DisplacementControl | None = None,
    imperfection: Floats | None = None,
    branch: Branch | None = None,
    newton: Newton = STATIC_NEWTON,
    sinks: Sequence[Sink] = (),
    progress: bool = False,
    solver: Method = "auto",
    on_failure: str = "raise",
) -> Result:
    """Follow the equilibrium path by its arc length, through limit points of load (snap-through) and of displacement (snap-back).

    Critical points on the way are found: ``result.critical_points``. A path stays on its branch at a bifurcation; an
    imperfection, or a begin on a ``branch``, leads onto the other.

    Args:
        system: what is loaded.
        t: time at which loads and motions are taken [s].
        until: load factor at which the path ends, reached exactly; 1 when left out.
        arc: step control; see :class:`lamella.solve.arc_length.ArcLength`.
        control: follow the path by a displacement instead, to the displacement it names.
        imperfection: added to the stress-free geometry, such as ``buckling(system).imperfection(0, 1e-4)``, shape (n_q,).
        branch: begin at a bifurcation of an earlier path of the same system, such as
            ``path.critical_points[0].branch(1e-3)``, on the path that leaves it.
        newton: tolerance and iterations of each step.
        sinks: receive the solution while it runs.
        progress: show a progress bar.
        solver: name of the linear solver.
        on_failure: ``raise`` or ``return`` the partial result.

    Returns:
        Signals over the path, among them ``load_factor``.

    Raises:
        ConvergenceError: the path could not be followed to its end; the message says where and why.
        DeclarationError: arguments that exclude each other or do not fit the system.
        ModelError: nothing holds the system, or nothing deforms it.
    """
    _check_path(until, arc, control, branch)
    arc, end = arc or ArcLength(), 1.0 if until is None else until
    with compilation_notice(progress):
        run = StaticRun(system, t, newton, solver, "path", imperfection)
        if branch is not None:
            run.point = _critical(run, branch)
        else:
            run.relax()
            if control is None and not run.equations.load_direction(run.point).any():
                raise ModelError(
                    "equilibrium_path: nothing deforms as the load factor grows; accepted are loads or moving supports that "
                    "deform the system, or equilibrium(system) where there are none"
                )
        run.open(0.0, end, sinks, ProgressBar("path", 0.0, arc.max_steps, "points", run.statistics) if progress else None)
        bordered = BorderedNewton(run.equations, run.newton, run.statistics)

        def follow() -> Outcome:
            if control is not None:
                return control.follow(bordered, run.point, run.record)
            if branch is None:
                return arc.follow(bordered, run.point, end, run.follow)
            start, first = run.point, _onto_branch(bordered, run.point, branch)
            if first is None:
                detail = (
                    f"no equilibrium at {branch.amplitude:g} m along the shape of the {branch.point.kind}; try another amplitude"
                )
                return Outcome(Cause.NOT_CONVERGED, start.factor, end, detail)
            run.record(first)
            return arc.follow(bordered, first, end, run.follow, leaving=start)

        outcome = run.guarded(follow, end)
    return run.close(outcome, on_failure)


def _checked_steps(steps: Sequence[float] | int) -> list[float]:
    factors = [(k + 1) / steps for k in range(steps)] if isinstance(steps, int) else [float(s) for s in steps]
    if not factors or not all(map(isfinite, factors)) or any(b <= a for a, b in pairwise([0.0, *factors])):
        raise DeclarationError(
            "equilibrium", f"steps = {steps}", "accepted is a positive number of steps or ascending factors above 0"
        )
    return factors


def _checked_times(times: Sequence[float]) -> list[float]:
    instants = [float(t) for t in times]
    if len(instants) < 2 or not np.isfinite(instants).all() or np.any(np.diff(instants) <= 0):
        raise DeclarationError("equilibrium", f"times = {list(times)}", "accepted are at least two ascending times [s]")
    return instants


def _check_path(until: float | None, arc: ArcLength | None, control: DisplacementControl | None, branch: Branch | None) -> None:
    item = "equilibrium_path"
    if control is not None and (arc, until, branch) != (None, None, None):
        given = "arc" if arc is not None else "until" if until is not None else "branch"
        raise DeclarationError(item, f"control and {given}", "accepted is one of them: control names its own end and steps")
    if until is not None and not np.isfinite(until):
        raise DeclarationError(item, f"until = {until}", "accepted is a finite load factor")
    if branch is not None and (branch.amplitude == 0.0 or not np.isfinite(branch.amplitude)):
        raise DeclarationError(item, f"a branch of amplitude {branch.amplitude} m", "accepted is a length other than 0")
    if branch is not None and branch.point.kind != "bifurcation":
        raise DeclarationError(
            item, f"a branch at a {branch.point.kind}", "accepted is a bifurcation: no path leaves a limit point"
        )


def _set_factor(point: Point, value: float) -> None:
    point.factor = value


def _set_time(point: Point, value: float) -> None:
    point.t = value


def _climb(
    run: StaticRun,
    put: Callable[[Point, float], None],
    at: float,
    targets: Sequence[float],
    smallest: float,
    record: Callable[..., bool],
) -> Outcome:
    """Meet every target of the load factor or of time, with steps cut where Newton fails.

    Args:
        run: where the solution stands.
        put: sets the load factor or the time of a point.
        at: its present value.
        targets: ascending.
        smallest: step below which it is given up.
        record: takes each equilibrium, with a function that finds those on the way.
    """
    largest, good = np.inf, 0
    held = run.holds_first_matrix and put is _set_factor
    for target in targets:
        while at < target:
            step = min(target - at, largest)
            new = target if step >= 0.999 * (target - at) else at + step
            trial = run.point.copy()
            put(trial, new)
            report = run.newton.solve(trial, STATIC, run.q, held=held)
            held = False
            if report.converged:
                good += 1
                run.statistics.steps += 1
                record(trial, _between(run, put, at, trial, new))
                at = new
                if good >= 2 and report.iterations < 10:
                    largest, good = 2.0 * step, 0
                continue
            run.statistics.rejected += 1
            largest, good = 0.5 * step, 0
            if largest < smallest:
                detail = f"{'load' if put is _set_factor else 'time'} step {step:.1e}; {report.detail}"
                if report.cause is Cause.NOT_CONVERGED:
                    detail += "; the load cannot be carried from here: lower it, or pass a limit point with equilibrium_path"
                return Outcome(report.cause, at, targets[-1], detail)
    return Outcome(Cause.COMPLETED, at, targets[-1])


def _between(
    run: StaticRun, put: Callable[[Point, float], None], at: float, new: Point, value: float
) -> Callable[[float], Point | None]:
    """Equilibria between the present point and a new one, by their share of the step."""
    last, q = run.point, run.q

    def solved(share: float) -> Point | None:
        trial = last.copy()
        trial.u, trial.lam = last.u + share * (new.u - last.u), last.lam + share * (new.lam - last.lam)
        put(trial, at + share * (value - at))
        run.newton.forget()
        return trial if run.newton.solve(trial, STATIC, q).converged else None

    return solved


def _critical(run: StaticRun, branch: Branch) -> Point:
    """The critical point from which a branch begins."""
    state, model = branch.point.state, run.model
    if state.q.shape != model.q0.shape or state.lam.shape != (model.n_lam,):
        raise DeclarationError(
            "equilibrium_path",
            "the branch begins at a point of another system",
            "accepted is a critical point of this system's path",
        )
    point = run.equations.point_of(state, state.t)
    point.at_rest, point.factor = True, state.factor
    return point


def _onto_branch(newton: BorderedNewton, start: Point, branch: Branch) -> Point | None:
    """The equilibrium whose distance from the bifurcation along its null vector is that asked for, at whatever load."""
    equations = newton.equations
    shape = branch.amplitude * branch.point.shape[equations.elimination.independent]
    along = newton.metric * shape
    size = float(along @ shape)
    new = start.copy()
    new.u = start.u + shape
    return newton.solve(new, start, lambda at: (float(along @ (at.u - start.u)) - size, along, 0.0), BRANCH_ITERATIONS)[1]
