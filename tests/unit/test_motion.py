"""Motion from start to end: initial states, loads that begin late, frames, statistics, and what is recorded."""

from __future__ import annotations

import numpy as np
import pytest

import lamella as lm
from lamella.errors import ConstraintError, DeclarationError
from lamella.result import Cause

SECTION = lm.Laminate(lm.Isotropic(E=2e9, nu=0.3, rho=1200.0), thickness=0.02)
AT = 0.0033


def cantilever(**changes):
    system, plate = lm.System(), lm.Plate("plate", (1.0, 0.3), (2, 1), SECTION, **changes)
    system.add(plate)
    plate.marker("tip", 1.0, 0.15)
    system.add(lm.Clamp("root", plate.edge("x-")))
    return system, plate


LATE = {
    "point force": lambda p: lm.PointForce("load", p.corner("x+y-"), (0, 0, 5.0), lm.Step(at=AT)),
    "surface force": lambda p: lm.SurfaceForce("load", p, (0, 0, 5.0), lm.Step(at=AT)),
    "pressure": lambda p: lm.Pressure("load", p, 5.0, lm.Step(at=AT)),
    "point moment": lambda p: lm.PointMoment("load", p.corner("x+y-"), (0, 5.0, 0), lm.Step(at=AT)),
    "edge moment": lambda p: lm.EdgeMoment("load", p.edge("x+"), (0, 5.0, 0), lm.Step(at=AT)),
}


@pytest.mark.parametrize("make", LATE.values(), ids=LATE.keys())
def test_jump_of_every_load_is_a_stop(make):
    system, plate = cantilever()
    system.add(make(plate))
    result = lm.simulate(system, 0.008, lm.GeneralizedAlpha(dt=1e-3))
    assert np.abs(result.at - AT).min() < 1e-15
    z = np.abs(result["tip.position"].values[:, 2])
    assert z[result.at <= AT].max() < 1e-12
    assert z[-1] > 1e-6


def test_free_fall_is_exact():
    """Constant acceleration: generalised-alpha reproduces the parabola to rounding."""
    system = lm.System()
    plate = lm.Plate("plate", (1.0, 0.5), (1, 1), SECTION, velocity=(1.0, 2.0, 3.0), rotation=(0.2, 0.1, 0.5))
    system.add(plate)
    plate.marker("m", 0.3, 0.2)
    system.add(lm.Gravity("weight", (0.5, 0.0, -9.81)))
    result = lm.simulate(system, 0.5, lm.GeneralizedAlpha(dt=0.05))
    t, r = result.at[:, None], result["m.position"].values
    expected = r[0] + t * np.array((1.0, 2.0, 3.0)) + 0.5 * t**2 * np.array((0.5, 0.0, -9.81))
    np.testing.assert_allclose(r, expected, atol=1e-9)
    assert np.abs(result["energy.balance"].values).max() < 1e-6 * result["energy.kinetic"].values.max()


@pytest.mark.parametrize("t_end", [1e-12, 1e-3])
def test_a_step_much_longer_than_the_run_ends_with_it(t_end):
    system = lm.System()
    system.add(lm.Plate("plate", (1.0, 0.5), (1, 1), SECTION, velocity=(1.0, 2.0, 3.0))).marker("m", 0.3, 0.2)
    result = lm.simulate(system, t_end, lm.GeneralizedAlpha(dt=1e9))
    assert result.at[-1] == t_end
    np.testing.assert_allclose(result["m.position"][-1] - result["m.position"][0], np.multiply(t_end, (1, 2, 3)), rtol=1e-3)
    run = lm.Stepping(system, lm.GeneralizedAlpha(dt=1e9))
    run.advance(t_end)
    assert run.t == t_end


def test_moving_support_carries_the_plate():
    """A clamp that shakes a stiff plate slowly moves its tip along; the work of the support is the energy gained."""
    system, plate = lm.System(), lm.Plate("plate", (0.3, 0.2), (1, 1), SECTION)
    system.add(plate)
    plate.marker("tip", 0.3, 0.1)
    rise = lm.SmoothStep(t_end=0.5, end=0.1)
    system.add(lm.Clamp("root", plate.edge("x-"), motion={"z": rise}))
    result = lm.simulate(system, 0.6, lm.GeneralizedAlpha(dt=5e-3))
    z = result["tip.position"].values[:, 2]
    np.testing.assert_allclose(z, [rise.value(t) for t in result.at], atol=2e-4)
    balance = result["energy.balance"].values
    assert np.abs(balance).max() < 2e-2 * result["energy.kinetic"].values.max()


def test_a_run_continues_from_the_final_state_of_another():
    def system():
        made, plate = cantilever()
        made.add(lm.PointForce("load", plate.corner("x+y+"), (0, 0, 20.0)))
        return made

    options = lm.GeneralizedAlpha(dt=5e-4, rho_inf=1.0, newton=lm.Newton(tolerance=1e-11))
    whole = lm.simulate(system(), 0.04, options)
    first = lm.simulate(system(), 0.02, options)
    second = lm.simulate(system(), 0.04, options, t_start=0.02, initial=first.final)
    z = whole["tip.position"].values[-1, 2], second["tip.position"].values[-1, 2]
    # with rho = 1 the algorithmic acceleration differs from the true one that a new start uses by the order of the scheme
    assert z[1] == pytest.approx(z[0], rel=1e-3)
    assert second.at[0] == 0.02


def test_frames_are_spread_over_the_run_and_samples_are_every_step():
    system, _ = cantilever(angular_velocity=(0.0, 0.1, 0.0))
    result = lm.simulate(system, 0.05, lm.GeneralizedAlpha(dt=1e-3), frames=10)
    assert len(result.at) == 51
    assert result.statistics.steps == 50
    assert len(result.frame_at) == 11
    np.testing.assert_allclose(np.diff(result.frame_at), 5e-3, atol=1.1e-3)
    assert result.frame_q.shape == (11, result.model.n_q)


def test_a_step_cut_by_a_failure_grows_back():
    class Balky(lm.GeneralizedAlpha):
        """Refuses long steps until some time."""

        def stepper(self, equations, statistics, solver="auto"):
            inner = super().stepper(equations, statistics, solver)
            attempt = inner.step

            def step(dt):
                from lamella.integrate.base import StepOutcome
                from lamella.result import Cause
                from lamella.solve.newton import NewtonReport

                if dt > 3e-4 and inner.point.t < 2e-3:
                    return StepOutcome(NewtonReport(Cause.NOT_CONVERGED, 25, 1.0), None)
                return attempt(dt)

            inner.step = step
            return inner

    system, _ = cantilever()
    result = lm.simulate(system, 0.01, Balky(dt=1e-3))
    steps = np.diff(result.at)
    assert result.statistics.rejected >= 2
    assert steps[:4].max() <= 3e-4
    assert steps[-3:-1].max() == pytest.approx(1e-3)
    assert result.outcome.completed


def test_result_is_the_same_when_a_compiled_model_is_run_twice():
    system, plate = cantilever()
    system.add(lm.PointForce("load", plate.corner("x+y+"), (0, 0, 20.0)))
    model = system.compile()
    first, second = (lm.simulate(model, 0.01, lm.GeneralizedAlpha(dt=1e-3)) for _ in range(2))
    np.testing.assert_array_equal(first["tip.position"].values, second["tip.position"].values)
    np.testing.assert_array_equal(first["energy.balance"].values, second["energy.balance"].values)


def test_contradictory_supports_are_named():
    system, plate = cantilever()
    system.add(lm.PrescribedMotion("shaker", plate.corner("x-y-"), "z", lm.Harmonic(amplitude=0.1, frequency=1.0)))
    with pytest.raises(ConstraintError, match=r"z of the position at plate.x-y- contradicts z of r at node 0"):
        lm.simulate(system, 0.01, lm.GeneralizedAlpha(dt=1e-3))


def test_unknown_signal_lists_those_recorded():
    system, _ = cantilever()
    result = lm.simulate(system, 2e-3, lm.GeneralizedAlpha(dt=1e-3))
    with pytest.raises(DeclarationError, match=r"no signal 'tipp.position'; recorded are tip.position"):
        result["tipp.position"]


def test_a_run_interrupted_between_recorded_steps_ends_in_a_whole_state():
    """The reaction of a step that is not recorded is left out; the final state has it, whatever step it is of."""
    system, plate = cantilever()

    def push(t, r, v):
        if t > 0.0165:
            raise KeyboardInterrupt
        return np.array([[0.0, 0.0, 1.0]])

    system.add(lm.UserForce("push", (plate.corner("x+y-"),), push))
    result = lm.simulate(system, 0.05, lm.GeneralizedAlpha(dt=1e-3), stride=5, on_failure="return")
    assert result.outcome.cause is Cause.INTERRUPTED
    assert result.final.t == pytest.approx(0.016)
    assert result.at[-1] == pytest.approx(0.015)
    assert result.final.reaction.shape == result.final.q.shape
    assert result.frame_at[-1] == result.final.t
    np.testing.assert_array_equal(result.frame_q[-1], result.final.q)


def test_stride_records_less_and_sums_the_same():
    """Samples are those of every third step and the last; work and heat, which are sums over steps, are equal to rounding."""
    system, plate = cantilever(damping=2e-3)
    system.add(lm.PointForce("load", plate.corner("x+y-"), (0, 0, 5.0), lm.Harmonic(amplitude=1.0, frequency=40.0)))
    model = system.compile()
    every, third = (lm.simulate(model, 0.02, lm.GeneralizedAlpha(dt=1e-3), stride=stride) for stride in (1, 3))
    chosen = [0, 3, 6, 9, 12, 15, 18, 20]
    np.testing.assert_array_equal(third.at, every.at[chosen])
    for name in ("tip.position", "work.loads", "work.dissipated", "energy.balance"):
        np.testing.assert_allclose(third[name].values, every[name].values[chosen], rtol=1e-12, atol=1e-15)
    assert every["work.dissipated"].values[-1] > 0.0
    with pytest.raises(DeclarationError, match="stride = 0"):
        lm.simulate(model, 0.02, lm.GeneralizedAlpha(dt=1e-3), stride=0)


@pytest.mark.parametrize("begins", ["step", "event"])
def test_a_force_that_jumps_works_from_then_on(begins):
    """A body of 1 kg at 10 m/s under 5 N from 0.5 s on: all exact for generalised-alpha."""
    system = lm.System()
    body = system.add(lm.RigidBody("body", mass=1.0, inertia=(1.0, 1.0, 1.0), velocity=(10.0, 0.0, 0.0)))
    system.add(lm.PointForce("push", body.origin, (5.0, 0.0, 0.0), lm.Step(at=0.5) if begins == "step" else lm.Constant(1.0)))
    if begins == "event":
        system.add(lm.Event("go", watch="body.position", component="x", value=5.0, action="switch_on", target="push"))
    result = lm.simulate(system, 1.0, lm.GeneralizedAlpha(dt=0.02, rho_inf=0.9))
    assert result["work.loads"].values[-1] == pytest.approx(5.0 * (10.0 * 0.5 + 0.5 * 5.0 * 0.5**2), rel=1e-5)
    assert np.abs(result["energy.balance"].values).max() <= 1e-9


@pytest.mark.parametrize(
    "method", [lm.GeneralizedAlpha(dt=0.01, rho_inf=0.9, stabilised=True), lm.BDF(dt=0.01, dt_max=0.01)], ids=["alpha", "bdf"]
)
@pytest.mark.parametrize("way", [lm.Ramp(t_end=0.5, end=2.0), lm.Table((0.0, 0.5), (0.0, 2.0))], ids=["ramp", "table"])
def test_a_run_to_the_end_of_a_profile_does_not_feel_that_it_stops(method, way):
    """A slide at 4 m/s all the way: behind 0.5 s it would stand still."""
    system, ground = lm.System(), lm.Ground()
    sledge = system.add(lm.RigidBody("sledge", mass=1.0, inertia=(1.0, 1.0, 1.0), velocity=(4.0, 0.0, 0.0)))
    rail = system.add(lm.PrismaticJoint("rail", ground.origin, sledge.origin, axis=(1, 0, 0)))
    system.add(lm.SlideDrive("motor", rail, displacement=way))
    result = lm.simulate(system, 0.5, method)
    assert result.at[-1] == 0.5
    np.testing.assert_allclose(result["rail.speed"].values, 4.0, rtol=1e-9)
    assert result["rail.displacement"].values[-1] == pytest.approx(2.0, rel=1e-8)
    assert np.abs(result["motor.force"].values).max() <= 1e-5  # rounding of 4 m/s over steps of 10 ms
    assert result["energy.balance"].values[-1] == pytest.approx(0.0, abs=1e-8)
