"""Recording at given times: steps go their own way, and what is recorded between them has the order of the method."""

from __future__ import annotations

import numpy as np
import pytest
from test_bdf import TIGHT, on_a_spring

import lamella as lm

EVERY = 0.0137  # no divisor of any step below


@pytest.mark.parametrize(
    ("integrator", "order"),
    [
        (lambda dt: lm.GeneralizedAlpha(dt=dt, rho_inf=0.8, newton=TIGHT), 2),
        (lambda dt: lm.BDF(dt=dt, tolerance=None, max_order=2, newton=TIGHT), 2),
        (lambda dt: lm.BDF(dt=dt, tolerance=None, max_order=4, newton=TIGHT), 4),
    ],
    ids=["generalised-alpha", "BDF 2", "BDF 4"],
)
def test_what_is_recorded_between_steps_has_the_order_of_the_method(integrator, order):
    """z = 0.9 + 0.1 cos 5t: halving the step divides errors by 2^order; a share of 0.2 is left to terms of higher order."""
    errors = []
    for dt in (0.02, 0.01):
        result = lm.simulate(on_a_spring(), 1.0, integrator(dt), every=EVERY, stride=10**6)
        t = result.at[1:-1]  # the last is a step
        np.testing.assert_allclose(t, EVERY * np.arange(1, len(t) + 1), rtol=1e-12)
        z, v = (result[name].values[1:-1, 2] for name in ("ball.position", "ball.velocity"))
        errors.append([np.abs(z - 0.9 - 0.1 * np.cos(5 * t)).max(), np.abs(v + 0.5 * np.sin(5 * t)).max()])
    assert np.all(np.log2(np.divide(*errors)) > order - 0.2)
    assert np.all(np.array(errors[0]) > 1e-8)  # above rounding and Newton's tolerance


@pytest.mark.parametrize("integrator", [lm.GeneralizedAlpha(dt=1e-3, tolerance=1e-4), lm.BDF(dt=1e-3, tolerance=1e-4)])
def test_recording_does_not_shorten_steps(integrator):
    coarse, fine = (lm.simulate(on_a_spring(), 1.0, integrator, every=every, stride=10**6) for every in (0.1, 1e-3))
    assert coarse.statistics.steps == fine.statistics.steps < 150  # 1000 times are recorded
    assert len(fine.at) == 1001
    np.testing.assert_array_equal(coarse.final.q, fine.final.q)


@pytest.mark.parametrize("stride", [1, 3, 10**6])
def test_times_that_are_steps_are_recorded_once_whatever_the_stride(stride):
    result = lm.simulate(on_a_spring(), 0.1, lm.GeneralizedAlpha(dt=1e-3), every=2e-3, stride=stride)
    chosen = np.abs(result.at[:, None] - 2e-3 * np.arange(51)).argmin(axis=0)
    np.testing.assert_allclose(result.at[chosen], 2e-3 * np.arange(51), atol=1e-12)
    assert len(result.at) == {1: 101, 3: 51 + 17, 10**6: 51}[stride]  # of 33 steps counted by threes, 17 are odd
    assert np.diff(result.at).min() > 1e-4


def test_each_time_is_recorded_once_whatever_the_rounding_of_steps():
    """Late in a day steps end beside the times asked for, by more than the share of a step that counts as none."""
    late = lm.GeneralizedAlpha(dt=1e-3)
    result = lm.simulate(on_a_spring(), 1e5 + 0.3, late, t_start=1e5, every=0.01, stride=10**6)
    assert len(result.at) == 31
    np.testing.assert_allclose(result.at - 1e5, 0.01 * np.arange(31), atol=1e-8)
