"""Guesses of a vector from what an estimate was off by in the last steps."""

from __future__ import annotations

import numpy as np
import pytest

from lamella.differentiation.prediction import MEMORY, SERVES, Prediction

N = 30
MAGNITUDE = np.geomspace(1e-3, 1e3, N)


@pytest.fixture
def rng():
    return np.random.default_rng(7)


def swinging(rng, count):
    """Vectors in magnitudes over steps, each a sum of damped oscillations."""
    steps = np.arange(MEMORY + 6)
    rates = [-0.02 * (k + 1) + 0.5j * (k + 1) for k in range(count)]
    shapes = rng.standard_normal((count, N)) + 1j * rng.standard_normal((count, N))
    return MAGNITUDE * sum(np.exp(np.outer(steps, rate)) * shape for rate, shape in zip(rates, shapes, strict=True)).real


def test_oscillations_are_predicted_once_they_were_seen(rng):
    estimate, errors = rng.standard_normal(N) * MAGNITUDE, 1e-2 * swinging(rng, MEMORY // 2)
    prediction = Prediction(MAGNITUDE)
    assert prediction.guess(estimate) is None
    for off in errors[:-1]:
        prediction.learn(estimate, estimate + off)
    guess = prediction.guess(estimate)
    assert guess is not None
    assert np.abs((guess - estimate - errors[-1]) / MAGNITUDE).max() < 1e-9
    prediction.forget()
    assert prediction.guess(estimate) is None


def test_a_good_estimate_is_taken_as_it_is(rng):
    estimate, prediction = rng.standard_normal(N) * MAGNITUDE, Prediction(MAGNITUDE)
    prediction.learn(estimate, estimate + 0.1 * SERVES * rng.standard_normal(N) * MAGNITUDE)
    guess = prediction.guess(estimate)
    assert guess is not None
    np.testing.assert_array_equal(guess, estimate)


def test_what_cannot_be_predicted_is_not_guessed(rng):
    estimate, prediction = rng.standard_normal(N) * MAGNITUDE, Prediction(MAGNITUDE)
    for _ in range(3 * MEMORY):
        prediction.learn(estimate, estimate + rng.standard_normal(N) * MAGNITUDE)
        assert prediction.guess(estimate) is None
        assert prediction.unsteady


def test_what_is_not_known_yet_or_near_its_estimate_is_not_called_unsteady(rng):
    estimate, prediction = rng.standard_normal(N) * MAGNITUDE, Prediction(MAGNITUDE)
    assert not prediction.unsteady
    prediction.learn(estimate, 1.01 * estimate)
    assert not prediction.unsteady


def test_what_does_not_change_or_vanishes_is_predicted_too(rng):
    off, estimate, prediction = 1e-2 * rng.standard_normal(N), np.ones(N), Prediction(np.ones(N))
    for _ in range(4):  # equal vectors depend on each other
        prediction.learn(estimate, estimate + off)
    guess = prediction.guess(estimate)
    assert guess is not None
    np.testing.assert_allclose(guess, estimate + off, rtol=1e-9)
    nothing = Prediction(np.ones(N))
    for _ in range(3):
        nothing.learn(np.zeros(N), np.zeros(N))
    guess = nothing.guess(np.zeros(N))
    assert guess is None or not guess.any()
