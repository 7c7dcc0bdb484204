"""Conjugate gradients for several right-hand sides, with a factorisation that may be rough."""

from __future__ import annotations

import numpy as np
import pytest
from test_conjugate_residuals import MOST, N, near_one

from lamella.differentiation.conjugate_gradients import ConjugateGradients
from lamella.differentiation.residuals import ConjugateResiduals


@pytest.fixture
def rng():
    return np.random.default_rng(7)


def solved(known, A, b, divided, z=None, *, enough):
    """The solution of A z = b and the number of products; ``divided`` divides by a matrix near A."""
    force = b - (0.0 if z is None else A @ z)
    share = known.begin(z, divided(force), force)
    for count in range(2 * MOST):
        if share <= enough:
            return known.solution(), count
        share = known.improve(-A @ known.left, divided)
    raise AssertionError(f"{share} is left")


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
    known, b = ConjugateGradients(np.ones(N), MOST), rng.standard_normal(N)
    exact = np.linalg.solve(A, b)
    for enough in (1e-3, 1e-6, 1e-9):
        known.forget()
        found, count = solved(known, A, b, lambda force: np.linalg.solve(B, force), enough=enough)
        assert count >= 1
        assert energy(A, found - exact) <= 3.0 * enough * energy(A, exact)
        np.testing.assert_allclose(known.force, b - A @ (found - known.left), atol=1e-9 * np.abs(b).max())
        np.testing.assert_allclose(B @ known.left, known.force, atol=1e-9 * np.abs(b).max())


@pytest.mark.parametrize("coupling", [0.003, 0.01, 0.03])
def test_what_a_solution_lacks_is_told_from_the_second_direction_on(rng, coupling):
    """By what the last one has left, within a factor of four, however little that is; before, there is nothing to tell it by."""
    A, B = stiff_and_soft(rng, coupling)
    B += coupling * np.diag(rng.uniform(0.2, 1.0, N) * np.diag(B))
    for b in rng.standard_normal((20, N)):
        known, exact = ConjugateGradients(np.ones(N), MOST), np.linalg.solve(A, b)
        said = [known.begin(None, np.linalg.solve(B, b), b)]
        lacking = [energy(A, known.solution() - exact) / energy(A, exact)]
        for _ in range(2):
            said.append(known.improve(-A @ known.left, lambda force: np.linalg.solve(B, force)))
            lacking.append(energy(A, known.solution() - exact) / energy(A, exact))
        assert said[0] == pytest.approx(1.0, rel=0.1)
        for one, other in zip(said[1:], lacking[1:], strict=True):
            assert 0.25 * other < one < 4.0 * other


def test_forces_need_fewer_directions_by_energy(rng):
    """What a set that is stiff and moves little lacks weighs as much in forces, and nothing in magnitudes."""
    A, B = stiff_and_soft(rng, 0.1)
    b, left = np.append(np.zeros(N // 3), rng.standard_normal(N - N // 3)), []
    by_magnitude, by_energy = ConjugateResiduals(np.ones(N), 0, MOST), ConjugateGradients(np.ones(N), MOST)
    for known in (by_magnitude, by_energy):
        known.begin(None, np.linalg.solve(B, b), b)
        for _ in range(2):
            rest = -A @ known.left
            if known is by_magnitude:
                by_magnitude.improve(np.linalg.solve(B, rest))
            else:
                by_energy.improve(rest, lambda force: np.linalg.solve(B, force))
        left.append(energy(A, known.solution() - np.linalg.solve(A, b)))
    assert left[1] < 0.1 * left[0]


def test_an_energy_that_is_not_positive_is_told(rng):
    A, B = stiff_and_soft(rng, 0.1)
    known, b = ConjugateGradients(np.ones(N), MOST), rng.standard_normal(N)
    known.begin(None, np.linalg.solve(-B, b), b)
    assert np.isnan(known.improve(A @ known.left, lambda force: np.linalg.solve(-B, force)))


def test_directions_serve_the_next_right_hand_side(rng):
    A, B = stiff_and_soft(rng, 0.3)

    def divided(force):
        return np.linalg.solve(B, force)

    known, b = ConjugateGradients(np.ones(N), MOST), rng.standard_normal((2, N))
    first, count = solved(known, A, b[0], divided, enough=1e-9)
    again, none = solved(known, A, b[0], divided, enough=1e-6)
    assert none <= 1 < count
    for x in (first, again):
        assert energy(A, x - np.linalg.solve(A, b[0])) <= 3e-6 * energy(A, first)
    exact = np.linalg.solve(A, b[1])
    alone, from_zero = solved(ConjugateGradients(np.ones(N), MOST), A, b[1], divided, enough=1e-9)
    second, fewer = solved(known, A, b[1], divided, enough=1e-9)
    third, from_guess = solved(known, A, b[1], divided, exact * (1.0 + 1e-6 * rng.standard_normal(N)), enough=1e-3)
    assert fewer < from_zero
    assert from_guess < from_zero
    for x in (alone, second, third):
        assert energy(A, x - exact) <= 3e-9 * energy(A, exact)


def test_a_substitution_need_not_be_linear(rng):
    """Rounded to single numbers it leaves 1e-6 of a solution by residuals, and what is asked for by gradients."""
    A, B = stiff_and_soft(rng, 0.1)

    def divided(force):
        return np.linalg.solve(B, force).astype(np.float32).astype(float)

    b = rng.standard_normal(N)
    exact = np.linalg.solve(A, b)
    known = ConjugateGradients(np.ones(N), MOST)
    found, _ = solved(known, A, b, divided, enough=1e-11)
    assert energy(A, found - exact) <= 3e-11 * energy(A, exact)
    directions = known._directions.reshape(MOST, -1)[: known.known, :N]
    expected = rng.standard_normal(known.known) @ directions  # of which all is known
    known.begin(None, divided(A @ expected), A @ expected)
    by_images = energy(A, known.solution() - expected)
    known.renew(divided(known.force))
    assert energy(A, known.solution() - expected) < 1e-3 * by_images < 1e-8 * energy(A, expected)
