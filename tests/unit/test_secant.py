"""Corrections with an outdated factorisation against the exact matrix."""

from __future__ import annotations

import numpy as np
import pytest

from lamella.assembly.pattern import Pattern
from lamella.roles import Floats
from lamella.solve.broyden import BroydenCorrections
from lamella.solve.secant import MEMORY, SecantCorrections
from lamella.solve.superlu import SuperLUSolver

N, N_LAM = 12, 3


def dense_pattern(symmetric: bool, n_lam: int) -> Pattern:
    rows, cols = np.nonzero(np.triu(np.ones((N, N))) if symmetric else np.ones((N, N)))
    j_starts, j_cols = N * np.arange(n_lam + 1), np.tile(np.arange(N), n_lam)
    return Pattern(N, np.searchsorted(rows, np.arange(N + 1)), cols, symmetric, n_lam, j_starts, j_cols)


class Problem:
    """A z = b with A = [[K, J^T], [J, 0]] and a factorisation of another K, whose corrections contract by about a third."""

    def __init__(self, n_lam: int = 0, symmetric: bool = True) -> None:
        rng = np.random.default_rng(3)
        half, change = rng.standard_normal((N, N)), rng.standard_normal((N, N))
        k, jacobian = half @ half.T + N * np.eye(N), rng.standard_normal((n_lam, N))
        change = 0.35 * N * (change + change.T) / np.linalg.norm(change + change.T, 2)
        if not symmetric:
            k += np.triu(rng.standard_normal((N, N)), 1)
        self.matrix = np.block([[k + change, jacobian.T], [jacobian, np.zeros((n_lam, n_lam))]])
        self.b = rng.standard_normal(N + n_lam)
        pattern = dense_pattern(symmetric, n_lam)
        linear = SuperLUSolver(pattern)
        linear.factorise(k[pattern.rows, pattern.indices], jacobian.reshape(-1))
        self.corrections = SecantCorrections(linear) if symmetric else BroydenCorrections(linear, rng.uniform(0.5, 2.0, N))
        self.z = np.zeros(N + n_lam)

    def residual(self, z: Floats) -> Floats:
        return self.matrix @ z - self.b

    def correct(self) -> Floats:
        g = self.residual(self.z)
        s = np.concatenate(self.corrections(g[:N], g[N:]))
        self.z = self.z + s
        return s


def iterations(problem: Problem, learns: bool) -> int:
    """Corrections until the residual is 1e-10 of the first."""
    for i in range(100):
        if not learns:
            problem.corrections.forget()
        problem.correct()
        if np.linalg.norm(problem.residual(problem.z)) < 1e-10 * np.linalg.norm(problem.b):
            return i + 1
    return 100


@pytest.mark.parametrize("symmetric", [True, False])
def test_the_first_correction_is_that_of_the_factorisation(symmetric: bool):
    problem, again = Problem(symmetric=symmetric), Problem(symmetric=symmetric)
    expected = again.corrections.linear.solve(again.b, np.zeros(0))
    np.testing.assert_array_equal(problem.correct(), np.concatenate(expected))


@pytest.mark.parametrize("n_lam", [0, N_LAM])
def test_the_last_secant_is_met(n_lam: int):
    """H y = s: a residual grown by y is answered by a correction that is s smaller."""
    problem = Problem(n_lam)
    for _ in range(MEMORY + 2):
        problem.correct()  # more than are remembered
    before = problem.residual(problem.z)
    s = problem.correct()
    after = problem.residual(problem.z)
    first = np.concatenate(problem.corrections(after[:N], after[N:]))
    problem.corrections._corrected = False  # asks twice without a correction in between
    second = np.concatenate(problem.corrections(before[:N], before[N:]))
    np.testing.assert_allclose(first - second, -s, atol=1e-9 * np.abs(s).max())  # products of eight updates lose some digits


@pytest.mark.parametrize("n_lam", [0, N_LAM])
@pytest.mark.parametrize("steps", [1, 2, 5])
def test_broyden_steps_are_those_of_the_updated_matrix(n_lam: int, steps: int):
    """B_k+1 = B_k + (y - B_k s) s^T W / (s^T W s), formed densely."""
    problem = Problem(n_lam, symmetric=False)
    linear, weights = problem.corrections.linear, np.zeros(N + n_lam)
    weights[:N] = problem.corrections._weights[:N]
    unit = np.eye(N + n_lam)
    B = np.linalg.inv(np.column_stack([np.concatenate(linear.solve(e[:N], e[N:])) for e in unit]))
    for _ in range(steps):
        before, s = problem.residual(problem.z), problem.correct()
        np.testing.assert_allclose(B @ s, -before, atol=1e-9 * np.abs(before).max())
        y = problem.residual(problem.z) - before
        B += np.outer(y - B @ s, weights * s) / (s @ (weights * s))


@pytest.mark.parametrize(
    ("n_lam", "symmetric", "left"), [(0, True, 0.75), (N_LAM, True, 0.75), (0, False, 0.75), (N_LAM, False, 0.85)]
)
def test_secants_save_iterations(n_lam: int, symmetric: bool, left: float):
    learning, as_it_is = (iterations(Problem(n_lam, symmetric), learns) for learns in (True, False))
    assert learning <= left * as_it_is < 100 * left


@pytest.mark.parametrize("symmetric", [True, False])
def test_a_correction_that_meets_no_stiffness_is_not_remembered(symmetric: bool):
    """The residual does not change along it: the update would divide by zero."""
    problem = Problem(symmetric=symmetric)
    g = problem.residual(problem.z)
    first = np.concatenate(problem.corrections(g, np.zeros(0)))
    second = np.concatenate(problem.corrections(g, np.zeros(0)))
    np.testing.assert_array_equal(first, second)


def test_more_broyden_steps_than_are_remembered_begin_anew():
    problem = Problem(symmetric=False)
    for _ in range(2 * MEMORY + 3):
        s = problem.correct()
    assert np.linalg.norm(s) < 1e-6 * np.linalg.norm(problem.z)
