"""The first-order generalised-alpha rule: order, fast modes, the trapezoidal rule, local error, and steps that follow it."""

from __future__ import annotations

import numpy as np
import pytest

import lamella as lm
from lamella.integrate.first_order import FirstOrderRule

RHOS = [0.0, 0.5, 0.8, 1.0]


def solved(rho, rate, n, t_end=1.0, load=lambda t: 0.0):
    """T' = rate T + load(t) from 1 in n steps, with the equation met at the end of each."""
    rule, dt, T = FirstOrderRule(rho), t_end / n, np.ones(1)
    Td = rate * T + load(0.0)
    rule.restart(Td)
    for k in range(1, n + 1):
        T_0, Td_0 = rule.predicted(dt, T, Td)
        w = rule.weight(dt)
        du = (rate * T_0 + load(k * dt) - Td_0) / (w - rate)
        T_new, Td_new = T_0 + du, Td_0 + w * du
        s = rule.algorithmic(Td, Td_new)
        # what the rule says of the new values, from the new algorithmic rate
        np.testing.assert_allclose(
            T_new, T + dt * ((1 - rule.gamma) * rule.s + rule.gamma * s), rtol=1e-12, atol=1e-14 * (1 + dt * abs(rule.s[0]))
        )
        rule.accept(dt, s)
        T, Td = T_new, Td_new
    return T[0], rule


@pytest.mark.parametrize("rho", RHOS)
def test_second_order(rho):
    def error(n):
        # T' = -2 T + sin 3t has the particular solution (2 sin 3t - 3 cos 3t) / 13
        exact = (1 + 3 / 13) * np.exp(-2.0) + (2 * np.sin(3.0) - 3 * np.cos(3.0)) / 13
        return abs(solved(rho, -2.0, n, load=lambda t: np.sin(3 * t))[0] - exact)

    assert np.log2(error(40) / error(80)) == pytest.approx(2.0, abs=0.1)  # a step is 5 % and 2.5 % of the time constant


@pytest.mark.parametrize("rho", RHOS)
def test_fast_modes_shrink_by_rho(rho):
    """Steps far beyond the time constant; -rho is a double root of the limit, so that values go like n rho^n."""
    later, before = solved(rho, -1e9, 41)[0], solved(rho, -1e9, 40, t_end=40 / 41)[0]
    assert abs(later) <= 1.03 * rho * abs(before) + 1e-12  # (n + 1) / n at n = 40
    assert abs(later) >= 0.97 * rho * abs(before)


def test_rho_of_one_is_the_trapezoidal_rule():
    z = -0.7
    assert solved(1.0, z * 10, 10)[0] == pytest.approx(((1 + z / 2) / (1 - z / 2)) ** 10, rel=1e-13)


def test_error_is_that_of_the_trapezoidal_rule():
    rate, n = -1.0, 100
    T, rule = solved(1.0, rate, n)
    dt = 1.0 / n
    _, more = solved(1.0, rate, n + 1, t_end=1.0 + dt)
    # dt^3 T''' / 12, T''' = -T, from differences of the rate: relative error of the order of dt
    assert rule.error(dt, more.s)[0] == pytest.approx(dt**3 / 12 * rate**3 * T, rel=0.05)


def test_steps_of_unlike_length_scale_the_last_change():
    rule = FirstOrderRule(1.0)
    rule.restart(np.array([1.0]))
    rule.accept(0.1, np.array([1.2]))  # a rate that grows by 2 a second
    assert rule.error(0.2, np.array([1.6]))[0] == pytest.approx(0.0, abs=1e-16)
    assert rule.error(0.2, np.array([1.9]))[0] == pytest.approx(0.2 / 12 * 0.3)


def cooled(tolerance=None, t_end=400.0, options=None):
    """A plate of 400 K at rest in air of 300 K, whose temperature relaxes with rho c h / (2 h_c) = 90 s."""
    sheet = lm.Laminate(lm.Isotropic(E=1e9, nu=0.3, rho=2000.0, k=1.5, c=900.0), thickness=0.01)
    system = lm.System()
    plate = system.add(lm.Plate("plate", (0.2, 0.1), (2, 1), sheet, strain="rigid"))
    system.add(lm.TemperatureField("heat", plate, reference=300.0, initial=400.0))
    system.add(lm.Film("air", plate, 100.0, 300.0))
    options = options or lm.GeneralizedAlpha(dt=0.05, tolerance=tolerance, rho_inf=0.8)
    result = lm.simulate(system, t_end, options)
    error = result["heat.mean"].values - (300.0 + 100.0 * np.exp(-result.at / 90.0))
    return result, float(np.abs(error).max())


def test_tolerance_of_steps_bounds_the_error_of_temperatures():
    """A tolerance of the local error in units of 100 K; over a time constant some steps of it add up, and decay after that."""
    coarse, coarse_error = cooled(1e-4)
    fine, fine_error = cooled(1e-6)
    assert coarse_error <= 1e-4 * 100.0 * coarse.statistics.steps
    assert fine_error <= 1e-6 * 100.0 * fine.statistics.steps
    # steps with the cube root of the tolerance, 100^(1/3) = 4.6, errors with its square, 22
    assert 3.0 < fine.statistics.steps / coarse.statistics.steps < 6.0
    assert fine_error < 0.1 * coarse_error


def test_steps_grow_as_the_temperature_settles():
    result, _ = cooled(1e-5)
    steps = np.diff(result.at)
    assert steps[-3] > 3.0 * np.median(steps[5:15])
