"""Generalised conjugate residuals for several right-hand sides."""

from __future__ import annotations

import numpy as np
import pytest

from lamella.differentiation.residuals import ConjugateResiduals

N, MOST = 21, 12


@pytest.fixture
def rng():
    return np.random.default_rng(7)


def near_one(rng, n):
    return np.eye(n) + 0.05 * rng.standard_normal((n, n)) / np.sqrt(n)


def solved(known, C, b, z=None, *, B=None, enough=1e-12):
    """The solution and the number of products; C z = b, or with B the solution of B C z = b."""
    inverse = np.eye(len(b)) if B is None else np.linalg.inv(B)
    A = C if B is None else B @ C
    force = b - (0.0 if z is None else A @ z)
    share = known.begin(z, inverse @ force, force[: len(known.force)])
    for count in range(2 * MOST):
        if share <= enough:
            return known.solution(), count
        rest = -A @ known.left
        share = known.improve(inverse @ rest, rest[: len(known.force)])
    raise AssertionError(f"{share} is left")


@pytest.mark.parametrize("n_lam", [0, 3])
def test_solutions_are_those_of_the_system_and_directions_serve_the_next(rng, n_lam):
    n, magnitude = N - n_lam, np.geomspace(1e-2, 1e2, N)
    C = near_one(rng, N) * magnitude[:, None] / magnitude  # of like size in magnitudes
    C[:, n:] = np.eye(N)[:, n:]  # multipliers do not count, and are right once the unknowns are
    known = ConjugateResiduals(1.0 / magnitude[:n], n_lam, MOST)
    b = rng.standard_normal((2, N)) * magnitude
    first, count = solved(known, C, b[0])
    np.testing.assert_allclose(first / magnitude, np.linalg.solve(C, b[0]) / magnitude, atol=1e-10)
    assert 3 <= count <= MOST
    again, none = solved(known, C, b[0])  # what is known already
    assert none <= 1
    np.testing.assert_allclose(again / magnitude, first / magnitude, atol=1e-9)
    start = np.linalg.solve(C, b[1]) + 1e-6 * rng.standard_normal(N) * magnitude
    second, fewer = solved(known, C, b[1], start)
    np.testing.assert_allclose(second / magnitude, np.linalg.solve(C, b[1]) / magnitude, atol=1e-10)
    assert fewer < count
    known.forget()
    other = near_one(rng, N) * magnitude[:, None] / magnitude
    other[:, n:] = np.eye(N)[:, n:]
    third, _ = solved(known, other, b[0])
    np.testing.assert_allclose(third / magnitude, np.linalg.solve(other, b[0]) / magnitude, atol=1e-10)


def test_more_directions_than_are_kept_begin_anew(rng):
    C = np.eye(N) + 0.2 * rng.standard_normal((N, N)) / np.sqrt(N)
    b = rng.standard_normal(N)
    found, count = solved(ConjugateResiduals(np.ones(N), 0, 5), C, b)
    assert count > 5
    np.testing.assert_allclose(found, np.linalg.solve(C, b), atol=1e-9)


def test_nothing_asked_for_is_nothing():
    known = ConjugateResiduals(np.ones(N), 0, MOST)
    for known.by_energy in (False, True):
        assert known.begin(None, np.zeros(N), np.zeros(N)) == 0.0
        assert not known.solution().any()


def stiff_and_soft(rng, coupling):
    """Two sets of springs, one a million times as stiff, and a matrix near it that does not know how they are coupled: as much as
    membrane and bending of a plate that has bent since.
    """
    half = N // 3
    root = near_one(rng, N)
    B = root @ root.T
    B[:half, half:], B[half:, :half] = 0.0, 0.0
    scale = np.repeat([1e3, 1.0], [half, N - half])
    A = B.copy()
    A[:half, half:] = coupling * rng.standard_normal((half, N - half)) / np.sqrt(N)
    A[half:, :half] = A[:half, half:].T
    return A * scale * scale[:, None], B * scale * scale[:, None]


def energy(A, x):
    return np.sqrt(x @ A @ x)


@pytest.mark.parametrize("coupling", [0.03, 0.3])
def test_by_energy_a_solution_lacks_what_it_is_said_to(rng, coupling):
    A, B = stiff_and_soft(rng, coupling)
    C, known, b = np.linalg.solve(B, A), ConjugateResiduals(np.ones(N), 0, MOST), rng.standard_normal(N)
    exact, known.by_energy = np.linalg.solve(A, b), True
    for enough in (1e-3, 1e-6, 1e-9):
        known.forget()
        found, count = solved(known, C, b, B=B, enough=enough)
        assert count >= 1
        assert energy(A, found - exact) <= 3.0 * enough * energy(A, exact)
        np.testing.assert_allclose(known.force, b - A @ (found - known.left), atol=1e-9 * np.abs(b).max())
        np.testing.assert_allclose(B @ known.left, known.force, atol=1e-9 * np.abs(b).max())


def test_forces_need_fewer_directions_by_energy(rng):
    """What a set that is stiff and moves little lacks weighs as much in forces, and nothing in magnitudes."""
    A, B = stiff_and_soft(rng, 0.1)
    b, left = np.append(np.zeros(N // 3), rng.standard_normal(N - N // 3)), []
    for by_energy in (False, True):
        known = ConjugateResiduals(np.ones(N), 0, MOST)
        known.by_energy = by_energy
        known.begin(None, np.linalg.solve(B, b), b)
        for _ in range(2):
            rest = -A @ known.left
            known.improve(np.linalg.solve(B, rest), rest)
        left.append(energy(A, known.solution() - np.linalg.solve(A, b)))
    assert left[1] < 0.1 * left[0]


def test_an_energy_that_is_not_positive_is_told(rng):
    A, B = stiff_and_soft(rng, 0.1)
    known = ConjugateResiduals(np.ones(N), 0, MOST)
    known.by_energy = True
    b = rng.standard_normal(N)
    known.begin(None, np.linalg.solve(-B, b), b)
    rest = -A @ known.left
    assert np.isnan(known.improve(np.linalg.solve(-B, rest), rest))
