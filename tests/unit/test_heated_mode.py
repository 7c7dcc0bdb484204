"""The closed forms of the example thermal-flutter: against integration in time, limits, and the modes of a beam."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import lamella as lm
from lamella.examples.thermal_flutter.theory import FirstMode, first_mode

MODE = FirstMode(omega=1.3, tau=0.7, push=0.06, gain=0.07, rest=0.06)


@pytest.mark.parametrize("mode", [MODE, MODE.uncoupled, MODE.mirrored])
def test_response_solves_the_equations(mode: FirstMode) -> None:
    """y'' + 2 zeta omega y' + omega^2 (y + u) = 0, tau u' + u = push + gain y from rest, by an integrator of order 8."""
    w, zeta, t = mode.omega, 0.01, np.linspace(0.0, 30.0, 61)

    def rates(_: float, x: np.ndarray) -> list[float]:
        y, v, u = x
        return [v, -2 * zeta * w * v - w**2 * (y + u), (mode.push + mode.gain * y - u) / mode.tau]

    exact = solve_ivp(rates, (0.0, 30.0), [0.0, 0.0, 0.0], "DOP853", t, rtol=1e-11, atol=1e-13).y[0]
    np.testing.assert_allclose(mode.response(zeta, t), exact, atol=1e-10)  # the integrator's tolerance, over 30 s
    free = np.abs(exact + mode.push / (1 + mode.gain))
    late = t > 15.0  # the heat's own root has left e^-20
    envelope = mode.amplitude(zeta) * np.exp(mode.pole(zeta).real * t)
    assert np.all(free[late] <= envelope[late] * (1 + 1e-6))
    assert np.max(free[late] / envelope[late]) > 0.9  # samples lie within 0.33 rad of the phase of every peak, cos 0.33 = 0.95


def test_amplitude_of_boley() -> None:
    """Without damping and coupling the vibration has the part 1 / sqrt(1 + (omega tau)^2) of the static deflection."""
    assert MODE.uncoupled.amplitude(0.0) == pytest.approx(MODE.push / np.hypot(1.0, 1.3 * 0.7), rel=1e-12)


@pytest.mark.parametrize("tau", [0.05, 0.7, 8.0])
def test_limit_of_routh_and_hurwitz_has_an_imaginary_root(tau: float) -> None:
    mode = replace(MODE, tau=tau)
    limit = mode.critical_damping()
    assert mode.pole(limit).real == pytest.approx(0.0, abs=1e-12)
    assert mode.pole(0.9 * limit).real > 0.0 > mode.pole(1.1 * limit).real
    p = mode.delay
    assert limit == pytest.approx(mode.gain * p / (2 * (1 + p**2)), rel=2 * mode.gain)  # to first order in the gain
    assert mode.mirrored.critical_damping() < 0.0


def test_integrals_of_a_beam() -> None:
    """For a strip without lateral contraction gain = phi'(L)^2 / (2 int phi''^2) alpha g s_x, phi being a clamped beam's."""
    sheet = lm.Laminate(lm.Isotropic(E=2e9, nu=0.0, rho=40, alpha=2e-5, k=0.4, c=900), thickness=0.01)
    system = lm.System()
    plate = system.add(lm.Plate("panel", size=(6.0, 0.2), mesh=(8, 1), laminate=sheet, markers={"tip": (6.0, 0.1)}))
    system.add(lm.Clamp("root", plate.edge("x-"), kind="restrained"))
    system.add(lm.TemperatureField("heat", plate))
    system.add(lm.SolarFlux("sun", plate, direction=(0.8, 0.0, -0.6), absorptivity=0.5, constant=1000.0, profile=lm.Step(at=1.0)))
    mode = first_mode(system)
    bent = 2e-5 * 0.5 * 1000.0 / (2 * 0.4)  # alpha g [1/m]
    # Eight cubic elements have the frequency to 1e-5; positions and slopes follow to the square root of that.
    assert mode.omega == pytest.approx(1.8751041**2 / 36 * np.sqrt(2e9 * 1e-4 / 12 / 40), rel=1e-4)
    assert mode.tau == pytest.approx(40 * 900 * 1e-4 / (12 * 0.4), rel=1e-12)
    assert mode.gain == pytest.approx(0.30654 * bent * 6.0 * 0.8, rel=1e-3)
    assert mode.push == pytest.approx(0.44538 * bent * 0.6 * 36, rel=1e-3)
    angle = bent * 0.6 * 6.0  # at rest the strip is an arc of a circle
    assert mode.rest == pytest.approx(6.0 * (1 - np.cos(angle)) / angle, rel=1e-3)
    assert mode.pole_of_four(0.01).real > mode.pole(0.01).real
