"""The linear model and the design of the example web-guide, without running the shell."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import lamella as lm
from lamella.examples.web_guide.theory import Web, answer, closed_loop, delay, designed, fitted, open_loop, with_share

WEB = Web(radius=0.1, span=0.6, speed=4.0, servo=0.025)
T = np.arange(0.0, 2.0, 0.005)
NONE = 0.0 * T


def test_the_delay_is_that_of_the_wrap() -> None:
    """Padé's [3/3] of exp(-s): its phase is 0.3 % off at 2.4 rad, and its gain is one."""
    a, b, c, d = delay(1.0)
    for omega in (0.1, 1.0, 2.4):
        found = complex(c @ np.linalg.solve(1j * omega * np.eye(3) - a, b) + d)
        assert abs(found) == pytest.approx(1.0, abs=1e-12)
        assert np.angle(found) == pytest.approx(-omega, abs=0.01)


def test_a_turned_roller_carries_the_belt_by_its_diameter_in_each_turn() -> None:
    z = answer(WEB, T, np.full_like(T, 0.01), NONE)
    turn = WEB.length / WEB.speed
    late = T > 1.5
    assert np.polyfit(T[late], z[late], 1)[0] * turn == pytest.approx(-2 * 0.1 * 0.01, rel=1e-3)
    assert WEB.rate * 0.01 * turn == pytest.approx(-2 * 0.1 * 0.01, rel=1e-12)
    assert 0.3e-3 < z.max() < 0.5e-3  # at first the other way: at most half of r phi, seen midway


def test_misalignment_moves_an_ideal_web_as_its_kinematics_say() -> None:
    """In steady drift both strands have the slope z'/v; around the loop 2 (span + pi r) z'/v = span psi."""
    z = answer(WEB, T, NONE, np.full_like(T, 0.005))
    late = T > 1.5
    expected = 0.005 * WEB.speed * WEB.span / WEB.length
    assert np.polyfit(T[late], z[late], 1)[0] == pytest.approx(expected, rel=1e-3)


def test_a_fit_finds_the_factors_of_a_web() -> None:
    other = replace(WEB, lag=0.9, lever=1.1, share=0.5)
    u, psi = np.full_like(T, 0.01), np.full_like(T, 0.005)
    found = fitted(WEB, T, u, answer(other, T, u, NONE))
    assert (found.lag, found.lever) == pytest.approx((0.9, 1.1), rel=1e-5)
    assert with_share(found, T, psi, answer(other, T, NONE, psi)).share == pytest.approx(0.5, rel=1e-4)


@pytest.mark.parametrize(("margin", "corner"), [(50.0, 5.0), (60.0, 4.0)])
def test_the_design_has_its_phase_margin_and_holds_the_edge(margin: float, corner: float) -> None:
    model, period = WEB.state_space(), 0.01
    found = designed(model, period, np.radians(margin), corner)
    controller = found.proportional + found.integral / (1j * found.crossover)
    loop = open_loop(model, found.crossover, period) * controller
    assert abs(loop) == pytest.approx(1.0, rel=1e-9)
    assert np.degrees(np.angle(loop)) == pytest.approx(margin - 180.0, abs=1e-6)
    t = np.arange(0.0, 20.0, 0.5 * period)
    law = lm.PID(found.proportional, found.integral, reference=1e-3, limit=0.05)
    edge, command = closed_loop(replace(WEB, share=0.5), law, period, t, np.full_like(t, 0.005), 0.0)
    assert edge[-1] == pytest.approx(1e-3, abs=2e-5)  # the integral carries the misalignment: exp(-8) is left
    assert command[-1] == pytest.approx(-0.5 * 0.005 * WEB.span * WEB.speed / WEB.length / WEB.rate, rel=0.02)
    assert np.abs(command).max() <= 0.05
