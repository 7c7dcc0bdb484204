"""Motions advanced from outside: equal to runs of the same model, saved and restored to the bit, and what is refused."""

from __future__ import annotations

import importlib
import pkgutil

import numpy as np
import pytest
from linear_systems import cantilever, carriage, pendulum, system_of

import lamella as lm
from lamella.errors import ConvergenceError, DeclarationError, ModelError
from lamella.measure.law import Law
from lamella.memory import Memory
from lamella.result import Cause
from lamella.roles import ConstraintBlock, ForceBlock

TIGHT = lm.Newton(tolerance=1e-12)
STEPS = lm.GeneralizedAlpha(dt=1e-3, newton=TIGHT)
LEVELS = (0.4, 1.0, -0.5, 0.7, 2.0, -1.0)
COMMUNICATION = 3.3e-3  # no multiple of the step


def marched(run, name, levels=LEVELS, dt=COMMUNICATION):
    """Outputs behind each communication step, one with each level."""
    found = []
    for level in levels:
        run.set(name, level)
        run.advance(dt)
        found.append(list(run.outputs.values()))
    return np.array(found)


def test_held_inputs_are_those_of_a_sampled_controller():
    """The same jumps at the same times, made by the controller that holds a load inside of a run."""
    names = ("tip.position.z", "root.force.z", "work.loads", "energy.balance")
    found = marched(lm.Stepping(cantilever(load=0.2, damping=1e-4), STEPS, inputs=("load",), outputs=names), "load")
    law = lm.FunctionLaw(lambda t, y: LEVELS[min(round(t / COMMUNICATION), len(LEVELS) - 1)])
    system = system_of(
        *cantilever(load=1.0, damping=1e-4).declarations, lm.Controller("pilot", names[:1], ("load",), law, COMMUNICATION)
    )
    run = lm.simulate(system, COMMUNICATION * len(LEVELS), STEPS)
    for column, name in enumerate(names):
        stem, _, label = name.rpartition(".")
        history = run.history(name).values if name in run.signals else run.history(stem).sel(component=label).values
        before = np.searchsorted(run.at, COMMUNICATION * np.arange(1, len(LEVELS) + 1) - 1e-9)  # the record before the jump
        scale = np.abs(history).max()
        np.testing.assert_allclose(found[:, column], history[before], rtol=0, atol=1e-9 * max(scale, np.abs(found).max() * 1e-3))


def test_times_that_are_off_by_rounding_give_a_controller_no_second_sample():
    """A master that sums its steps comes to the sample times with an error of more than a bit."""
    count = lm.FunctionLaw(lambda t, y, x: (0.0, x + 1.0), start=(0.0,))
    pilot = lm.Controller("pilot", ("pin.angle",), ("motor",), count, 0.01)
    run = lm.Stepping(system_of(*pendulum(angle=0.5, torque=lm.Constant(1.0)).declarations, pilot), STEPS)
    for t in (0.01 + 5e-12, 0.02 - 5e-12, 0.025, 0.03 + 5e-12):
        run.advance_to(t)
    assert run.get("pilot.state.0") == 4.0
    saved = run.save()
    run.advance_to(0.045)
    run.restore(saved)
    run.advance_to(0.045)
    assert run.get("pilot.state.0") == 5.0


def test_a_communication_step_of_almost_nothing_ends():
    """Less than the share of a step that has grown by error control for which none is made, but more than that of its first."""
    run = lm.Stepping(pendulum(), lm.BDF(dt=1e-3))
    run.advance_to(0.01)
    run.advance_to(0.01 + 5e-12)
    assert run.t == 0.01 + 5e-12


def test_without_inputs_it_goes_as_a_run_does():
    """Communication between the integrator's steps changes none of them, but by what is left of constraints, 1e-11 a step."""
    run = lm.Stepping(pendulum(angle=0.5), STEPS)
    for _ in range(20):
        run.advance(5e-3)
    whole = lm.simulate(pendulum(angle=0.5), 0.1, STEPS)
    assert run.t == pytest.approx(0.1)
    np.testing.assert_allclose(run.get("bob.position"), whole["bob.position"].values[-1], rtol=0, atol=1e-9)
    np.testing.assert_allclose(run.get("energy.balance"), whole["energy.balance"].values[-1], rtol=0, atol=1e-9)


def test_jumps_and_samples_at_communication_points_are_met():
    def system():
        plain = cantilever(load=0.0, damping=1e-4)
        tip = plain.declarations[0].marker("corner", 0.5, 0.0)
        law = lm.PID(proportional=50.0, derivative=0.5)
        return system_of(
            *plain.declarations,
            lm.PointForce("push", tip, (0, 0, 1.0), profile=lm.Step(at=0.01)),
            lm.PointForce("hold", tip, (0, 0, 1.0)),
            lm.Controller("pilot", ("corner.position.z",), ("hold",), law, 5e-3),
        )

    run = lm.Stepping(system(), STEPS, t_start=0.0)
    for k in range(1, 11):
        run.advance_to(5e-3 * k)
    whole = lm.simulate(system(), 0.05, STEPS)
    np.testing.assert_allclose(run.get("corner.position"), whole["corner.position"].values[-1], rtol=0, atol=1e-9 * 0.5)
    assert run.get("push.factor") == 1.0
    assert run.get("pilot.output") != whole["pilot.output"].values[-1]  # it has acted again, as at each sample


def test_an_acceleration_moves_a_drive_exactly():
    """Place and speed are the integrals of what is held: x = v_0 t + sum of a_k."""
    system = carriage()
    run = lm.Stepping(system, STEPS, inputs={"a": "drive.acceleration"}, outputs=("rail_a.displacement", "rail_a.speed"))
    assert run.units["a"] == "m/s^2"
    x = v = 0.0
    for a in (2.0, -1.0, 0.0, 3.0):
        run.set("a", a)
        run.advance(0.01)
        x, v = x + 0.01 * v + 0.5 * a * 0.01**2, v + 0.01 * a
        np.testing.assert_allclose(list(run.outputs.values()), [x, v], rtol=0, atol=1e-12)


def test_a_support_follows_another_acceleration_over_the_same_time():
    """What supports add to the coordinates is known by the time; it is another after a restored state, and after a reset."""
    section = lm.Laminate(lm.Isotropic(E=2e9, nu=0.3, rho=1.2e3), thickness=0.02)
    system, plate = lm.System(), lm.Plate("plate", (1.0, 0.3), (2, 1), section)
    system.add(plate)
    system.add(lm.Clamp("root", plate.edge("x-")))
    system.add(lm.PrescribedMotion("lift", plate.marker("tip", 1.0, 0.15), axis="z", displacement=lm.Constant(0.0)))
    run = lm.Stepping(
        system, lm.GeneralizedAlpha(dt=1e-2), inputs=["lift.acceleration"], outputs=["tip.position.z", "lift.force"]
    )
    run.advance(0.05)
    saved, forces = run.save(), []
    for acceleration in (1.0, 2.0):
        run.restore(saved)
        run.set("lift.acceleration", acceleration)
        run.advance(0.01)
        assert run.get("tip.position.z") == pytest.approx(0.5 * acceleration * 0.01**2, rel=1e-9)
        forces.append(run.get("lift.force"))
    assert forces[1] == pytest.approx(2.0 * forces[0], rel=1e-3)  # the plate has hardly moved: it answers in proportion
    for acceleration in (1.0, 3.0):
        run.reset()
        run.set("lift.acceleration", acceleration)
        run.advance(0.01)
        assert run.get("tip.position.z") == pytest.approx(0.5 * acceleration * 0.01**2, rel=1e-9)


def test_a_drive_by_its_speed_goes_on_from_where_it_stands():
    ground, body = lm.Ground(), lm.RigidBody("a", mass=1.0, inertia=(1, 1, 1), position=(0.3, 0, 0))
    rail = lm.PrismaticJoint("rail", ground.origin, body.origin, axis=(1, 0, 0))
    system = system_of(ground, body, rail, lm.SlideDrive("drive", rail, speed=lm.Constant(0.5)))
    run = lm.Stepping(system, STEPS, inputs=("drive.acceleration",))
    start = run.get("rail.displacement")
    run.advance(0.1)
    assert run.get("rail.displacement") == pytest.approx(start + 0.05, abs=1e-12)


def test_an_input_acts_at_once_on_what_depends_on_it():
    """A force on a free mass gives its acceleration to the outputs of the same time."""
    body = lm.RigidBody("body", mass=2.0, inertia=(1, 1, 1))
    run = lm.Stepping(system_of(body, lm.PointForce("push", body.origin, (1.0, 0, 0), profile=0.0)), STEPS, inputs=("push",))
    assert run.state.a[0] == 0.0
    run.set("push", 3.0)
    assert run.state.a[0] == pytest.approx(1.5, rel=1e-12)
    assert run.get("push.factor") == 3.0


# --------------------------------------------------------------------------------------------- saved and restored to the bit


def bent(strain, **options):
    plate = lm.Plate(
        "plate",
        (0.5, 0.1),
        (2, 1),
        lm.Laminate(lm.Isotropic(E=7e9, nu=0.3, rho=2700.0), thickness=2e-3),
        strain=strain,
        **options,
    )
    tip = plate.marker("tip", 0.5, 0.05)
    return system_of(plate, lm.Clamp("root", plate.edge("x-")), lm.PointForce("load", tip, (0, 0, 1.0), profile=0.0))


def warm():
    sheet = lm.Laminate(lm.Isotropic(E=7e9, nu=0.3, rho=2700.0, alpha=2e-5, k=150.0, c=900.0), thickness=2e-3)
    plate = lm.Plate("plate", (0.5, 0.1), (2, 1), sheet, damping=1e-4)
    sun = lm.SolarFlux("load", plate, (0, 0, -1.0), constant=1e5, absorptivity=0.8, profile=0.0)
    return system_of(plate, lm.Clamp("root", plate.edge("x-")), lm.TemperatureField("heat", plate), sun)


def caught():
    """A pendulum that a latch catches, that meets a stop, whose passage is noted, and that a second force joins."""
    system = pendulum(angle=0.8)  # whose angle counts from there
    pin, bob = system.declarations[2], system.declarations[1]
    more = (
        lm.PointForce("wind", bob.origin, (0.3, 0, 0)),
        lm.TorsionSpring("spring", pin, stiffness=2.0, damping=0.1),
        lm.EndStop("stop", pin, lower=-8e-4, upper=1.0, stiffness=1e3),
        lm.Latch("catch", pin, stiffness=2e2, at=-1e-3, damping=2.0),
        lm.Event("gust", "pin.angle", value=-5e-4, action="switch_on", target="wind"),
        lm.Event("seen", "pin.angle", value=-3e-4),
    )
    return system_of(*system.declarations, *more)


def rubbing():
    """A plate that is dragged over the ground with bristles."""
    sheet = lm.Laminate(lm.Isotropic(E=7e9, nu=0.3, rho=2700.0), thickness=2e-3)
    plate = lm.Plate("plate", (0.5, 0.1), (2, 1), sheet, position=(0, 0, 1e-6))
    ground = lm.Ground()
    contact = lm.PlaneContact(
        "floor", plate, ground.origin, stiffness=1e9, damping=0.1, mu=0.3, friction=lm.BristleFriction(stiffness=1e8, damping=1e3)
    )
    tip = plate.marker("tip", 0.25, 0.05)
    pull = lm.PointForce("load", tip, (1.0, 0, 0), profile=0.0)
    return system_of(ground, plate, contact, lm.Gravity("weight"), pull)


def piloted():
    system = pendulum(angle=0.3)
    push = lm.PointForce("load", system.declarations[1].origin, (1.0, 0, 0), profile=0.0)
    law = lm.PID(proportional=3.0, integral=1.0, derivative=0.3)
    return system_of(*system.declarations, push, lm.Controller("pilot", ("pin.angle",), ("motor",), law, 2e-3))


SAVED = {
    "exact strains": (lambda: bent("exact"), "load", STEPS),
    "floating frame": (lambda: bent("floating"), "load", STEPS),
    "frames of elements": (lambda: bent("corotational"), "load", STEPS),
    "heat": (warm, "load", STEPS),
    "heat, staggered": (warm, "load", lm.GeneralizedAlpha(dt=1e-3, coupling="staggered")),
    "latch, stop and events": (caught, "motor", STEPS),
    "contact with bristles": (rubbing, "load", lm.GeneralizedAlpha(dt=5e-4)),
    "controller": (piloted, "load", STEPS),
    "moved drive": (carriage, "drive.acceleration", STEPS),
    "stabilised": (caught, "motor", lm.GeneralizedAlpha(dt=1e-3, stabilised=True)),
    "error control": (lambda: bent("exact"), "load", lm.GeneralizedAlpha(dt=1e-3, tolerance=1e-5)),
    "backward differences": (caught, "motor", lm.BDF(dt=1e-3, tolerance=1e-6)),
    "backward differences in fixed steps": (piloted, "load", lm.BDF(dt=1e-3, tolerance=None, max_order=3)),
}


@pytest.mark.parametrize("name", SAVED)
def test_what_is_saved_goes_on_to_the_bit(name):
    """The same run goes back and on again; another one, made anew, goes on as well. What is saved at the end is everything."""
    make, load, integrator = SAVED[name]
    run, other = (lm.Stepping(make(), integrator, inputs=(load,)) for _ in range(2))
    marched(run, load, LEVELS[:3])
    saved = run.save()
    marched(run, load, LEVELS[3:])
    end = run.save()
    for again in (run, other):
        again.restore(saved)
        assert again.save() == saved
        marched(again, load, LEVELS[3:])
        assert again.save() == end
    other.reset()
    marched(other, load)
    assert other.save() == end  # that it was saved on the way has changed nothing


def test_the_state_that_is_saved_has_something_to_say():
    """Latches, stops and events of the case above are at work on both sides of what is saved."""
    run = lm.Stepping(caught(), STEPS, inputs=("motor",))
    marched(run, "motor", LEVELS[:3])
    before = {happening.name for happening in run.events}
    marched(run, "motor", (*LEVELS[3:], 0.0, 0.0, 0.0, 0.0))
    assert {happening.name for happening in run.events} - before


def test_turns_are_counted_across_a_restored_state():
    body = lm.RigidBody("body", mass=1.0, inertia=(1, 1, 1), angular_velocity=(0, 0, 20.0))
    ground = lm.Ground()
    system = system_of(ground, body, lm.RevoluteJoint("pin", ground.origin, body.origin, axis=(0, 0, 1)))
    run = lm.Stepping(system, lm.GeneralizedAlpha(dt=0.01))
    run.advance(0.5)
    saved, angle = run.save(), run.get("pin.angle")
    other = lm.Stepping(system, lm.GeneralizedAlpha(dt=0.01))
    other.restore(saved)
    assert other.get("pin.angle") == angle == pytest.approx(10.0, rel=0.01)  # a turn and a half, and the error of long steps


def test_every_class_that_forgets_a_run_says_what_it_remembers_of_it():
    """A block that has something to reset has something to save."""
    for folder in ("load", "measure", "contact", "constraint", "thermal", "joint", "element"):
        package = importlib.import_module(f"lamella.{folder}")
        for module in pkgutil.walk_packages(package.__path__, f"lamella.{folder}."):
            importlib.import_module(module.name)

    def below(cls):
        return {cls, *(deeper for sub in cls.__subclasses__() for deeper in below(sub))}

    bases = {ForceBlock, ConstraintBlock, Law}
    kept = {cls.__name__ for base in bases for cls in below(base) - bases if "reset" in vars(cls) and not cls.remembered}
    assert kept == {"UserForceBlock"}  # whose tangent is checked once in each run
    assert all(issubclass(cls, Memory) for cls in bases)


# ------------------------------------------------------------------------------------------------------------ what is refused


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"inputs": ("lod",)}, "Stepping: there is no input 'lod'.*there are: load"),
        ({"inputs": ("load", "load")}, "each once"),
        ({"inputs": {"a": "load", "b": "load"}}, "'a' and 'b' both stand for 'load'"),
        ({"inputs": ("load.acceleration",)}, "'load.acceleration' has no motion to accelerate"),
        ({"outputs": ("tip.positon",)}, r"there is no output 'tip.positon'.*tip\.position"),
        ({"outputs": ("tip.position", "tip.position.z")}, "'tip.position.z' is given twice"),
    ],
)
def test_wrong_names_are_told(options, said):
    with pytest.raises(DeclarationError, match=said):
        lm.Stepping(cantilever(), STEPS, **options)


def test_a_place_may_not_jump():
    with pytest.raises(DeclarationError, match=r"displacement of SlideDrive 'drive'.*accepted is its acceleration, 'drive\.acc"):
        lm.Stepping(carriage(), STEPS, inputs=("drive",))


def test_wrong_calls_are_told():
    run = lm.Stepping(cantilever(), STEPS, inputs=("load",))
    for call, said in (
        (lambda: run.set("lod", 1.0), "there is no input 'lod'; there are: load"),
        (lambda: run.set("load", float("nan")), "'load' is set to nan"),
        (lambda: run.set("load", 1e300), r"'load' is set to 1e\+300; accepted is a number of up to 1e\+30"),
        (lambda: run.set("load", "1 N"), "set: value = '1 N'; accepted is a number"),
        (lambda: run.advance("1 ms"), "advance: dt = '1 ms'; accepted is a number"),
        (lambda: run.get("tip"), "there is no output 'tip'"),
        (lambda: run.advance(-1.0), "a communication step of -1.0 s"),
        (lambda: run.advance_to(0.0), "later than the present one, 0 s"),
        (lambda: run.advance(1e-300), "a communication step of 1e-300 s; accepted is one of 1e-30 s or more"),
        (lambda: run.restore(b"[1]"), "no saved state"),
        (lambda: run.restore(b"\xff"), "no saved state"),
        (lambda: run.restore(lm.Stepping(pendulum(), STEPS).save()), "another system"),
    ):
        with pytest.raises(DeclarationError, match=said):
            call()


def test_a_first_step_that_does_not_converge_is_told():
    run = lm.Stepping(cantilever(load=1e9), STEPS)
    with pytest.raises(ConvergenceError, match="the motion stopped at 0 of"):
        run.advance(0.1)
    assert run.t == 0.0


def test_an_event_ends_the_motion_until_it_is_reset():
    body = lm.RigidBody("ball", mass=1.0, inertia=(1, 1, 1))
    system = system_of(body, lm.Gravity("g"), lm.Event("ground", "ball.position", value=-0.05, component="z", action="stop"))
    run = lm.Stepping(system, STEPS)
    outcome = run.advance(1.0)
    assert outcome.cause is Cause.EVENT
    assert run.t == pytest.approx(np.sqrt(2 * 0.05 / 9.81), abs=1e-6)
    saved = run.save()
    with pytest.raises(ModelError, match=r"an event has ended the motion at 0\.1.*reset\(\)"):
        run.advance(0.1)
    run.reset()
    run.advance(0.05)
    assert run.ended is None
    run.restore(saved)
    with pytest.raises(ModelError, match="an event has ended"):
        run.advance(0.1)


def test_a_motion_that_cannot_go_on_stands_where_it_was():
    """An absurd load is not swallowed: the step is named, and the run goes on once the load is taken away."""
    run = lm.Stepping(cantilever(), lm.GeneralizedAlpha(dt=1e-3, dt_min=9e-4), inputs=("load",))
    run.advance(1e-3)
    run.set("load", 1e9)
    with pytest.raises(ConvergenceError, match="stopped at"):
        run.advance(0.01)
    run.reset()
    run.advance(1e-3)
    assert run.get("tip.position.z") == pytest.approx(0.0, abs=1e-12)
