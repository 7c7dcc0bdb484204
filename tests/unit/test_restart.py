"""What a solution ends in holds all that the next one depends on: a motion that is cut in two is the motion that is not."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import lamella as lm
from lamella.assembly.equations import Equations
from lamella.fmu.plant import Interface, stepping, write_resources
from lamella.io.model_file import loads
from lamella.io.results import ResultWriter
from lamella.signals import system_signals
from lamella.stepping.saved import encoded

STEPS = lm.GeneralizedAlpha(dt=1e-2, rho_inf=0.9, stabilised=True, newton=lm.Newton(tolerance=1e-12))
LAYUP = lm.Laminate(lm.Isotropic(E=2e9, nu=0.3, rho=1200), thickness=0.01)


def wheel(spin: float = 0.0) -> tuple[lm.System, lm.RevoluteJoint]:
    """A wheel of 1 kg m^2 on a pin."""
    system, ground = lm.System(), lm.Ground()
    body = system.add(lm.RigidBody("wheel", mass=1.0, inertia=(1.0, 1.0, 1.0), angular_velocity=(0, 0, spin)))
    return system, system.add(lm.RevoluteJoint("pin", ground.origin, body.origin))


def wound() -> lm.System:
    system, pin = wheel(9.0)
    system.add(lm.TorsionSpring("spring", pin, stiffness=1.0))
    return system


def stopped() -> lm.System:
    system, pin = wheel(9.0)
    system.add(lm.EndStop("stop", pin, upper=7.0, stiffness=100.0, damping=1.0))
    return system


def latched() -> lm.System:
    system, pin = wheel(3.0)
    system.add(lm.Latch("latch", pin, at=1.5, stiffness=100.0, damping=1.0))
    return system


def driven() -> lm.System:
    system, pin = wheel()
    system.add(lm.AngleDrive("motor", pin, speed=9.0))
    system.add(lm.TorsionSpring("spring", pin, stiffness=1.0))
    return system


def switched() -> lm.System:
    system, pin = wheel(9.0)
    system.add(lm.TorsionSpring("spring", pin, stiffness=1.0))
    system.add(lm.Event("let go", watch="pin.angle", value=2.0, action="switch_off", target="spring"))
    return system


def steered() -> lm.System:
    system, pin = wheel(0.5)
    system.add(lm.PointMoment("motor", pin.b, (0.0, 0.0, 1.0)))
    law = lm.PID(proportional=3.0, integral=5.0, derivative=1.0, reference=lm.Constant(1.0))
    system.add(lm.Controller("pilot", ("pin.angle",), ("motor",), law, 0.05))
    return system


def sheet(friction: lm.BristleFriction) -> lm.System:
    """A sheet on a plane that gravity slants; two of its points are guided along the slope."""
    system, ground = lm.System(), lm.Ground()
    plate = system.add(lm.Plate("sheet", (0.5, 0.4), (2, 1), LAYUP, position=(0, 0, 0.00498), damping=1e-3))
    for name, x in (("middle", 0.1), ("end", 0.4)):
        system.add(lm.PointSupport(f"guide at the {name}", plate.marker(name, x, 0.1), "y"))
    system.add(lm.Gravity("weight", (2.0, 0.0, -9.81)))
    floor = ground.marker("floor", 0, 0, 0)
    system.add(lm.PlaneContact("touch", plate, floor, stiffness=1e9, damping=1.0, mu=0.5, friction=friction))
    return system


def held() -> lm.System:
    return sheet(lm.BristleFriction(stiffness=1e5, damping=1e3))


@pytest.mark.parametrize(
    ("make", "signals"),
    [
        (wound, ("pin.angle", "spring.torque", "energy.strain")),
        (stopped, ("pin.angle", "stop.torque")),
        (latched, ("pin.angle", "latch.torque", "energy.strain")),
        (driven, ("pin.angle", "spring.torque", "motor.torque")),
        (switched, ("pin.angle", "spring.torque")),
        (steered, ("pin.angle", "pilot.state", "pilot.output")),
        (held, ("end.position", "touch.force", "energy.strain")),
    ],
)
def test_a_motion_goes_on_from_the_end_of_another(
    make: Callable[[], lm.System], signals: tuple[str, ...], tmp_path: Path
) -> None:
    cut, end = 1.0, 1.5
    if make is held:
        cut, end = 0.1, 0.15
    first = lm.simulate(make(), cut, STEPS)
    second = lm.simulate(make(), end, STEPS, t_start=cut, initial=first.final)
    whole = lm.simulate(make(), end, STEPS)
    for name in signals:
        size = np.abs(whole[name].values).max() + 1e-9
        if not name.startswith("pilot"):  # which samples at once
            np.testing.assert_allclose(second[name].values[0], first[name].values[-1], rtol=0, atol=1e-5 * size)
        # accelerations that are solved for anew begin another numerical damping, of second order in 9 rad/s times 10 ms
        np.testing.assert_allclose(second[name].values[-1], whole[name].values[-1], rtol=0, atol=3e-3 * size)
    first.save(tmp_path / "first.h5")
    stored = lm.read_result(tmp_path / "first.h5")
    again = lm.simulate(make(), end, STEPS, t_start=cut, initial=stored.final)
    stored.save(tmp_path / "copy.h5")
    assert encoded(lm.read_result(tmp_path / "copy.h5").final.memory) == encoded(first.final.memory)
    for name in signals:
        np.testing.assert_array_equal(again[name].values, second[name].values)
    assert second["work.dissipated"].values[0] == pytest.approx(0.0, abs=1e-12)
    assert second["energy.balance"].values[0] == 0.0


def test_what_bristles_hold_in_statics_stays_at_rest() -> None:
    still = lm.equilibrium(held())
    pull = 2.0 * 0.5 * 0.4 * 0.01 * 1200  # along the slope [N]
    assert still["touch.force"].values[0] == pytest.approx(pull, rel=1e-6)
    run = lm.simulate(held(), 0.1, STEPS, initial=still.final)
    stretched = pull / (1e5 * 0.5 * 0.4)
    assert np.ptp(run["end.position"].values[:, 0]) <= 1e-6 * stretched  # it would slip by as much again
    np.testing.assert_allclose(run["touch.force"].values[:, 0], pull, rtol=1e-6)


def test_modes_and_linear_models_about_a_state_hold_what_it_remembers() -> None:
    """Of a system that is compiled anew as of the model that has moved, which remembers it in any case."""

    def geared() -> lm.System:
        system, pin = wheel(3.0)
        hub = system.bodies[0]
        arm = system.add(lm.RigidBody("arm", mass=1.0, inertia=(1.0, 1.0, 2.0)))
        hinge = system.add(lm.RevoluteJoint("hinge", hub.origin, arm.origin))
        third = system.add(lm.RigidBody("third", mass=1.0, inertia=(1.0, 1.0, 1.5)))
        last = system.add(lm.RevoluteJoint("last", arm.origin, third.origin))
        system.add(lm.TorsionSpring("spring", hinge, stiffness=8.0))
        system.add(lm.TorsionSpring("other", last, stiffness=5.0))
        system.add(lm.Latch("latch", pin, at=0.5, stiffness=100.0, damping=1.0))
        return system

    run = lm.simulate(geared(), 1.0, STEPS)
    again = lm.modes(run.model, 2, state=run.final).frequencies
    anew = lm.modes(geared(), 2, state=run.final).frequencies
    np.testing.assert_allclose(anew, again, rtol=1e-9)
    assert anew.min() > 0.1  # the latch holds
    free = lm.modes(run.model, 2).frequencies  # about the reference, where it does not
    assert abs(free[0]) < 1e-3
    np.testing.assert_allclose(lm.modes(geared(), 2).frequencies, free, rtol=1e-6, atol=1e-6)


def test_what_another_system_remembers_is_left_out() -> None:
    state = lm.simulate(latched(), 1.0, STEPS).final
    system, pin = wheel()
    system.add(lm.EndStop("latch", pin, upper=20.0, stiffness=1.0))
    found = lm.simulate(system, 1.1, STEPS, t_start=1.0, initial=state)
    assert not found["latch.torque"].values.any()


def test_angles_count_turns_over_load_steps() -> None:
    system, pin = wheel()
    system.add(lm.TorsionSpring("spring", pin, stiffness=1.0))
    system.add(lm.PointMoment("load", pin.b, (0.0, 0.0, 8.0)))
    still = lm.equilibrium(system, steps=10)
    factors = still.history("load_factor").values
    np.testing.assert_allclose(still.history("pin.angle").values, 8.0 * factors, atol=1e-9)
    run = lm.simulate(system, 0.1, STEPS, initial=still.final)
    np.testing.assert_allclose(run["pin.angle"].values, 8.0, atol=1e-9)


MODEL = """
lamella: 1
system:
  wheel: {type: rigid_body, mass: 1 kg, inertia: [1 kg m^2, 1 kg m^2, 1 kg m^2]}
  ground: {type: ground}
  pin: {type: revolute_joint, a: ground.origin, b: wheel.origin}
  spring: {type: torsion_spring, on: pin, stiffness: 1 N m}
  load: {type: point_moment, on: wheel.origin, moment: [0, 0, 8 N m]}
analysis:
  wound: {type: statics, steps: 10}
  motion: {type: motion, start: wound, t_end: 0.1 s, integrator: {dt: 10 ms}}
"""


def test_a_unit_for_co_simulation_begins_with_what_its_start_remembers(tmp_path: Path) -> None:
    wound = lm.equilibrium(loads(MODEL).system, steps=10).final
    interface = Interface("plant", "", "motion", 0.01, 0.0, 0.1, {}, (), ())
    write_resources(tmp_path, interface, MODEL, wound, None)
    unit = stepping(tmp_path, interface, 0.0)
    unit.advance(0.05)
    assert unit.get("pin.angle") == pytest.approx(8.0, abs=1e-9)
    assert unit.get("spring.torque") == pytest.approx(8.0, abs=1e-9)


def test_a_file_holds_time_and_load_factor_of_the_last_state(tmp_path: Path) -> None:
    system = loads(MODEL).system
    for solution in (
        lm.equilibrium_path(system, t=2.0, until=0.5),
        lm.equilibrium(system, t=2.0, steps=[0.25, 0.5]),
        lm.equilibrium(system, times=[0.0, 2.0]),
    ):
        solution.save(tmp_path / "still.h5")
        found, final = lm.read_result(tmp_path / "still.h5").final, solution.final
        assert (found.t, found.factor) == (final.t, final.factor)
        assert found.t == 2.0


def test_a_run_writes_what_its_end_remembers_and_a_killed_one_what_it_can(tmp_path: Path) -> None:
    model = latched().compile()
    paths = [tmp_path / "run.h5", tmp_path / "killed.h5"]
    signals = system_signals(Equations(model))
    writers = [ResultWriter(path, signals, "time", model.n_q) for path in paths]
    run = lm.simulate(model, 1.0, STEPS, sinks=writers[:1])
    assert encoded(lm.read_result(paths[0]).final.memory) == encoded(run.final.memory)
    writers[1].sample(0.5, [np.asarray(signal.evaluate(run.final)) for signal in signals])
    writers[1].frame(0.5, run.final)
    writers[1].flush()
    killed = lm.read_result(paths[1]).final
    assert (killed.t, killed.factor, killed.memory) == (0.5, 1.0, None)
    writers[1].discard()


def test_a_latch_that_engages_in_the_last_step_is_engaged_in_its_file(tmp_path: Path) -> None:
    system = latched()
    system.add(lm.Event("there", watch="pin.angle", value=1.5, action="stop"))
    model = system.compile()
    writer = ResultWriter(tmp_path / "run.h5", system_signals(Equations(model)), "time", model.n_q)
    run = lm.simulate(model, 1.0, STEPS, sinks=[writer], frames=10_000)  # each step is one
    ended = run.at[-1]
    assert ended < 1.0
    run.save(tmp_path / "saved.h5")
    for final in (run.final, *(lm.read_result(tmp_path / name).final for name in ("run.h5", "saved.h5"))):
        held = lm.simulate(latched(), ended + 0.5, STEPS, t_start=ended, initial=final)
        assert np.abs(held["pin.angle"].values - 1.5).max() < 0.4  # 3 rad/s against 10 rad/s of the latch: 0.3 rad
