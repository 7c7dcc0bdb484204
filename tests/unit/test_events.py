"""Events: found in time, they stop a run, switch forces, engage latches or are only noted; a result tells what happened when."""

from __future__ import annotations

import numpy as np
import pytest

import lamella as lm
from lamella.errors import DeclarationError
from lamella.io.model_file import dumps, loads
from lamella.io.results import read_result
from lamella.result import Cause

G, DT = 9.81, 7e-3
STEPS = lm.GeneralizedAlpha(dt=DT, newton=lm.Newton(tolerance=1e-10))
CLOSE = 1e-6 * DT  # to this the moment of an event is found


def ball(*more, velocity=(0.0, 0.0, 0.0), gravity=True):
    """A free body of 2 kg that falls, with the declarations that ``more`` makes of it."""
    system = lm.System()
    body = system.add(lm.RigidBody("ball", mass=2.0, inertia=(0.1, 0.1, 0.1), velocity=velocity))
    if gravity:
        system.add(lm.Gravity("weight", (0, 0, -G)))
    for make in more:
        system.add(make(body))
    return system


def fallen(name, depth, action="stop", **options):
    return lambda body: lm.Event(name, "ball.position", value=-depth, component="z", action=action, **options)


def test_a_run_stops_at_the_moment_of_an_event():
    """Free fall is exact in generalised-alpha: z = -g t^2 / 2."""
    result = lm.simulate(ball(fallen("ground", 0.3)), 1.0, STEPS)
    t = np.sqrt(2 * 0.3 / G)
    assert result.outcome.cause is Cause.EVENT
    assert result.outcome.completed
    assert result.at[-1] == result.outcome.reached == result.final.t
    assert 0.0 <= result.at[-1] - t < 2.0 * CLOSE  # just behind
    assert result["ball.position"].values[-1, 2] == pytest.approx(-0.3, abs=G * t * 2 * CLOSE)
    (event,) = result.events
    assert (event.name, event.t) == ("ground", result.at[-1])
    assert event.text == "stop: z of ball.position passes -0.3"


def test_the_last_state_of_a_run_that_an_event_stops_is_in_its_file(tmp_path):
    """Although no frame is due there."""
    stopped = lm.simulate(ball(fallen("ground", 0.3)), 1.0, STEPS, frames=2)
    stored = read_result(stopped.save(tmp_path / "run.h5"))
    assert 0.0 < stored.frame_at[-1] == stopped.final.t < 0.5
    np.testing.assert_array_equal(stored.final.q, stopped.final.q)


@pytest.mark.parametrize(("direction", "expected"), [("rising", 0), ("falling", 1), ("any", 0)])
def test_direction_chooses_among_crossings(direction, expected):
    """A ball thrown upwards passes 0.4 m twice."""
    watch = {"watch": "ball.position", "component": "z", "value": 0.4, "direction": direction, "action": "stop"}
    result = lm.simulate(ball(lambda body: lm.Event("level", **watch), velocity=(0, 0, 4.0)), 1.5, STEPS)
    times = (4.0 + np.array([-1.0, 1.0]) * np.sqrt(16.0 - 2 * G * 0.4)) / G
    assert result.at[-1] == pytest.approx(times[expected], abs=2 * CLOSE)


def test_noted_events_change_nothing_and_repeat_when_asked():
    def run(*more):
        return lm.simulate(ball(*more, velocity=(0, 0, 4.0)), 0.9, STEPS)

    watch = {"watch": "ball.position", "component": "z", "value": 0.4}
    noted = run(lambda body: lm.Event("pass", **watch, once=False), lambda body: lm.Event("first", **watch))
    np.testing.assert_array_equal(noted["ball.position"].values, run()["ball.position"].values)
    times = (4.0 + np.array([-1.0, 1.0]) * np.sqrt(16.0 - 2 * G * 0.4)) / G
    assert [event.name for event in noted.events] == ["pass", "first", "pass"]
    # interpolated in the step: g dt^2 / 8 over the speed
    np.testing.assert_allclose([event.t for event in noted.events], times[[0, 0, 1]], atol=G * DT**2 / 8 / 2.0)


def test_a_force_is_switched_off_and_another_on():
    """Weightless from 0.2 m on, and pushed upwards from 0.5 m on."""
    system = ball(
        lambda body: lm.PointForce("push", body.origin, (0, 0, 10.0)),
        fallen("float", 0.2, "switch_off", target="weight"),
        fallen("start", 0.5, "switch_on", target="push"),
    )
    result = lm.simulate(system, 0.6, STEPS)
    t_1 = np.sqrt(2 * 0.2 / G)
    speed = G * t_1
    t_2 = t_1 + 0.3 / speed
    assert [event.t for event in result.events] == pytest.approx([t_1, t_2], abs=4 * CLOSE)
    assert [event.name for event in result.events] == ["float", "start"]
    at, z = result.at, result["ball.velocity"].values[:, 2]
    assert z[-1] == pytest.approx(-speed + 5.0 * (0.6 - t_2), abs=1e-5)
    np.testing.assert_allclose(z[(at > t_1) & (at < t_2)], -speed, atol=1e-6)
    assert at[-1] == 0.6


def test_a_compiled_model_begins_again_as_it_was():
    model = ball(fallen("float", 0.2, "switch_off", target="weight")).compile()
    first, second = (lm.simulate(model, 0.4, STEPS) for _ in range(2))
    np.testing.assert_array_equal(first["ball.position"].values, second["ball.position"].values)
    assert first.events == second.events


def test_several_events_in_one_step_happen_in_their_order():
    far, near = fallen("far", 0.2 + 1e-4, "switch_off", target="weight"), fallen("near", 0.2, "stop")
    result = lm.simulate(ball(far, near), 1.0, STEPS)
    assert [event.name for event in result.events] == ["near"]
    near = fallen("near", 0.2, "record")
    result = lm.simulate(ball(far, near), 0.3, STEPS)
    assert [event.name for event in result.events] == ["near", "far"]
    assert np.diff([event.t for event in result.events]) == pytest.approx(1e-4 / (G * np.sqrt(0.4 / G)), rel=0.1)


def test_events_are_found_under_error_control_and_with_stabilised_constraints():
    system, ground = lm.System(), lm.Ground()
    arm = lm.RigidBody("arm", mass=1.0, inertia=(0.01, 0.1, 0.1), position=(0.5, 0, 0))
    for item in (ground, arm):
        system.add(item)
    system.add(lm.RevoluteJoint("hinge", ground.marker("o", 0, 0, 0), arm.marker("in", -0.5, 0, 0), axis=(0, 1, 0)))
    system.add(lm.Gravity("weight", (0, 0, -G)))
    system.add(lm.Event("down", "hinge.angle", value=np.pi / 2, action="stop"))
    times = []
    for options in ({"dt": 1e-3}, {"dt": 1e-3, "stabilised": True}, {"dt": 1e-3, "tolerance": 1e-6}):
        result = lm.simulate(system, 2.0, lm.GeneralizedAlpha(newton=lm.Newton(tolerance=1e-10), **options))
        assert result["hinge.angle"].values[-1] == pytest.approx(np.pi / 2, abs=1e-7)
        times.append(result.at[-1])
    # quarter of a swing from the horizontal: K(1/sqrt 2) / omega with omega^2 = m g l_c / (J + m l_c^2) = 0.5 g / 0.35
    quarter = 1.8540746773 / np.sqrt(0.5 * G / 0.35)
    np.testing.assert_allclose(times[:2], quarter, rtol=2e-5)  # (omega dt)^2 is 1.4e-5
    assert times[2] == pytest.approx(quarter, rel=1e-3)  # some hundred steps with local errors of 1e-6


def test_an_event_engages_a_latch():
    """A lid falls on its hinge; the latch that would lock it at 1 rad is engaged by the event at 0.5 rad and holds it there."""
    system, ground = lm.System(), lm.Ground()
    lid = lm.RigidBody("lid", mass=1.0, inertia=(0.01, 0.1, 0.1), position=(0.5, 0, 0))
    for item in (ground, lid):
        system.add(item)
    hinge = lm.RevoluteJoint("hinge", ground.marker("o", 0, 0, 0), lid.marker("in", -0.5, 0, 0), axis=(0, 1, 0))
    system.add(hinge)
    system.add(lm.Gravity("weight", (0, 0, -G)))
    system.add(lm.Latch("catch", hinge, stiffness=2e3, at=1.0, damping=50.0))
    system.add(lm.Event("early", "hinge.angle", value=0.5, action="latch", target="catch"))
    result = lm.simulate(system, 1.5, lm.GeneralizedAlpha(dt=1e-3, rho_inf=0.7))
    assert result.events[0].name == "early"
    assert result["catch.engaged"].values[0] == 0.0
    assert result["catch.engaged"].values[-1] == 1.0
    # the spring of 2 kN m/rad carries the lid: it gives way by m g l cos(phi) / k
    assert result["hinge.angle"].values[-1] == pytest.approx(0.5 + 0.5 * G * np.cos(0.5) / 2e3, abs=1e-4)


def test_events_are_in_the_file(tmp_path):
    result = lm.simulate(ball(fallen("half", 0.1, "record"), fallen("ground", 0.3)), 1.0, STEPS)
    stored = read_result(result.save(tmp_path / "run.h5"))
    assert stored.events == result.events
    assert stored.outcome == result.outcome
    import xarray

    with xarray.open_dataset(tmp_path / "run.h5", engine="h5netcdf", group="events") as table:
        assert table["name"].values.tolist() == ["half", "ground"]
        assert table["time"].attrs["units"] == "s"
    quiet = lm.simulate(ball(), 0.01, STEPS)
    assert read_result(quiet.save(tmp_path / "quiet.h5")).events == quiet.events == ()


def test_statics_begins_with_forces_as_they_are_at_the_start_of_a_run():
    section = lm.Laminate(lm.Isotropic(E=2e9, nu=0.3, rho=1200.0), thickness=0.02)
    system, plate = lm.System(), lm.Plate("plate", (1.0, 0.3), (2, 1), section)
    system.add(plate)
    tip = plate.marker("tip", 1.0, 0.15)
    system.add(lm.Clamp("root", plate.edge("x-")))
    system.add(lm.PointForce("load", tip, (0, 0, -5.0)))
    system.add(lm.Event("loss", "tip.position", value=-1e-3, component="z", action="switch_off", target="load"))
    model = system.compile()
    before = lm.equilibrium(model)["tip.position"].values
    assert lm.simulate(model, 0.1, lm.GeneralizedAlpha(dt=1e-3)).events[0].name == "loss"
    np.testing.assert_array_equal(lm.equilibrium(model)["tip.position"].values, before)


def test_a_model_file_says_events():
    system = ball(fallen("ground", 0.3), fallen("float", 0.2, "switch_off", target="weight"))
    text = dumps(system)
    assert "type: event" in text
    assert loads(text).system.declarations == system.declarations


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"watch": "ball.positon", "component": "z"}, "no signal 'ball.positon'; did you mean 'ball.position'"),
        ({"watch": "ball.position"}, "a component is needed of 'ball.position'; accepted is x, y, z"),
        ({"watch": "ball.position", "component": "w"}, "component = 'w' of 'ball.position'; accepted is x, y, z"),
        ({"watch": "energy.kinetic", "component": "x"}, "component = 'x' of 'energy.kinetic'; accepted is none"),
        ({"watch": "energy.kinetic", "action": "switch_on", "target": "wind"}, "no such target 'wind'; accepted is weight"),
        (
            {"watch": "energy.kinetic", "action": "latch", "target": "weight"},
            "no such target 'weight'; there is none",
        ),
        ({"watch": "energy.kinetic", "action": "latch"}, "action = 'latch' without 'target'"),
        ({"watch": "energy.kinetic", "target": "weight"}, "target = 'weight'; the action 'record' has none"),
        ({"watch": "energy.kinetic", "value": float("nan")}, "value"),
        ({"watch": "energy.kinetic", "direction": "up"}, "direction = 'up'; accepted is 'rising', 'falling' or 'any'"),
    ],
)
def test_impossible_events_are_refused(options, message):
    with pytest.raises(DeclarationError, match="Event 'bad'") as caught:
        lm.simulate(ball(lambda body: lm.Event("bad", **options)), 0.1, STEPS)
    assert message in str(caught.value)
