"""Constraints on measures: derivatives against differences along a motion, drives over many turns, tables of entries."""

from __future__ import annotations

import numpy as np
import pytest
from measure_cases import MEASURES, N, configuration, derivative, oracle, rows, second_derivative

import lamella as lm
from lamella.kinematics import VectorRows
from lamella.math.profile import Constant, Harmonic, Polynomial, TrapezoidalSpeed
from lamella.measure.constraint import MeasureConstraint, MeasureRow
from lamella.measure.measure import angle

TIME = 0.3
everywhere = pytest.mark.parametrize("seed", range(4))


def make():
    """All kinds in one block, some with a motion, some fixed."""
    motions = [Harmonic(0.3, 1.5, phase=0.4), None, Polynomial((0.1, 0.5, -0.2), t_end=2.0)]
    found = [MeasureRow(name, measure, 0.2, motions[i % 3]) for i, (name, measure) in enumerate(MEASURES.items())]
    return MeasureConstraint("block", found)


def phi(block, q, t=TIME):
    out = np.full(block.n_lam, np.nan)
    block.phi(t, q, out)
    return out


def jacobian(block, q, t=TIME):
    out, J = np.full(len(block.j_rows), np.nan), np.zeros((block.n_lam, N))
    block.jacobian(t, q, out)
    np.add.at(J, (block.j_rows, block.j_cols), out)
    return J


def curvature(block, q, lam):
    out, K = np.full(len(block.k_rows), np.nan), np.zeros((N, N))
    block.curvature(TIME, q, lam, out)
    np.add.at(K, (block.k_rows, block.k_cols), out)
    return K + np.triu(K, 1).T


@everywhere
def test_rows_are_measures_less_what_is_prescribed(seed):
    block, q = make(), configuration(seed)
    for row, value in zip(block.rows, phi(block, q), strict=True):
        wanted = row.constant + (row.motion.value(TIME) if row.motion else 0.0)
        turns = (value - (oracle(row.measure, q).real - wanted)) / (2 * np.pi)
        assert turns == pytest.approx(round(turns), abs=1e-12)


@everywhere
def test_jacobian_and_curvature_are_derivatives(seed):
    block, q = make(), configuration(seed)
    lam = np.random.default_rng(seed).uniform(-2.0, 2.0, block.n_lam)
    J = np.stack([derivative(lambda s, d=d: phi(block, q + s * d), 1e-4) for d in np.eye(N)], axis=1)
    K = np.stack([derivative(lambda s, d=d: jacobian(block, q + s * d).T @ lam, 1e-4) for d in np.eye(N)], axis=1)
    # fourth-order differences 1e-4 apart: rounding of 1e-16 / 1e-4 and its growth where an angle's vectors are short
    np.testing.assert_allclose(jacobian(block, q), J, atol=1e-9 * np.abs(J).max())
    np.testing.assert_allclose(curvature(block, q, lam), K, atol=1e-9 * np.abs(K).max())


@everywhere
def test_velocity_and_acceleration_equations_hold_along_a_motion(seed):
    block, q, v, a = make(), configuration(seed), configuration(seed + 20), configuration(seed + 40)

    def along(s):
        return phi(block, q + s * v + 0.5 * s**2 * a, TIME + s)

    rate, gamma = np.full(block.n_lam, np.nan), np.full(block.n_lam, np.nan)
    block.phi_t(TIME, q, rate)
    block.gamma(TIME, q, v, gamma)
    J = jacobian(block, q)
    first, second = derivative(along, 1e-4), second_derivative(along, 1e-3)
    np.testing.assert_allclose(J @ v + rate, first, atol=1e-9 * max(1.0, np.abs(first).max()))
    np.testing.assert_allclose(J @ a + gamma, second, atol=1e-6 * max(1.0, np.abs(second).max()))


def test_entries_are_listed_as_the_contract_says():
    block = make()
    assert np.all(block.k_rows <= block.k_cols)
    assert block.j_rows.min() == 0
    assert block.j_rows.max() == block.n_lam - 1
    assert len(block.labels) == block.n_lam
    assert block.moves
    assert block.breakpoints == (0.0, 2.0) * 3


@pytest.mark.parametrize("factor", [1.0, -1.0, 3.0])
def test_a_driven_angle_may_turn_any_number_of_times(factor):
    x, z = VectorRows.fixed(np.array([1.0, 0, 0])), VectorRows.fixed(np.array([0, 0, 2.0]))
    measure = (angle(x, rows([0], [1.0]), z, factor),)
    drive = TrapezoidalSpeed(t_end=10.0, end=50.0, ramp=0.5)
    block = MeasureConstraint("drive", [MeasureRow("the angle", measure, motion=drive)])
    for t in (0.0, 1.0, 3.3, 5.0, 9.0, 10.0):
        for error in (0.0, 0.9, -0.9):
            phase = drive.value(t) / factor + error
            q = np.array([np.cos(phase), np.sin(phase), 0.3])
            out = np.empty(1)
            block.phi(t, q, out)
            assert out[0] == pytest.approx(factor * error, abs=1e-12)


def test_a_shared_angle_may_be_driven_past_half_a_turn():
    """A hinge folded flat: its shares lie on both sides of half a turn, and their mean is what is driven."""
    x, z = VectorRows.fixed(np.array([1.0, 0, 0])), VectorRows.fixed(np.array([0, 0, 1.0]))
    shares = tuple(angle(x, rows([k], [1.0]), z, 0.5) for k in range(2))
    block = MeasureConstraint("drive", [MeasureRow("the angle", shares, motion=Constant(np.pi), shared=True)])
    q = np.array([part for phase in (np.pi + 0.1, np.pi - 0.04) for part in (np.cos(phase), np.sin(phase), 0.0)])
    out = np.empty(1)
    block.phi(0.0, q, out)
    assert out[0] == pytest.approx(0.03, abs=1e-12)


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("by", ["angle", "speed"])
def test_a_folded_hinge_is_driven_across_half_a_turn(by, sign):
    """The second plate lies back over the first one, where the angle jumps from pi to -pi, and is driven either way."""
    section = lm.Laminate(lm.Isotropic(E=70e9, nu=0.3, rho=2700.0), thickness=0.01)
    system = lm.System()
    still = system.add(lm.Plate("still", (1.0, 0.5), (1, 1), section))
    moving = system.add(lm.Plate("moving", (1.0, 0.5), (1, 1), section, position=(1.0, 0.0, 0.0), rotation=(0.0, -np.pi, 0.0)))
    system.add(lm.Clamp("root", still.edge("x-")))
    hinge = system.add(lm.EdgeHinge("hinge", still.edge("x+"), moving.edge("x-")))
    if by == "angle":
        drive = lm.AngleDrive("drive", hinge, angle=lm.SmoothStep(t_end=0.2, start=np.pi, end=np.pi + 0.1 * sign))
    else:
        drive = lm.AngleDrive("drive", hinge, speed=lm.Cycloid(t_end=0.2, end=sign))  # on the average 0.5 rad/s over 0.2 s
    system.add(drive)
    angle = lm.simulate(system, 0.2, lm.GeneralizedAlpha(dt=1e-2))["hinge.angle"].values
    # the hinge's signal is the angle in its middle, the drive moves the mean along the edge: the plates bend in between
    assert angle[-1] - angle[0] == pytest.approx(0.1 * sign, abs=1e-3)
