"""Angles count turns: couplings, springs, stops and latches work over any number of them; trial steps do not disturb."""

from __future__ import annotations

import numpy as np
import pytest

import lamella as lm
from lamella.kinematics import VectorRows
from lamella.measure.force import MeasureForce
from lamella.measure.law import SpringLaw
from lamella.measure.measure import MeasureSet, angle
from lamella.switch import SwitchedForce

X, Y, Z = (VectorRows.fixed(axis) for axis in np.eye(3))
TURNED = VectorRows(np.array([0]), np.ones(1), np.zeros(3))
STEP = lm.GeneralizedAlpha(dt=2e-3, rho_inf=0.8)
INERTIA = 0.2


def turned(phase: float) -> np.ndarray:
    return np.array([np.cos(phase), np.sin(phase), 0.0])


def wheels(n: int = 1) -> tuple[lm.System, list[lm.RevoluteJoint]]:
    """Wheels on pins along z, without gravity."""
    system, ground, joints = lm.System(), lm.Ground(), []
    for k in range(n):
        wheel = system.add(lm.RigidBody(f"wheel{k}", mass=1.0, inertia=(0.1, 0.1, INERTIA), position=(2.0 * k, 0.0, 0.0)))
        hub = wheel.marker(f"hub{k}", 0.0, 0.0, 0.0)
        joints.append(system.add(lm.RevoluteJoint(f"pin{k}", ground.marker(f"post{k}", 2.0 * k, 0.0, 0.0), hub)))
    return system, joints


def test_an_angle_follows_what_was_accepted_and_not_what_was_tried():
    found = MeasureSet([(angle(X, TURNED, Z, 2.0), angle(Y, TURNED, Z, -1.0))])
    for phase in np.linspace(0.0, 30.0, 21):
        for tried in (phase + 2.0, phase - 3.0):  # evaluations between two calls leave no trace
            found.evaluate(turned(tried))
        found.evaluate(turned(phase))
        assert found.values[0] == pytest.approx(2.0 * phase - (phase - np.pi / 2), abs=1e-12)
        found.follow()
    found.reset()
    found.evaluate(turned(0.5))
    assert found.values[0] == pytest.approx(1.0 - (0.5 - np.pi / 2), abs=1e-12)


def test_a_spring_counts_turns_while_it_is_switched_off():
    law = SpringLaw(3.0, 0.0, lm.Constant(0.0), lm.Constant(0.0))
    block = SwitchedForce(MeasureForce("spring", [(angle(X, TURNED, Z),)], np.ones(1), law), on=False)
    for phase in (2.0, 4.0, 6.0, 8.0):
        block.settle(0.0, turned(phase))
    block.on = True
    assert block.energy(0.0, turned(8.5)) == pytest.approx(1.5 * 8.5**2)
    block.reset()
    block.on = True
    assert block.energy(0.0, turned(8.5)) == pytest.approx(1.5 * (8.5 - 2 * np.pi) ** 2)


@pytest.mark.parametrize("stiffness", [None, 500.0], ids=["rigid", "elastic"])
def test_a_coupling_with_unequal_factors_works_over_several_turns(stiffness):
    system, joints = wheels(2)
    system.add(lm.AngleDrive("motor", joints[0], speed=lm.SmoothStep(t_end=0.5, end=15.0)))
    damping = 0.0 if stiffness is None else 5.0
    system.add(lm.AngleCoupling("gear", tuple(joints), (2, -1), stiffness=stiffness, damping=damping))
    model = system.compile()
    result, again = (lm.simulate(model, 1.1, STEP) for _ in range(2))
    driven, follower = result["pin0.angle"].values, result["pin1.angle"].values
    assert driven[-1] == pytest.approx(12.75, abs=1e-9)  # 0.85 s at 15 rad/s: two turns, and four of the other wheel
    # elastic: the twist the last oscillation leaves, which c = 5 N m s/rad against I = 0.2 kg m^2 damps within 0.1 s
    np.testing.assert_allclose(follower[-1], 25.5, atol=1e-9 if stiffness is None else 1e-3)
    if stiffness is None:
        np.testing.assert_allclose(follower, 2.0 * driven, atol=1e-8)  # Newton's tolerance
    torque = result["gear.torque"].values
    at = int(np.argmin(np.abs(result.at - 0.25)))
    # the wheel's inertia times its acceleration, at the top of a smooth step 1.875 times the mean; elastically amplified by the
    # square of 2 pi / 0.5 s over the natural 50 rad/s
    assert torque[at] == pytest.approx(INERTIA * 2.0 * 1.875 * 15.0 / 0.5, rel=1e-3 if stiffness is None else 0.06)
    for name in ("pin1.angle", "gear.torque", "energy.balance"):
        np.testing.assert_array_equal(result[name].values, again[name].values)


def test_a_wound_torsion_spring_unwinds_over_many_turns():
    system, joints = wheels()
    wound = -30.0  # four turns and three quarters from the rest angle
    system.add(lm.TorsionSpring("spring", joints[0], stiffness=0.5, rest_angle=-wound))
    model = system.compile()
    result = lm.simulate(model, 2.0, STEP)
    exact = -wound * (1.0 - np.cos(np.sqrt(0.5 / INERTIA) * result.at))
    assert exact.max() > 59.0
    # axes that turn by up to 0.1 rad in a step lag by some 0.1^2 / 12 of the angle
    np.testing.assert_allclose(result["spring.angle"].values, exact, atol=0.2)
    np.testing.assert_allclose(result["spring.angle"].values, result["pin0.angle"].values, atol=1e-9)
    np.testing.assert_array_equal(result["spring.angle"].values, lm.simulate(model, 2.0, STEP)["spring.angle"].values)


def test_stop_and_latch_act_after_several_turns():
    for extra in (
        lambda joint: lm.EndStop("stop", joint, upper=20.0, stiffness=1e4, damping=1.0),
        lambda joint: lm.Latch("stop", joint, at=20.0, stiffness=1e4, damping=60.0),
    ):
        system, joints = wheels()
        system.add(lm.TorsionSpring("motor", joints[0], preload=-2.0))  # a constant torque of 2 N m
        system.add(extra(joints[0]))
        angles = lm.simulate(system, 2.5, STEP)["pin0.angle"].values
        assert 20.0 <= angles.max() < 20.5  # 20 rad/s on arrival against 223 rad/s of the stiff spring: 0.09 rad, less by damping
        assert np.abs(np.diff(angles)).max() < 0.1


@pytest.mark.parametrize("tolerance", [None, 1e-5])
def test_steps_tried_with_several_lengths_do_not_disturb(tolerance):
    results = []
    for watched in (False, True):
        system, joints = wheels(2)
        system.add(lm.TorsionSpring("motor", joints[0], preload=-3.0))
        system.add(lm.AngleCoupling("gear", tuple(joints), (2, -1)))
        if watched:
            for k, level in enumerate((3.0, 3.2, 6.0, 20.0)):
                system.add(lm.Event(f"pass{k}", watch="pin1.angle", value=level, action="switch_off", target="absent"))
            system.add(lm.PointForce("absent", system.bodies[0].marker("any", 0.1, 0.0, 0.0), (0, 0, 1)))
        results.append(lm.simulate(system, 1.5, lm.GeneralizedAlpha(dt=5e-3, rho_inf=0.8, tolerance=tolerance)))
    for result in results:
        np.testing.assert_allclose(result["pin1.angle"].values, 2.0 * result["pin0.angle"].values, atol=1e-7)
    inertia = INERTIA + 4.0 * INERTIA
    for result in results:  # constant acceleration; the error of steps of 0.03 rad and more under error control
        assert result["pin0.angle"].values[-1] == pytest.approx(0.5 * 3.0 / inertia * 1.5**2, rel=5e-3)
    assert len(results[1].outcome.events) == 3
