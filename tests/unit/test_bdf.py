"""BDF: orders of fixed steps, work against precision, constraints, rejected steps, jumps, events, temperatures, dense output."""

from __future__ import annotations

import numpy as np
import pytest
from test_first_order import cooled
from test_stabilised import double_pendulum

import lamella as lm
from lamella.assembly.equations import Equations
from lamella.errors import ConvergenceError, DeclarationError
from lamella.io.results import read_result
from lamella.result import Cause, Statistics
from lamella.solve.initial import make_consistent
from lamella.solve.linear import linear_solver

TIGHT = lm.Newton(tolerance=1e-10)
ORDERS = [1, 2, 3, 4, 5]
G = 9.81


def on_a_spring():
    """A body of 2 kg on a spring of 50 N/m: z = 0.9 + 0.1 cos 5t."""
    system, ground = lm.System(), lm.Ground()
    system.add(ground)
    body = system.add(lm.RigidBody("ball", mass=2.0, inertia=(0.1, 0.1, 0.1), position=(0, 0, 1.0)))
    system.add(lm.SpringDamper("spring", ground.marker("o", 0, 0, -4.0), body.origin, stiffness=50.0, rest_length=4.9))
    return system


@pytest.fixture(scope="module")
def reference():
    """The double pendulum at 0.5 s, with an error below those of the steps compared with it."""
    return lm.simulate(double_pendulum(), 0.5, lm.BDF(dt=1e-3, tolerance=1e-10, max_order=5, newton=TIGHT)).final


@pytest.mark.parametrize("order", ORDERS)
def test_order_of_fixed_steps_against_an_exact_solution(order):
    errors = []
    for n in (50, 100):
        result = lm.simulate(on_a_spring(), 1.0, lm.BDF(dt=1 / n, tolerance=None, max_order=order, newton=TIGHT))
        assert max(result.statistics.steps_of_order) == order
        z, v = result.final.q[2], result.final.v[2]
        errors.append(np.hypot(z - 0.9 - 0.1 * np.cos(5.0), v / 5.0 + 0.1 * np.sin(5.0)))
    # omega dt = 0.1 and 0.05 leave terms of the next order, of some per cent
    assert np.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.15)


@pytest.mark.parametrize("order", [1, 2, 3, 4])
def test_order_of_positions_velocities_and_multipliers(order, reference):
    finals = [
        lm.simulate(double_pendulum(), 0.5, lm.BDF(dt=0.5 / n, tolerance=None, max_order=order, newton=TIGHT)).final
        for n in (100, 200)
    ]
    for name in ("q", "v", "lam"):
        errors = [np.abs(getattr(final, name) - getattr(reference, name)).max() for final in finals]
        assert np.log2(errors[0] / errors[1]) > order - 0.2, name  # terms of the next order, as above


@pytest.mark.parametrize("max_order", [2, 5])
def test_smaller_tolerances_take_more_steps_and_leave_smaller_errors(max_order, reference):
    errors, steps = [], []
    for tolerance in (1e-4, 1e-5, 1e-6, 1e-7):
        result = lm.simulate(double_pendulum(), 0.5, lm.BDF(dt=1e-3, tolerance=tolerance, max_order=max_order))
        errors.append(np.abs(result.final.q - reference.q).max())
        steps.append(result.statistics.steps)
        # local errors of at most the tolerance of bodies of a metre; a swing from rest stretches them less than tenfold
        assert errors[-1] < 10 * tolerance * steps[-1]
    assert steps == sorted(steps)
    assert errors == sorted(errors, reverse=True)
    assert errors[-1] < 0.05 * errors[0]


def at_work(system, **options):
    """Equations, stepper and the consistent point it starts from."""
    equations = Equations(system.compile())
    stepper = lm.BDF(**options).stepper(equations, Statistics())
    point = equations.start()
    make_consistent(equations, point, linear_solver(equations.matrix.pattern, "auto"))
    stepper.restart(point)
    return equations, stepper


def test_constraints_hold_to_rounding():
    equations, stepper = at_work(double_pendulum(), dt=1e-3, max_order=5)
    dt = stepper.first_step(1e-3)
    for _ in range(100):
        outcome = stepper.step(dt)
        if outcome.error <= 1.0:
            point = stepper.accept()
            assert equations.violation(point) < 1e-12
            assert equations.relative(equations.velocity_violation(point)) < 1e-11  # velocities of some 10 rad/s
        dt *= outcome.growth
    assert point.t > 0.3


def test_a_rejected_step_leaves_no_trace():
    ends = []
    for rejected in (False, True):
        _, stepper = at_work(double_pendulum(), dt=1e-3)
        for dt in (1e-3, 1e-3, 2e-3, 2e-3):
            stepper.step(dt)
            stepper.accept()
        if rejected:
            assert stepper.step(0.2).error > 1.0
        stepper.step(2e-3)
        ends.append(stepper.accept())
    np.testing.assert_allclose(ends[1].u, ends[0].u, atol=1e-9)  # Newton's tolerance of a change of 1e-6, with another factor
    np.testing.assert_allclose(ends[1].ud, ends[0].ud, atol=1e-6)


def test_a_step_may_not_be_accepted_after_it_was_rejected():
    _, stepper = at_work(double_pendulum(), dt=1e-3)
    assert stepper.step(0.05).error > 1.0
    with pytest.raises(AssertionError, match="accept follows"):
        stepper.accept()


def test_orders_are_counted_and_kept_in_the_file(tmp_path):
    result = lm.simulate(double_pendulum(), 0.3, lm.BDF(dt=1e-3, max_order=4))
    orders = result.statistics.steps_of_order
    assert sum(orders.values()) == result.statistics.steps
    assert set(orders) == {1, 2, 3, 4}
    assert read_result(result.save(tmp_path / "run.h5")).statistics.steps_of_order == orders


def pushed(profile):
    system = lm.System()
    body = system.add(lm.RigidBody("ball", mass=2.0, inertia=(0.1, 0.1, 0.1)))
    system.add(lm.PointForce("push", body.origin, (10.0, 0.0, 0.0), profile))
    return system


def test_jumps_are_met_and_followed_by_order_one():
    result = lm.simulate(pushed(lm.Step(at=0.4)), 1.0, lm.BDF(dt=0.05, tolerance=1e-6))
    x = result["ball.position"].values[:, 0]
    assert np.abs(result.at - 0.4).min() < 1e-15
    assert np.abs(x[result.at <= 0.4]).max() < 1e-15
    assert result.statistics.steps_of_order[1] >= 2  # at the start and after the jump
    after = np.diff(result.at)[np.flatnonzero(result.at == 0.4)[0]]
    assert after < 0.01  # a first step of order 1 has the error dt^2 a / 2
    assert x[-1] == pytest.approx(0.5 * 5.0 * 0.6**2, abs=1e-4)


@pytest.mark.parametrize("max_order", [2, 5])
def test_a_run_stops_at_the_moment_of_an_event(max_order):
    system = lm.System()
    system.add(lm.RigidBody("ball", mass=2.0, inertia=(0.1, 0.1, 0.1)))
    system.add(lm.Gravity("weight", (0, 0, -G)))
    system.add(lm.Event("ground", "ball.position", value=-0.3, component="z", action="stop"))
    result = lm.simulate(system, 1.0, lm.BDF(dt=7e-3, tolerance=1e-7, max_order=max_order))
    longest = np.diff(result.at).max()
    assert result.outcome.cause is Cause.EVENT
    # the first step of order 1 leaves an error of about the tolerance; the moment is found to 1e-6 of a step
    assert result.at[-1] == pytest.approx(np.sqrt(0.6 / G), abs=1e-6 + 2e-6 * longest)


def test_a_latch_starts_anew_with_a_short_step():
    """A lid that swings open is caught by a stiff spring; it stops and stays."""
    system, ground = lm.System(), lm.Ground()
    lid = lm.RigidBody("lid", mass=1.0, inertia=(0.1, 0.1, 0.1), position=(0.5, 0, 0))
    system.add(ground)
    system.add(lid)
    hinge = system.add(lm.RevoluteJoint("hinge", ground.marker("o", 0, 0, 0), lid.marker("in", -0.5, 0, 0), axis=(0, 1, 0)))
    system.add(lm.Gravity("weight", (0, 0, -G)))
    system.add(lm.Latch("catch", hinge, stiffness=2e3, at=0.5, damping=50.0))
    result = lm.simulate(system, 1.5, lm.BDF(dt=1e-2))
    (event,) = result.events
    steps, place = np.diff(result.at), np.flatnonzero(result.at == event.t)[0]
    assert steps[place] < 0.2 * steps[place - 2]
    assert result["hinge.angle"].values[-1] == pytest.approx(0.5 + 0.5 * G * np.cos(0.5) / 2e3, abs=1e-4)
    assert steps[-3] > 10 * steps[place]  # at rest steps grow again


def test_order_and_step_follow_a_motion_that_stops_and_goes():
    """A force of a second, rest, and another: steps are long where nothing happens."""
    profile = lm.Table((0.0, 0.5, 1.0, 3.0, 3.5, 4.0), (0.0, 1.0, 0.0, 0.0, -1.0, 0.0))
    result = lm.simulate(pushed(profile), 4.0, lm.BDF(dt=1e-2, tolerance=1e-6, max_order=3))
    steps, middle = np.diff(result.at), 0.5 * (result.at[1:] + result.at[:-1])
    assert steps[(middle > 1.5) & (middle < 3.0)].max() > 5 * np.median(steps[middle < 1.0])
    assert result["ball.velocity"].values[-1, 0] == pytest.approx(0.0, abs=1e-4)


def test_largest_step_is_respected():
    steps = np.diff(lm.simulate(on_a_spring(), 1.0, lm.BDF(dt=1e-3, tolerance=1e-2, dt_max=0.02)).at)
    assert 0.015 < steps.max() <= 0.02 * (1 + 1e-9)


def test_a_tolerance_out_of_reach_is_told():
    with pytest.raises(ConvergenceError, match="local error") as caught:
        lm.simulate(on_a_spring(), 1.0, lm.BDF(dt=0.1, dt_min=0.05, tolerance=1e-9))
    assert caught.value.outcome.cause is Cause.INACCURATE


def test_temperatures_follow_their_rates():
    for tolerance in (1e-4, 1e-6):
        options = lm.BDF(dt=0.05, tolerance=tolerance)
        result, error = cooled(options=options)
        assert error <= tolerance * 100.0 * result.statistics.steps
    assert np.diff(result.at)[-3] > 3.0 * np.median(np.diff(result.at)[5:15])


@pytest.mark.parametrize("integrator", [lm.GeneralizedAlpha(dt=0.02, rho_inf=1.0), lm.BDF(dt=0.02, tolerance=1e-6, max_order=4)])
def test_recording_between_steps_is_as_accurate_as_the_steps(integrator):
    coarse = lm.simulate(on_a_spring(), 1.0, integrator)
    result = lm.simulate(on_a_spring(), 1.0, integrator, every=1e-3)
    for k in range(1001):
        assert np.abs(result.at - 1e-3 * k).min() < 1e-12
    assert len(result.at) > len(coarse.at)
    np.testing.assert_array_equal(result.final.q, coarse.final.q)

    def error(found, name, exact):
        return np.abs(found[name].values[:, 2] - exact(found.at)).max()

    for name, exact in (
        ("ball.position", lambda t: 0.9 + 0.1 * np.cos(5 * t)),
        ("ball.velocity", lambda t: -0.5 * np.sin(5 * t)),
    ):
        # linear interpolation of velocities between the steps of generalised-alpha errs by (omega dt)^2 / 8 of 0.5 m/s
        between = 0.5 * (5 * 0.02) ** 2 / 8 if isinstance(integrator, lm.GeneralizedAlpha) else 2e-5
        assert error(result, name, exact) < 1.1 * error(coarse, name, exact) + between


@pytest.mark.parametrize("every", [0.0, -1.0, float("nan")])
def test_impossible_interval_is_refused(every):
    with pytest.raises(DeclarationError, match=r"every = .*accepted is a positive interval"):
        lm.simulate(on_a_spring(), 1.0, lm.BDF(dt=0.1), every=every)


@pytest.mark.parametrize(
    "options", [{"dt": 0.0}, {"dt": 1e-3, "max_order": 6}, {"dt": 1e-3, "max_order": 0}, {"dt": 1e-3, "tolerance": 0}]
)
def test_impossible_options_are_refused(options):
    with pytest.raises(DeclarationError, match="BDF"):
        lm.BDF(**options)
