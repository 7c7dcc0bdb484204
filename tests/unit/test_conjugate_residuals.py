"""Generalised conjugate residuals for several right-hand sides."""

from __future__ import annotations

import numpy as np
import pytest

from lamella.differentiation.conjugate_gradients import ConjugateGradients
from lamella.differentiation.residuals import ConjugateResiduals

N, MOST = 21, 12


@pytest.fixture
def rng():
    return np.random.default_rng(7)


def near_one(rng, n):
    return np.eye(n) + 0.05 * rng.standard_normal((n, n)) / np.sqrt(n)


def solved(known, C, b, z=None):
    """The solution of C z = b and the number of products."""
    left = b - (0.0 if z is None else C @ z)
    share = known.begin(z, left, left)
    for count in range(2 * MOST):
        if share <= 1e-12:
            return known.solution(), count
        share = known.improve(-C @ known.left)
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
    for known in (ConjugateResiduals(np.ones(N), 0, MOST), ConjugateGradients(np.ones(N), MOST)):
        assert known.begin(None, np.zeros(N), np.zeros(N)) == 0.0
        assert not known.solution().any()
