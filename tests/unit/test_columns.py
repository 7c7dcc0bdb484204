"""Several right-hand sides at once: the solutions of each by itself, for all solvers, threads and turned structures."""

from __future__ import annotations

import numpy as np
import pytest
from test_linear import constraints, indefinite, pattern_of, plate_like

from lamella import threads
from lamella.assembly.equations import Equations
from lamella.assembly.point import Weights
from lamella.bench.gradients import WORK
from lamella.differentiation.exact_matrix import Change, ExactMatrix
from lamella.lane import WIDTH
from lamella.roles import Floats
from lamella.solve import front_columns, multifrontal, panels
from lamella.solve.linear import linear_solver
from lamella.solve.multifrontal import SEVERAL, Multifrontal
from lamella.solve.turned import TurnedSolver, Vectors
from lamella.solve.turned_nodes import turned_solver

ROUNDING = 1e-10
"""Of solutions of one matrix in another order of the sums, relative to the largest."""


def same(found: Floats, expected: Floats) -> None:
    np.testing.assert_allclose(found, expected, atol=ROUNDING * np.abs(expected).max())


@pytest.mark.parametrize("m", [1, 2, 3, 8, 10, 19])
def test_columns_of_a_factorisation(m: int) -> None:
    k = plate_like(5, 4)
    pattern, values, _ = pattern_of(k)
    factor = Multifrontal(pattern)
    assert factor.factorise(values) == -1
    r = np.random.default_rng(2).standard_normal((pattern.n, m))
    for columns in (r, np.asfortranarray(r)):
        found = factor.solve(columns)
        assert found.shape == r.shape
        for i in range(m):
            same(found[:, i], factor.solve(np.ascontiguousarray(r[:, i])))


def test_one_reading_serves_several(monkeypatch: pytest.MonkeyPatch) -> None:
    pattern, values, _ = pattern_of(plate_like(4, 4))
    factor, passes, forward = Multifrontal(pattern), [], front_columns.forward
    factor.factorise(values)

    def counted(order, *arrays):
        passes.append(len(order))
        forward(order, *arrays)

    monkeypatch.setattr(front_columns, "forward", counted)
    n_fronts = len(factor._layout.fronts) - 1
    for m, readings in ((SEVERAL - 1, 0), (SEVERAL, 1), (WIDTH, 1), (WIDTH + SEVERAL, 2)):
        passes.clear()
        factor.solve(np.ones((pattern.n, m)))
        assert sum(passes) == readings * n_fronts


@pytest.mark.usefixtures("always_cut")
@pytest.mark.parametrize("short", ["", "single precision", "integers", "integers and single numbers"])
def test_threads_change_no_bit_of_columns(short: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(panels, "SHORTENED", 0)
    monkeypatch.setattr(multifrontal, "LEAST_PIVOT", 0.0 if "integers" in short else np.inf)
    pattern, values, _ = pattern_of(plate_like(9, 9))
    r, found = np.random.default_rng(2).standard_normal((pattern.n, 6)), []
    for count in (1, 2):
        threads.use(count)
        factor = Multifrontal(pattern)
        assert factor._plan.solves == (count == 2)
        factor.factorise(values)
        if short:
            factor.shorten(singles="single numbers" in short)
        assert (factor._scaled is not None) == ("integers" in short)
        found.append((factor.solve(r), factor.solve(np.ascontiguousarray(r[:, 0]))))
        if "integers" in short:  # which are read for each by itself
            np.testing.assert_array_equal(found[-1][0][:, 0], found[-1][1])
        else:
            same(found[-1][0][:, 0], found[-1][1])
    for one, other in zip(*found, strict=True):
        np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize("kind", ["definite", "multipliers", "indefinite", "null space"])
def test_solvers_solve_each(kind: str) -> None:
    k = indefinite(4, 4) if kind == "indefinite" else plate_like(4, 4)
    j = {"multipliers": constraints(len(k), 4), "null space": constraints(len(k), 60)}.get(kind)
    pattern, k_values, j_values = pattern_of(k, j)
    solver = linear_solver(pattern)
    solver.factorise(k_values, j_values)
    rng = np.random.default_rng(3)
    rights = [(rng.standard_normal(pattern.n), rng.standard_normal(pattern.n_lam)) for _ in range(5)]
    for (x, y), right in zip(solver.solve_each(rights), rights, strict=True):
        expected = solver.solve(*right)
        same(x, expected[0])
        same(y, expected[1]) if len(y) else None


def plate_equations() -> Equations:
    return Equations(WORK[1].plate().compile())


@pytest.mark.parametrize("by_nodes", [True, False])
def test_turned_factorisations_solve_each(by_nodes: bool) -> None:
    equations = plate_equations()
    point, weights = equations.start(), Weights(1.0, 0.0, 4e6)
    inner = linear_solver(equations.matrix.pattern)
    solver = turned_solver(inner, Vectors(equations)) if by_nodes else TurnedSolver(inner, Vectors(equations))
    assert solver is not None
    solver.factorise(*equations.exact_matrix(point, weights))
    solver.made_at(point.u)
    rng = np.random.default_rng(5)
    rights = [(rng.standard_normal(equations.n_u), np.zeros(0)) for _ in range(4)]
    before = [x for x, _ in solver.solve_each(rights)]
    a = 1e-3
    turn = np.array([[np.cos(a), 0.0, np.sin(a)], [0.0, 1.0, 0.0], [-np.sin(a), 0.0, np.cos(a)]])
    solver.turn((point.u.reshape(-1, 3) @ turn.T).reshape(-1))
    after = [x for x, _ in solver.solve_each(rights)]
    for x, old, right in zip(after, before, rights, strict=True):
        same(x, solver.solve(*right)[0])
        assert np.abs(x - old).max() > 1e-6 * np.abs(old).max()


@pytest.mark.parametrize("near", [True, False])
def test_derivatives_of_several_parameters_are_those_of_each(near: bool) -> None:
    """With the factorisation of the point itself, and with that of one beside it."""
    equations = plate_equations()
    weights, start = Weights(1.0, 0.0, 4e6), equations.start()
    point = start.copy()
    point.u += 1e-5 * equations.magnitude * np.sin(np.arange(equations.n_u))
    rng = np.random.default_rng(6)
    changes = [
        Change(rng.standard_normal(equations.n_u), np.zeros(0), guess)
        for guess in (None, None, 1e-9 * np.ones(equations.n_u), None)
    ]
    matrix = ExactMatrix(equations)
    matrix.factorise(start if near else point, weights)
    if near:
        matrix._begin(point, weights)
    found = matrix.solve_each(changes)
    assert (matrix._spent > 0) == near
    exact = ExactMatrix(equations)
    exact.factorise(point, weights)
    for (x, _), change in zip(found, changes, strict=True):
        same(x, exact.solve(change.r, change.s)[0])
