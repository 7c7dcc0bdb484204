"""A factorisation that serves for other matrices than its own is read in single precision, or as integers."""

from __future__ import annotations

import numpy as np
import pytest
from test_linear import constraints, indefinite, pattern_of, plate_like

import lamella as lm
from lamella._jit import kernel
from lamella.assembly.equations import Equations
from lamella.assembly.point import Weights
from lamella.bench.gradients import WORK
from lamella.differentiation.exact_matrix import ExactMatrix
from lamella.lane import WIDTH
from lamella.roles import Floats, Singles
from lamella.solve import multifrontal, panels
from lamella.solve.linear import linear_solver
from lamella.solve.multifrontal import LEAST_PIVOT, Multifrontal
from lamella.solve.readable import Scaled
from lamella.solve.single_rows import products_of_singles, rows_of_singles, subtract_singles
from lamella.solve.turned import TurnedSolver, Vectors

SINGLE = 1e-5
"""What single precision may leave of a solution: 6e-8 times the condition of these matrices scaled to a diagonal of 1, 20 to 430,
and no more."""
INTEGERS = 2.0**-15 * 430
"""The same of integers: an entry is off by half of one of 32767 parts of the largest in its column."""
WEIGHTS = Weights(1.0, 1500.0, 4e6)


@pytest.fixture
def any_size(monkeypatch: pytest.MonkeyPatch) -> None:
    """Factors of any size are shortened."""
    monkeypatch.setattr(panels, "SHORTENED", 0)


@pytest.fixture(params=[SINGLE, INTEGERS], ids=["single precision", "integers"])
def left(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> float:
    """What a factor may leave of a solution, of any size and in each form."""
    monkeypatch.setattr(panels, "SHORTENED", 0)
    monkeypatch.setattr(multifrontal, "LEAST_PIVOT", LEAST_PIVOT if request.param == INTEGERS else np.inf)
    return request.param


def off(found: Floats, expected: Floats) -> float:
    return float(np.abs(found - expected).max() / np.abs(expected).max())


@pytest.mark.parametrize("shape", [(2, 2), (7, 5)])
@pytest.mark.parametrize("definite", [True, False])
def test_solutions_are_rounded_until_the_next_factorisation(definite: bool, shape: tuple[int, int], left: float) -> None:
    k = plate_like(*shape)
    if not definite:
        k[20, 20] *= -1.0
    pattern, values, _ = pattern_of(k)
    factor, r = Multifrontal(pattern), np.sin(np.arange(pattern.n))
    several = np.stack([r, 2.0 * r, r**2, -r], axis=1)
    for scale in (1.0, 3.0):
        assert factor.factorise(scale * values) == -1
        exact, each = factor.solve(r), factor.solve(several)
        assert off(scale * (k @ exact), r) < 1e-10
        factor.shorten()
        assert (factor._scaled is not None) == (left == INTEGERS)
        for found, expected in ((factor.solve(r), exact), (factor.solve(several), each)):
            assert left * 1e-5 < off(found, expected) < left


@pytest.mark.usefixtures("any_size")
@pytest.mark.parametrize("size", [1, WIDTH, 5 * WIDTH + 3])
def test_panels_are_shortened_in_their_own_place(size: int) -> None:
    short = panels.Panels(size)
    short.written[:] = expected = np.random.default_rng(4).standard_normal(len(short.written))
    short.shorten()
    np.testing.assert_array_equal(short.read, expected.astype(np.float32))
    assert np.shares_memory(short.read, short.written)
    short.shorten()
    np.testing.assert_array_equal(short.read, expected.astype(np.float32))
    short.renew()
    assert short.read is short.written
    assert len(short.read) >= size + WIDTH  # a substitution loads a lane behind the last entry


@kernel
def singles_of(factor: Scaled, at: int, a_len: int, y: Singles) -> tuple[int, float, float, float, float]:
    """Rows that are read in lanes of single numbers; y less four columns; products of these with it."""
    n = rows_of_singles(y, a_len)
    subtract_singles(factor, at, a_len, a_len - n, 0.5, -1.0, 2.0, 0.25, y)
    return n, *products_of_singles(factor, at, a_len, a_len - n, y)


@pytest.mark.parametrize("lanes", [2, 3, 6, 7])
def test_rows_of_single_numbers_are_those_of_numbers(lanes: int) -> None:
    """Compiled, and as they stand, for rows that do and do not fill lanes twice as long."""
    rng, a_len, at = np.random.default_rng(2), lanes * WIDTH, 5
    shares = rng.integers(-32767, 32767, 20 * a_len).astype(np.int16)
    factor = Scaled(shares, np.zeros(0), np.zeros(0), np.zeros(0))
    compiled = rng.standard_normal(a_len).astype(np.float32)
    stood = compiled.copy()
    n, *found = singles_of(factor, at, a_len, compiled)
    m, *expected = singles_of.py_func(factor, at, a_len, stood)
    assert n == m == lanes // 2 * 2 * WIDTH
    np.testing.assert_allclose(compiled, stood, atol=1e-6 * np.abs(stood).max())
    np.testing.assert_allclose(found, expected, atol=1e-5 * np.abs(expected).max())
    np.testing.assert_array_equal(compiled[: a_len - n], stood[: a_len - n])
    assert rows_of_singles(np.zeros(a_len), a_len) == 0  # of double numbers


def test_small_factors_stay_as_they_are() -> None:
    pattern, values, _ = pattern_of(plate_like(4, 4))
    factor, r = Multifrontal(pattern), np.ones(pattern.n)
    factor.factorise(values)
    exact = factor.solve(r)
    factor.shorten()
    np.testing.assert_array_equal(factor.solve(r), exact)


@pytest.mark.parametrize("kind", ["definite", "multipliers", "indefinite", "unsymmetric", "unsymmetric with multipliers"])
def test_constraints_hold_to_rounding(kind: str, left: float) -> None:
    k = indefinite(5, 4) if kind == "indefinite" else plate_like(5, 4)
    if kind.startswith("unsymmetric"):
        k *= 1.0 + 0.2 * np.random.default_rng(6).standard_normal(k.shape)
    j = constraints(len(k), 4) if kind.endswith("multipliers") else None
    pattern, k_values, j_values = pattern_of(k, j, symmetric=not kind.startswith("unsymmetric"))
    solver = linear_solver(pattern)
    solver.factorise(k_values, j_values)
    rng = np.random.default_rng(3)
    r, s = rng.standard_normal(pattern.n), rng.standard_normal(pattern.n_lam)
    exact, multipliers = solver.solve(r, s)
    solver.shorten()
    x, y = solver.solve(r, s)
    assert 0.0 < off(x, exact) < left
    if j is not None:
        assert off(y, multipliers) < left
        assert np.abs(j @ x - s).max() < 1e-14 * (np.abs(j) @ np.abs(x)).max()


def turned_solver_at(equations: Equations) -> tuple[TurnedSolver, Floats]:
    """A solver with the factorisation at the start, and the coordinates after a rotation."""
    point = equations.start()
    solver = TurnedSolver(linear_solver(equations.matrix.pattern), Vectors(equations))
    solver.factorise(*equations.exact_matrix(point, WEIGHTS))
    solver.made_at(point.u)
    turn = np.array([[0.8, 0.0, 0.6], [0.0, 1.0, 0.0], [-0.6, 0.0, 0.8]])
    return solver, (point.u.reshape(-1, 3) @ turn.T).reshape(-1)


def test_what_turns_is_shortened(monkeypatch: pytest.MonkeyPatch) -> None:
    equations, found = Equations(WORK[1].plate().compile()), []
    r, none = np.sin(np.arange(equations.n_u)), np.zeros(0)
    for entries in (10**9, 0):
        monkeypatch.setattr(panels, "SHORTENED", entries)
        solver, u = turned_solver_at(equations)
        found.append([solver.solve(r, none)[0]])
        solver.turn(u)
        found[-1].append(solver.solve(r, none)[0])
    (at_first, turned), (same, short) = found
    np.testing.assert_array_equal(same, at_first)
    assert 0.0 < off(short, turned) < SINGLE


def test_a_motion_takes_as_many_iterations_and_ends_at_the_same_place(monkeypatch: pytest.MonkeyPatch, left: float) -> None:
    """Newton's tolerance decides on the end of a motion, not the precision of its corrections."""
    model, method = WORK[1].plate().compile(), lm.GeneralizedAlpha(1e-3, newton=lm.Newton(tolerance=1e-9, keep=0.6))
    done, shortened, shorten = [], [0], Multifrontal.shorten

    def counted(factor: Multifrontal, singles: bool = True) -> None:
        before = factor._panels.fresh
        shorten(factor, singles)
        shortened[0] += before and not factor._panels.fresh
        assert factor._panels.fresh or (factor._scaled is not None) == (left == INTEGERS)

    monkeypatch.setattr(Multifrontal, "shorten", counted)
    for entries in (0, 10**9):
        monkeypatch.setattr(panels, "SHORTENED", entries)
        result = lm.simulate(model, 0.05, method)
        done.append((result.final.q, result.statistics, shortened[0]))
    (short, counts, times), (exact, expected, after) = done
    assert 0 < times == after <= counts.factorisations
    # Integers leave 1e-4 to 1e-3 of errors of short waves, which a correction to 1e-9 needs once more now and then.
    assert counts.newton_iterations == pytest.approx(expected.newton_iterations, rel=0.05 if left == INTEGERS else 0.02)
    assert off(short, exact) < 1e-8


@pytest.mark.usefixtures("left")
@pytest.mark.parametrize("work", [WORK[1], WORK[3]], ids=lambda work: work.name)
def test_derivatives_are_as_right_as_they_are_asked_for(work) -> None:
    """Products with the exact matrix tell what a short factor of another one lacks."""
    equations = Equations(work.plate().compile())
    start, r, none = equations.start(), np.sin(np.arange(equations.n_u)), np.zeros(0)
    point = start.copy()
    point.u += 1e-5 * equations.magnitude * np.sin(np.arange(equations.n_u))
    matrix, exact = ExactMatrix(equations), ExactMatrix(equations)
    exact.factorise(point, WEIGHTS)
    matrix.factorise(start, WEIGHTS)
    matrix.linear.shorten()
    matrix._begin(point, WEIGHTS)
    expected, found = exact.solve(r, none)[0], matrix.solve(r, none)[0]
    assert matrix._spent > 0
    assert 0.0 < off(found, expected) < 1e-9


@pytest.mark.parametrize("least", [0.5, 1.5])
def test_small_pivots_forbid_integers(least: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """Two coordinates apart from the others, coupled by c with a diagonal of 1, have the pivots 1 and 1 - c^2."""
    monkeypatch.setattr(panels, "SHORTENED", 0)
    k = plate_like(4, 4)
    c = 1.0 - 0.5 * least * LEAST_PIVOT
    a, b = len(k) - 2, len(k) - 1
    k[[a, b], :] = k[:, [a, b]] = 0.0
    k[a, a] = k[b, b] = 1.0
    k[a, b] = k[b, a] = c
    pattern, values, _ = pattern_of(k)
    factor, r = Multifrontal(pattern), np.sin(np.arange(pattern.n))
    assert factor.factorise(values) == -1
    exact = factor.solve(r)
    factor.shorten()
    assert (factor._scaled is not None) == (least > 1.0)
    assert not factor._panels.fresh
    assert off(factor.solve(r), exact) < (0.1 if least > 1.0 else 1e-3)


def test_units_of_coordinates_do_not_count(monkeypatch: pytest.MonkeyPatch) -> None:
    """Integers are shares of columns of a matrix with a diagonal of 1, whatever the units of its rows."""
    monkeypatch.setattr(panels, "SHORTENED", 0)
    k, found = plate_like(5, 5), []
    for powers in (np.zeros(len(k)), np.arange(len(k)) % 7 - 3):
        units = 4.0**powers
        pattern, values, _ = pattern_of(k * units * units[:, None])
        factor = Multifrontal(pattern)
        factor.factorise(values)
        factor.shorten()
        found.append(units * factor.solve(units * np.sin(np.arange(len(k)))))
    np.testing.assert_allclose(found[1], found[0], rtol=0.0, atol=1e-14 * np.abs(found[0]).max())
