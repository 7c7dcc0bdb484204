"""Newton's iteration: its rate, its options, and how it ends when there is no solution."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import lamella as lm
from lamella.assembly.equations import Equations
from lamella.assembly.pattern import Pattern
from lamella.assembly.point import STATIC, Point
from lamella.errors import DeclarationError
from lamella.result import Cause, Statistics
from lamella.solve.linear import linear_solver
from lamella.solve.newton import NewtonSolver

SECTION = lm.Laminate(lm.Isotropic(E=2e9, nu=0.3, rho=1200.0), thickness=0.02)


def problem(force=-200.0, *, held=True, **options):
    """A cantilever that bends by a fifth of its length, its solver, and the unloaded point."""
    system, plate = lm.System(), lm.Plate("plate", (1.0, 0.3), (3, 1), SECTION)
    system.add(plate)
    if held:
        system.add(lm.Clamp("root", plate.edge("x-")))
    else:
        system.add(lm.PointSupport("pin", plate.corner("x-y-")))
    system.add(lm.PointForce("load", plate.corner("x+y+"), (0, 0, force)))
    equations, statistics = Equations(system.compile()), Statistics()
    solver = NewtonSolver(
        equations, linear_solver(equations.matrix.pattern, "auto"), lm.Newton(**{"keep": 0.0} | options), statistics
    )
    return solver, equations.start(at_rest=True), statistics


def sizes(solver, monkeypatch):
    """Sizes of the corrections, in order."""
    found = []
    plain = solver._small_enough
    monkeypatch.setattr(solver, "_small_enough", lambda size, *others: found.append(size) or plain(size, *others))
    return found


def test_corrections_shrink_quadratically(monkeypatch):
    solver, point, _ = problem(tolerance=1e-13, extrapolate=False, max_iterations=60)
    found = sizes(solver, monkeypatch)
    assert solver.solve(point, STATIC).converged
    # Bending and stretching take turns: a bending correction d leaves a stretching of d^2, which the next one removes.
    # So the rate shows at the end, where one correction follows from the square of the last.
    assert found[-1] < 1e-3 * found[-2] < 1e-6 * found[0]
    assert found[-1] < 1e-9


def test_accepted_error_is_within_the_tolerance():
    solver, exact, _ = problem(tolerance=1e-13, max_iterations=60)
    assert solver.solve(exact, STATIC).converged
    for tolerance in (1e-3, 1e-5, 1e-7):
        solver, point, _ = problem(tolerance=tolerance, max_iterations=60)
        assert solver.solve(point, STATIC).converged
        assert solver.size(point.u - exact.u) <= 2.0 * tolerance


@pytest.mark.parametrize(
    "options", [{"extrapolate": False}, {"line_search": True}, {"line_search": "residual"}, {"keep": 0.3}, {"keep": 0.9}]
)
def test_options_change_the_way_and_not_the_end(options):
    solver, plain, _ = problem(tolerance=1e-11, max_iterations=60)
    assert solver.solve(plain, STATIC).converged
    solver, other, _ = problem(tolerance=1e-11, max_iterations=200, **options)
    assert solver.solve(other, STATIC).converged
    assert solver.size(other.u - plain.u) < 1e-9


def test_extrapolated_stress_saves_iterations():
    counts = {}
    for extrapolate in (True, False):
        solver, point, _ = problem(extrapolate=extrapolate, max_iterations=60)
        counts[extrapolate] = solver.solve(point, STATIC, solver.equations.coordinates(point)).iterations
    assert counts[True] < counts[False]


def test_a_kept_factorisation_serves_further_solutions():
    solver, point, statistics = problem(force=-1.0, keep=0.5)
    assert solver.solve(point, STATIC).converged
    before = statistics.factorisations
    point.u += 1e-7 * solver.equations.magnitude  # a slightly different start
    assert solver.solve(point, STATIC).converged
    assert statistics.factorisations == before
    solver.forget()
    assert solver.solve(point, STATIC).converged
    assert statistics.factorisations == before + 1


class Stiffening:
    """r(u) = u + u^3 - load: where the load grows by a tenth, the matrix is good for one step."""

    magnitude, n_motion = np.ones(1), 1

    def __init__(self):
        self.load = 1.0

    def residual(self, point):
        return point.u + point.u**3 - self.load, np.zeros(0)

    def linearise(self, point, weights, previous=None):
        return (*self.residual(point), 1.0 + 3.0 * point.u**2, np.zeros(0))

    def coordinates(self, point):
        return point.u

    def violation(self, point):
        return 0.0


def test_a_matrix_that_is_good_for_one_step_serves_the_first_correction_of_the_next_and_is_not_tried_again():
    none, statistics = np.zeros(0, np.int64), Statistics()
    pattern = Pattern(1, np.array([0, 1]), np.array([0]), False, 0, np.zeros(1, np.int64), none)
    options = lm.Newton(tolerance=1e-5, keep=0.01, line_search="residual")
    equations = Stiffening()
    solver = NewtonSolver(equations, linear_solver(pattern, "superlu"), options, statistics)
    point = Point(0.0, np.zeros(1), np.zeros(1), np.zeros(1), np.zeros(0))
    for _ in range(3):
        assert solver.solve(point, STATIC).converged
        equations.load *= 1.1
    before = replace(statistics)
    for _ in range(4):
        assert solver.solve(point, STATIC).converged
        assert point.u[0] + point.u[0] ** 3 == pytest.approx(equations.load, rel=1e-5)
        equations.load *= 1.1
    assert statistics.factorisations - before.factorisations == 4
    iterations = statistics.newton_iterations - before.newton_iterations
    assert statistics.solves - before.solves == iterations  # none was in vain
    assert statistics.residuals - before.residuals == iterations


def test_a_solver_that_has_forgotten_works_as_a_new_one():
    none = np.zeros(0, np.int64)
    pattern = Pattern(1, np.array([0, 1]), np.array([0]), False, 0, np.zeros(1, np.int64), none)
    options = lm.Newton(tolerance=1e-5, keep=0.01, line_search="residual")
    used, new = (NewtonSolver(Stiffening(), linear_solver(pattern, "superlu"), options, Statistics()) for _ in range(2))

    def solve(solver, count):
        point = Point(0.0, np.zeros(1), np.zeros(1), np.zeros(1), np.zeros(0))
        before = replace(solver.statistics)
        for k in range(count):
            solver.equations.load = 1.1**k
            assert solver.solve(point, STATIC).converged
        return point.u[0], solver.statistics.solves - before.solves, solver.statistics.residuals - before.residuals

    solve(used, 6)
    used.forget()
    assert solve(used, 3) == solve(new, 3)


def test_statistics_count_the_work():
    solver, point, statistics = problem()
    report = solver.solve(point, STATIC)
    assert statistics.newton_iterations == report.iterations
    assert statistics.tangents == statistics.factorisations == statistics.solves == report.iterations
    assert statistics.residuals >= report.iterations


@pytest.mark.parametrize("options", [{}, {"keep": 0.3}, {"line_search": True}, {"line_search": "residual"}], ids=repr)
def test_a_matrix_that_is_held_spares_the_first_one_and_changes_nothing(options):
    solver, point, statistics = problem(**options)
    reference = solver.equations.coordinates(point)
    report = solver.solve(point, STATIC, reference)
    again, start, fewer = problem(**options)
    _, _, k, j = again.equations.linearise(start, STATIC)
    again.linear.factorise(k, j)
    assert again.solve(start, STATIC, reference, held=True) == report
    np.testing.assert_array_equal(start.u, point.u)
    spared = options.get("line_search") != "residual"
    assert (fewer.tangents, fewer.factorisations) == (statistics.tangents - spared, statistics.factorisations - spared)
    assert (fewer.residuals, fewer.solves) == (statistics.residuals, statistics.solves)


def test_too_few_iterations_are_reported_with_the_last_correction():
    solver, point, _ = problem(max_iterations=2)
    report = solver.solve(point, STATIC)
    assert not report.converged
    assert report.cause is Cause.NOT_CONVERGED
    assert report.iterations == 2
    assert report.size > 0
    assert "after 2 iterations" in report.detail


def test_a_free_body_is_singular_and_what_is_free_is_named():
    solver, point, _ = problem(held=False)
    report = solver.solve(point, STATIC)
    assert report.cause is Cause.SINGULAR
    assert "nothing holds" in report.detail
    assert "plate" in report.detail


def test_a_residual_that_is_not_finite_is_reported():
    solver, point, _ = problem()
    point.u[3] = np.nan
    report = solver.solve(point, STATIC)
    assert report.cause is Cause.NOT_FINITE
    assert report.iterations == 0


def test_line_search_shortens_a_step_that_overshoots():
    """A flat strip held at both ends has no membrane stiffness against the first deflection: plain steps overshoot by far."""
    lengths = {}
    for search in (False, True):
        system, plate = lm.System(), lm.Plate("plate", (1.0, 0.2), (4, 1), SECTION)
        system.add(plate)
        system.add(lm.Clamp("left", plate.edge("x-")))
        system.add(lm.Clamp("right", plate.edge("x+")))
        system.add(lm.SurfaceForce("load", plate, (0, 0, -5e5)))
        equations = Equations(system.compile())
        options = lm.Newton(keep=0.0, extrapolate=False, line_search=search, max_iterations=100)
        solver = NewtonSolver(equations, linear_solver(equations.matrix.pattern, "auto"), options, Statistics())
        point = equations.start(at_rest=True)
        report = solver.solve(point, STATIC)
        lengths[search] = report.iterations if report.converged else 1000
    assert lengths[True] < 1000
    assert lengths[True] <= lengths[False]


@pytest.mark.parametrize(
    "options", [{"tolerance": 0.0}, {"tolerance": float("nan")}, {"max_iterations": 0}, {"keep": 1.0}, {"keep": -0.1}]
)
def test_impossible_options_are_refused(options):
    with pytest.raises(DeclarationError, match=next(iter(options))):
        lm.Newton(**options)
