"""Moments of events against closed forms, with fixed and controlled steps, and what follows from what they change."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.special import ellipkinc

import lamella as lm
from lamella.result import Cause

G = 9.81
HEIGHT = 1.3
DT = 1e-2
STEP = lm.GeneralizedAlpha(dt=DT, rho_inf=0.9)


def falling(*extra) -> lm.System:
    """A body that falls from HEIGHT; ``extra`` are made from its marker."""
    system = lm.System()
    body = system.add(lm.RigidBody("body", mass=2.0, inertia=(0.1, 0.1, 0.1), position=(0.0, 0.0, HEIGHT)))
    centre = body.marker("centre", 0.0, 0.0, 0.0)
    system.add(lm.Gravity("gravity"))
    for make in extra:
        system.add(make(centre))
    return system


def event(name="event", value=0.0, **given):
    return lambda centre: lm.Event(name, **({"watch": "centre.position", "component": "z", "value": value} | given))


def pendulum(*extra) -> lm.System:
    """An arm let go along x that falls about y; ``extra`` are made from its joint."""
    system, ground = lm.System(), lm.Ground()
    arm = system.add(lm.RigidBody("arm", mass=2.0, inertia=(0.05, 0.2, 0.2), position=(0.5, 0.0, 0.0)))
    pin = system.add(lm.RevoluteJoint("pin", ground.origin, arm.marker("heel", -0.5, 0.0, 0.0), axis=(0, 1, 0)))
    system.add(lm.Gravity("gravity"))
    for make in extra:
        system.add(make(pin))
    return system


@pytest.mark.parametrize("tolerance", [None, 1e-4])
def test_a_falling_body_stops_at_the_floor(tolerance):
    integrator = lm.GeneralizedAlpha(dt=DT, rho_inf=0.9, tolerance=tolerance)
    result = lm.simulate(falling(event(action="stop", direction="falling")), 2.0, integrator)
    exact = np.sqrt(2.0 * HEIGHT / G)
    (happened,) = result.outcome.events
    longest = DT if tolerance is None else np.diff(result.at).max()
    # a constant acceleration is integrated exactly; the step ends a millionth of its length behind the event
    assert 0.0 <= happened.t - exact < 2e-6 * longest
    assert (result.outcome.cause, result.outcome.completed) == (Cause.EVENT, True)
    assert result.at[-1] == result.outcome.reached == happened.t
    assert (happened.name, happened.text) == ("event", "stop: z of centre.position passes 0")
    assert -2e-6 * longest * np.sqrt(2 * G * HEIGHT) < result["centre.position"].values[-1, 2] <= 0.0


def test_the_moment_of_a_pendulum_converges_with_the_square_of_the_step():
    """From rest along x to the angle a: t = F(phi, 1/2) / w, the incomplete elliptic integral, w^2 = m g s / I."""
    angle, frequency = 1.2, np.sqrt(2.0 * G * 0.5 / 0.7)
    # the pendulum falls from 90 degrees off the vertical to 90 - a; sin(amplitude/2)^2 = 1/2
    phi = np.arcsin(np.sin(0.5 * (np.pi / 2 - angle)) / np.sqrt(0.5))
    exact = (ellipkinc(np.pi / 2, 0.5) - ellipkinc(phi, 0.5)) / frequency
    errors = []
    for dt in (1e-2, 5e-3):
        watch = lm.Event("down", watch="pin.angle", value=angle, direction="rising", action="stop")
        result = lm.simulate(pendulum(lambda pin, watch=watch: watch), 2.0, lm.GeneralizedAlpha(dt=dt, rho_inf=0.9))
        errors.append(result.outcome.events[0].t - exact)
        assert result["pin.angle"].values[-1] == pytest.approx(angle, abs=2e-6 * dt * 5.0)  # 5 rad/s
    assert abs(errors[1]) < 5e-5
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.2)


@pytest.mark.parametrize(("action", "during"), [("switch_on", (0.0, 10.0)), ("switch_off", (10.0, 0.0))])
def test_a_force_is_switched_at_the_event(action, during):
    def force(centre):
        return lm.PointForce("push", centre, (10.0, 0.0, 0.0))

    model = falling(force, event(action=action, target="push", value=HEIGHT / 2)).compile()
    at = np.sqrt(HEIGHT / G)
    before, after = (f / 2.0 for f in during)
    path = []
    for _ in range(2):  # the model is as new for the second run
        result = lm.simulate(model, 1.0, STEP)
        assert result.outcome.events[0].t == pytest.approx(at, abs=2e-6 * DT)
        t = result.at
        late = np.maximum(t - at, 0.0)
        early = np.minimum(t, at)
        exact = 0.5 * before * early**2 + before * at * late + 0.5 * after * late**2
        # the step is cut at the event, so that both parts are exact but for the millionth of a step
        np.testing.assert_allclose(result["centre.position"].values[:, 0], exact, atol=1e-6 * DT * 5.0 + 1e-10)
        path.append(result["centre.position"].values)
    np.testing.assert_array_equal(*path)


def test_a_spring_is_cut_and_the_energy_it_held_is_gone():
    def spring(centre):
        return lm.SpringDamper("spring", lm.Ground().marker("top", 0.0, 0.0, 3.0), centre, stiffness=20.0, rest_length=1.0)

    result = lm.simulate(falling(spring, event(action="switch_off", target="spring", value=1.0)), 1.0, STEP)
    strain = result["energy.strain"].values
    k = int(np.argmin(np.abs(result.at - result.outcome.events[0].t)))
    assert strain[k] == pytest.approx(0.5 * 20.0 * (2.0 - 1.0) ** 2, rel=1e-5)
    assert np.all(strain[k + 1 :] == 0.0)


def test_a_latch_may_be_engaged_by_an_event():
    def latch(pin):
        return lm.Latch("lock", pin, stiffness=2e4, at=3.0, damping=150.0)

    def watch(pin):
        return lm.Event("down", watch="pin.angle", value=0.8, action="latch", target="lock")

    result = lm.simulate(pendulum(latch, watch), 1.0, lm.GeneralizedAlpha(dt=5e-3, rho_inf=0.8))
    assert [happened.name for happened in result.outcome.events] == ["down"]
    sag = 2.0 * G * 0.5 * np.cos(0.8) / 2e4
    assert result["pin.angle"].values[-1] == pytest.approx(0.8 + sag, abs=1e-5)
    assert result["lock.engaged"].values[-1] == 1.0


@pytest.mark.parametrize(("once", "count"), [(True, 1), (False, 4)])
def test_an_event_happens_once_or_each_time(once, count):
    """A body on a spring of frequency 10 rad/s passes its rest place every tenth of pi."""

    def spring(centre):
        return lm.SpringDamper("spring", lm.Ground().marker("top", 0.0, 0.0, 5.0), centre, 200.0, rest_length=5.0 - HEIGHT)

    rest = HEIGHT - 2.0 * G / 200.0
    result = lm.simulate(falling(spring, event(value=rest, once=once)), 1.2, STEP)
    times = np.array([happened.t for happened in result.outcome.events])
    assert len(times) == count
    exact = 0.1 * np.pi * (np.arange(count) + 0.5)
    np.testing.assert_allclose(times, exact, atol=2e-3)  # (10 rad/s 1e-2 s)^2 / 12 of the time, and rho_inf = 0.9


@pytest.mark.parametrize(("direction", "first"), [("rising", 1.5), ("falling", 0.5), ("any", 0.5)])
def test_the_direction_is_kept(direction, first):
    def spring(centre):
        return lm.SpringDamper("spring", lm.Ground().marker("top", 0.0, 0.0, 5.0), centre, 200.0, rest_length=5.0 - HEIGHT)

    watch = event(value=HEIGHT - 2.0 * G / 200.0, direction=direction, action="stop")
    result = lm.simulate(falling(spring, watch), 1.2, STEP)
    assert result.outcome.events[0].t == pytest.approx(0.1 * np.pi * first, abs=2e-3)


def test_noted_events_of_one_step_are_listed_in_time_order():
    late, early = event("late", HEIGHT / 2 - 0.01), event("early", HEIGHT / 2)
    result = lm.simulate(falling(late, early), 1.0, STEP)
    assert [happened.name for happened in result.outcome.events] == ["early", "late"]


def test_the_first_event_of_a_force_says_whether_it_acts_at_the_start():
    def force(centre):
        return lm.PointForce("push", centre, (10.0, 0.0, 0.0))

    off = event("off", HEIGHT / 2, action="switch_off", target="push")
    on = event("on", HEIGHT / 4, action="switch_on", target="push")
    for events, acts in (((off, on), 1.0), ((on, off), 0.0)):
        model = falling(force, *events).compile()
        assert [block.on for block in model.loads if block.name == "push"] == [acts]


@pytest.mark.parametrize("tolerance", [None, 1e-4])
def test_two_events_in_one_step_both_happen_in_their_order(tolerance):
    def force(centre):
        return lm.PointForce("push", centre, (10.0, 0.0, 0.0))

    levels = (HEIGHT / 2, HEIGHT / 2 - 0.01)  # 3 ms apart, in steps of 10 ms and more
    on = event("on", levels[0], action="switch_on", target="push")
    off = event("off", levels[1], action="switch_off", target="push")
    integrator = lm.GeneralizedAlpha(dt=DT, rho_inf=0.9, tolerance=tolerance)
    result = lm.simulate(falling(force, on, off), 1.0, integrator)
    assert [happened.name for happened in result.outcome.events] == ["on", "off"]
    at = np.sqrt(2.0 * (HEIGHT - np.array(levels)) / G)
    np.testing.assert_allclose([happened.t for happened in result.outcome.events], at, atol=2e-6 * max(np.diff(result.at)))
    pushed = at[1] - at[0]
    assert result["centre.velocity"].values[-1, 0] == pytest.approx(5.0 * pushed, abs=2e-6)
    travelled = 0.5 * 5.0 * pushed**2 + 5.0 * pushed * (1.0 - at[1])
    # the moments are right to a millionth of a step, which counts times 5 m/s^2 and the second that is left
    assert result["centre.position"].values[-1, 0] == pytest.approx(travelled, abs=5.0 * 2e-6 * max(np.diff(result.at)))
