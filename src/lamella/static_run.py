"""One static solution: its equations, what is recorded, and how it ends."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from lamella.assembly.equations import Equations
from lamella.assembly.point import STATIC, Point
from lamella.critical import CriticalPoint
from lamella.ended_early import error_of
from lamella.errors import (
    ConstraintError,
    ConvergenceError,
    DeclarationError,
    FunctionError,
    ModelError,
    ResultFileError,
    SingularSystemError,
)
from lamella.model import Model
from lamella.progress import ProgressBar
from lamella.result import Cause, Outcome, Recorder, Result, Sink, Statistics
from lamella.roles import Floats
from lamella.signals import LOAD_FACTOR, system_signals
from lamella.solve.base import LinearSolver
from lamella.solve.bordered import Between
from lamella.solve.critical_search import CriticalSearch
from lamella.solve.initial import changes, project_positions, refuse_contradiction, refuse_undetermined
from lamella.solve.linear import Method, linear_solver
from lamella.solve.newton import Newton, NewtonSolver
from lamella.system import System

BALANCED = 1e-6
"""Force that is unbalanced without load, over the load, below which a start counts as an equilibrium."""


def compiled(system: System | Model, imperfection: Floats | None = None) -> Model:
    """The compiled system, with an imperfection when one is given.

    Raises:
        DeclarationError: a model that was compiled from no system cannot be given an imperfection; or it does not fit.
    """
    if imperfection is None:
        return system.compile() if isinstance(system, System) else system
    source = system if isinstance(system, System) else system.description
    if not isinstance(source, System):
        raise DeclarationError("imperfection", "the model was not compiled from a system", "accepted is the system itself")
    return source.compile(imperfection)


class StaticRun:
    """What all static solutions share: equations, Newton, recording, critical points, and the end.

    Args:
        system: what is loaded; its equations, where these exist.
        t: time at which loads and motions are taken [s].
        newton: how each step is solved.
        solver: name of the linear solver.
        axis: of the result.
        imperfection: added to the stress-free geometry, shape (n_q,).
    """

    def __init__(
        self,
        system: System | Model | Equations,
        t: float,
        newton: Newton,
        solver: Method,
        axis: str,
        imperfection: Floats | None = None,
    ) -> None:
        self.began = time.perf_counter()
        known = system if isinstance(system, Equations) and imperfection is None else None
        self.model = compiled(system.model if isinstance(system, Equations) else system, imperfection)
        self.model.reset()
        if not self.model.rows and not self.model.constraints:
            raise ModelError(
                "statics: nothing holds the system; add at least one support, for example Clamp(name, plate.edge('x-'))"
            )
        self.equations, self.statistics = known or Equations(self.model), Statistics()
        self.equations.forget()
        linear = linear_solver(self.equations.matrix.pattern, solver)
        self.newton = NewtonSolver(self.equations, linear, newton, self.statistics)
        self.point = self.equations.start(t, factor=0.0, at_rest=True)
        refuse_undetermined(self.equations, self.point)
        self._make_consistent(linear)
        self.axis = axis
        self.search = CriticalSearch(self.equations, linear, self.statistics)
        self.critical_points: list[CriticalPoint] = []

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

    def relax(self) -> None:
        """Find the equilibrium without load where the start is none, as that of prestrained plates: a path begins at one.

        Raises:
            ConvergenceError: there is none.
        """
        unbalanced = np.abs(self.equations.residual(self.point)[0]).max()
        if unbalanced <= BALANCED * np.abs(self.equations.load_direction(self.point)).max():
            return
        trial = self.point.copy()
        report = self.newton.solve(trial, STATIC)
        if not report.converged:
            raise ConvergenceError(f"equilibrium_path: there is no equilibrium without load: {report.detail}")
        self.point = trial

    def open(self, start: float, until: float, sinks: Sequence[Sink], bar: ProgressBar | None) -> None:
        """Prepare to record, from the present point on."""
        self.recorder = Recorder(
            [LOAD_FACTOR, *system_signals(self.equations)],
            self.axis,
            start,
            until,
            sinks=(bar, *sinks) if bar else sinks,
        )
        self.q, self.state = self.equations.coordinates(self.point), self.equations.state(self.point)
        self.statistics.seconds_compile = time.perf_counter() - self.began

    @property
    def holds_first_matrix(self) -> bool:
        """Whether the linear solver holds the stiffness at the last point, and the load factor does not change it."""
        dead = all(load.depends_on_time_alone for load in self.model.loads)
        return self.search.at_point and dead and not self.equations.elimination.moves

    def follow(self, point: Point, between: Between | None = None) -> bool:
        """As :meth:`record`, but an equilibrium on another path than the last one is not taken: the answer is then False."""
        return self._recorded(point, between, jumps=False)

    def record(self, point: Point, between: Between | None = None) -> bool:
        """Take an equilibrium as the state to go on from, with the critical points on the way to it, and sample it.

        Args:
            point: the equilibrium.
            between: finds those between the last one and it.

        Returns:
            True.
        """
        return self._recorded(point, between, jumps=True)

    def _recorded(self, point: Point, between: Between | None, *, jumps: bool) -> bool:
        count = float(len(self.recorder.at))
        if between is None:
            self.search.begin(point)
        else:
            found = self.search.passed(
                point, between, lambda share, there: count - 1.0 + share if self.axis == "path" else self._at(there)
            )
            if self.search.jumped and not jumps:
                self.search.begin(self.point)
                return False
            self.critical_points += found
        if not self.search.at_point:
            self.newton.forget()
        self.point, self.q = point, self.equations.coordinates(point)
        self.state = self.equations.state(point)
        self.model.settle(self.state)
        self.recorder.sample(count if self.axis == "path" else self._at(point), self.state)
        return True

    def take(self, point: Point, between: Between) -> bool:
        """Take an equilibrium as the state to go on from, without recording it; True."""
        self.point, self.q = point, self.equations.coordinates(point)
        self.state = self.equations.state(point)
        self.model.settle(self.state)
        return True

    def _at(self, point: Point) -> float:
        return point.t if self.axis == "time" else point.factor

    def guarded(self, solve: Callable[[], Outcome], until: float) -> Outcome:
        """Run a solution; an interruption ends it with what was recorded."""
        try:
            self.record(self.point)
            return solve()
        except KeyboardInterrupt:
            return Outcome(Cause.INTERRUPTED, self._at(self.point), until)
        except ResultFileError as error:
            return Outcome(Cause.WRITE_FAILED, self._at(self.point), until, str(error))
        except FunctionError as error:
            return Outcome(Cause.FUNCTION_FAILED, self._at(self.point), until, str(error), error=error)

    def judged(self, outcome: Outcome) -> Outcome:
        """The outcome of a completed solution, with a word of warning when the equilibrium is unstable."""
        if not outcome.completed:
            return outcome
        negative = self.search.negative_at(self.point)
        if negative is None:
            k, j = self.equations.exact_matrix(self.point, STATIC)
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
        final, points = self.model.remembering(self.state), tuple(self.critical_points)
        outcome = replace(self.judged(outcome), start=self.start, critical_points=points, final=final)
        self.statistics.seconds_run = time.perf_counter() - self.began - self.statistics.seconds_compile
        self.recorder.close(outcome, self.statistics)
        result = Result(self.model, self.recorder, final, outcome, self.statistics)
        if not outcome.completed and on_failure == "raise":
            raise error_of(result, f"the equilibrium {outcome}")
        return result
