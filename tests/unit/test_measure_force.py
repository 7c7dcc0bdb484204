"""Forces from measures: derivative of the energy, exact tangents, power balance; springs, stops and latches as they say."""

from __future__ import annotations

from math import inf

import numpy as np
import pytest
from measure_cases import MEASURES, N, configuration, derivative

from lamella.math.profile import Constant, Harmonic, Step
from lamella.measure.force import MeasureForce
from lamella.measure.law import LatchLaw, SpringLaw, StopLaw

TIME = 0.3


def engaged():
    law = LatchLaw(40.0, 3.0)
    law.engage(np.full(len(MEASURES), 0.2))
    return law


# The bounds of the stops lie so that the measures of MEASURES are partly inside, in the onset and beyond it.
LAWS = {
    "spring": lambda: SpringLaw(7.0, 0.0, Constant(0.4), Constant(0.0)),
    "actuator": lambda: SpringLaw(7.0, 0.0, Harmonic(0.3, 2.0), Harmonic(5.0, 1.0, mean=2.0)),
    "damped spring": lambda: SpringLaw(7.0, 1.3, Constant(0.4), Constant(-2.0)),
    "damper": lambda: SpringLaw(0.0, 1.3, Constant(0.0), Constant(0.0)),
    "stop": lambda: StopLaw(-0.3, 0.4, 30.0, 0.0, 0.8),
    "damped stop": lambda: StopLaw(-0.3, 0.4, 30.0, 0.2, 0.8),
    "upper stop": lambda: StopLaw(-inf, 0.1, 30.0, 0.0, 1e-3),
    "idle latch": lambda: LatchLaw(40.0, 3.0),
    "engaged latch": engaged,
}
laws = pytest.mark.parametrize("law", LAWS)
everywhere = pytest.mark.parametrize("seed", range(3))


def block_of(law: str) -> MeasureForce:
    shares = np.linspace(0.5, 1.5, len(MEASURES))
    return MeasureForce("block", list(MEASURES.values()), shares, LAWS[law]())


def force(block, q, v, t=TIME):
    f, total = np.empty(len(block.f_coords)), np.zeros(N)
    block.force(t, q, v, f)
    np.add.at(total, block.f_coords, block.f_scale * f)
    return total


def tangent(block, q, v, alpha_q, alpha_v):
    f, k, K = np.full(len(block.f_coords), np.nan), np.full(len(block.k_rows), np.nan), np.zeros((N, N))
    block.force_tangent(TIME, q, v, alpha_q, alpha_v, q, f, k)
    np.add.at(K, (block.k_rows, block.k_cols), block.k_scale * k)
    total = np.zeros(N)
    np.add.at(total, block.f_coords, f)
    np.testing.assert_allclose(total, force(block, q, v), rtol=1e-13, atol=1e-13)
    if block.symmetry == "symmetric":
        off = block.k_rows != block.k_cols
        np.add.at(K, (block.k_cols[off], block.k_rows[off]), (block.k_scale * k)[off])
    return K


@laws
@everywhere
def test_conservative_force_is_the_derivative_of_the_energy(law, seed):
    block, q, rest = block_of(law), configuration(seed), np.zeros(N)
    slopes = [derivative(lambda s, d=d: block.energy(TIME, q + s * d), 1e-4) for d in np.eye(N)]
    # a stop's energy has jumps in its third derivative, which leave h^2 of the stiffness
    np.testing.assert_allclose(force(block, q, rest), slopes, atol=1e-6 * max(1.0, np.abs(slopes).max()))


@laws
@everywhere
def test_tangent_is_the_derivative_of_the_force(law, seed):
    block, q, v = block_of(law), configuration(seed), 2.0 * configuration(seed + 50)
    K_q = np.stack([derivative(lambda s, d=d: force(block, q + s * d, v), 1e-5) for d in np.eye(N)], axis=1)
    K_v = np.stack([derivative(lambda s, d=d: force(block, q, v + s * d), 1e-3) for d in np.eye(N)], axis=1)
    K = tangent(block, q, v, 0.7, 1.9)
    np.testing.assert_allclose(K, 0.7 * K_q + 1.9 * K_v, atol=1e-7 * max(1.0, np.abs(K).max()))  # 1e-5 apart: rounding of 1e-10
    assert block.depends_on_velocity or not K_v.any()


@laws
@everywhere
def test_power_beyond_the_elastic_force_is_turned_into_heat(law, seed):
    block, q, v = block_of(law), configuration(seed), 3.0 * configuration(seed + 50)
    heat = block.dissipation(TIME, q, v)
    assert heat >= 0.0
    damping, buffer = force(block, q, v) - force(block, q, np.zeros(N)), np.empty(len(block.f_coords))
    assert heat == pytest.approx(v @ damping, rel=1e-10, abs=1e-10)
    block.damping_force(TIME, q, v, buffer)
    summed = np.bincount(block.f_coords, buffer * block.f_scale, minlength=N)
    np.testing.assert_allclose(summed, damping, atol=1e-10 * max(1.0, np.abs(damping).max()))


def test_a_stop_pushes_only_and_grows_smoothly():
    law, m = StopLaw(-1.0, 2.0, 100.0, 0.5, 0.01), np.linspace(-1.1, 2.1, 3201)
    for rate in (-50.0, -2.0, 0.0, 2.0, 50.0):
        F, F_m, _ = law.force(0.0, m, np.full_like(m, rate))
        assert np.all(F[m > 2.0] >= 0.0)
        assert np.all(F[m < -1.0] <= 0.0)
        assert not F[(m >= -1.0) & (m <= 2.0)].any()
        assert np.all(F_m >= 0.0)
    F, F_m, _ = law.force(0.0, np.array([2.0, 2.005, 2.01, 2.05]), np.zeros(4))
    np.testing.assert_allclose(F, [0.0, 100 * 0.005**2 / 0.02, 0.5, 4.5], atol=1e-11)
    np.testing.assert_allclose(F_m, [0.0, 50.0, 100.0, 100.0], atol=1e-10)


def test_energy_of_a_stop_is_the_work_done_against_it():
    """Over all three stretches: a constant missing beyond the onset would be seen."""
    law, m = StopLaw(-inf, 2.0, 100.0, 0.0, 0.01), np.linspace(1.99, 2.05, 6001)
    F = law.force(0.0, m, np.zeros_like(m))[0]
    work = np.concatenate([[0.0], np.cumsum(0.5 * (F[1:] + F[:-1]) * np.diff(m))])
    np.testing.assert_allclose(law.energy(0.0, m), work, atol=1e-8)  # trapezoidal rule: k/w dm^2/12 times the stretch is 8e-10


def test_a_latch_holds_from_engagement_until_reset():
    block, q, v = block_of("idle latch"), configuration(0), configuration(1)
    assert not force(block, q, v).any()
    assert block.energy(TIME, q) == block.dissipation(TIME, q, v) == 0.0
    assert not tangent(block, q, v, 1.0, 1.0).any()
    block.measures.evaluate(q)
    block.law.engage(block.measures.values)
    assert block.energy(TIME, q) == 0.0  # it holds what it finds
    assert not force(block, q, 0.0 * v).any()
    assert force(block, q, v).any()
    elsewhere = configuration(2)
    assert block.energy(TIME, elsewhere) > 0.0
    assert force(block, elsewhere, 0.0 * v).any()
    block.reset()
    assert not force(block, q, v).any()


def test_jumps_of_an_actuator_are_breakpoints():
    assert SpringLaw(1.0, 0.0, Step(at=0.5), Step(at=0.2)).breakpoints == (0.5, 0.2)
