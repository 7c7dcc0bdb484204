"""Controllers in the loop against exact sampled systems, their laws, and what is told when one goes wrong."""

from __future__ import annotations

import numpy as np
import pytest
from linear_systems import cantilever, hub, pendulum, system_of
from scipy.signal import cont2discrete

import lamella as lm
from lamella.assembly.equations import Equations
from lamella.errors import DeclarationError, FunctionError, ModelError
from lamella.io.results import ResultWriter, read_result
from lamella.result import Cause
from lamella.signals import system_signals

MASS, PERIOD, END = 2.0, 0.05, 1.0
STEPS = lm.GeneralizedAlpha(dt=0.02, newton=lm.Newton(tolerance=1e-12))  # no divisor of the period


def sledge(law, measures=("sledge.position.x",), start=0.0, **more):
    """A free body pushed along x by a force of 1 N times the output."""
    body = lm.RigidBody("sledge", mass=MASS, inertia=(1, 1, 1), position=(start, 0, 0))
    push = lm.PointForce("push", body.origin, (1.0, 0, 0))
    return system_of(body, push, lm.Controller("pilot", measures, ("push",), law, PERIOD, **more))


def sampled(law, start, read=lambda x, v: [x]):
    """The sampled double integrator: x and u at the sample times."""
    x, v, state, rows = start, 0.0, law.initial, []
    for k in range(round(END / PERIOD) + 1):
        u, state = law.sample(k * PERIOD, np.array(read(x, v)), state, PERIOD)
        rows.append((x, float(u[0])))
        x, v = x + PERIOD * v + 0.5 * PERIOD**2 * u[0] / MASS, v + PERIOD * u[0] / MASS
    return np.array(rows)


PD = lm.PID(proportional=30.0, integral=8.0, derivative=12.0, reference=lm.Ramp(t_end=0.3, end=0.5))
FUNCTION = lm.FunctionLaw(lambda t, y, x: (-20.0 * y[0] - 4.0 * x[0], np.array([0.5 * x[0] + y[0]])), start=(0.0,))
FILTER = lm.StateSpaceLaw(A=((0.5,),), B=((1.0,),), C=((-4.0,),), D=((-20.0,),))
LIMITED = lm.PID(proportional=100.0, integral=50.0, limit=3.0)


@pytest.mark.parametrize("law", [PD, FUNCTION, FILTER, LIMITED], ids=["pid", "function", "state space", "limited"])
def test_a_free_body_moves_as_the_sampled_double_integrator(law):
    """A force that is held gives a constant acceleration, for which generalised-alpha is exact."""
    run = lm.simulate(sledge(law, start=0.2), END, STEPS)
    expected = sampled(law, 0.2)
    x, u = run["sledge.position"].values[:, 0], run["pilot.output"].values
    for k, (place, output) in enumerate(expected[:-1]):
        both = np.flatnonzero(np.abs(run.at - k * PERIOD) < 1e-9)
        np.testing.assert_allclose(x[both], place, rtol=1e-9, atol=1e-11)
        assert u[both[-1]] == pytest.approx(output, rel=1e-8, abs=1e-9)
        assert len(both) == 2  # before the jump and behind it
    if law is not LIMITED:
        assert run["energy.balance"].values[-1] == pytest.approx(0.0, abs=1e-9)  # the jumps of the force do no work
    else:
        assert np.abs(u).max() == 3.0


def test_function_and_state_space_of_one_law_agree():
    runs = [lm.simulate(sledge(law, start=0.2), END, STEPS) for law in (FUNCTION, FILTER)]
    np.testing.assert_allclose(runs[0]["pilot.state"].values, runs[1]["pilot.state"].values, atol=1e-12)


def test_a_second_run_begins_anew():
    model = sledge(PD).compile()
    first, second = (lm.simulate(model, 0.3, STEPS) for _ in range(2))
    np.testing.assert_array_equal(first["pilot.state"].values, second["pilot.state"].values)


@pytest.mark.parametrize("integrator", [STEPS, lm.BDF(dt=0.02)], ids=["generalised-alpha", "BDF"])
def test_a_sample_is_one_where_a_load_jumps_a_rounding_behind_it(integrator):
    """2 x 0.15 s is less than 3 x 0.1 s by one bit: a law with a state must not step it twice there."""
    at, period = 3 * 0.1, 0.15
    assert 2 * period < at
    body = lm.RigidBody("sledge", mass=MASS, inertia=(1, 1, 1))
    side = lm.PointForce("side", body.origin, (0, 1.0, 0), profile=lm.Step(at=at))
    push = lm.PointForce("push", body.origin, (1.0, 0, 0))
    count = lm.FunctionLaw(lambda t, y, x: (0.0, x + 1.0), start=(0.0,))
    pilot = lm.Controller("pilot", ("sledge.position.x",), ("push",), count, period)
    run = lm.simulate(system_of(body, side, push, pilot), 0.5, integrator)
    assert run["pilot.state"].values[-1, 0] == 4.0  # at 0, 0.15, 0.3 and 0.45 s


def test_a_load_that_jumps_hardly_before_a_sample_does_not_keep_the_run_from_going_on():
    """What is left to the sample is more than a share of the period, and less than that of the integrator's step."""
    body = lm.RigidBody("sledge", mass=MASS, inertia=(1, 1, 1))
    side = lm.PointForce("side", body.origin, (0, 1.0, 0), profile=lm.Step(at=0.3 - 5e-11))
    push = lm.PointForce("push", body.origin, (1.0, 0, 0))
    pilot = lm.Controller("pilot", ("sledge.position.x",), ("push",), lm.FunctionLaw(lambda t, y: 1.0), 0.01)
    run = lm.simulate(system_of(body, side, push, pilot), 0.4, lm.GeneralizedAlpha(dt=0.1))
    assert run["sledge.position"].values[-1, 0] == pytest.approx(0.5 * 0.4**2 / MASS)


def test_a_plate_is_damped_as_its_linear_model_foretells():
    """Feedback of the tip's velocity, sampled 70 times in the first period."""
    period, gain = 2e-3, 1.5
    plain = cantilever(load=1.0, damping=3e-4)
    law = lm.FunctionLaw(lambda t, y: 0.02 - gain * y[0])
    system = system_of(*plain.declarations, lm.Controller("brake", ("tip.velocity.z",), ("load",), law, period))
    # in the loop, the load is off in the linear model's steady state: both give the open loop
    open_loop = lm.linearise(system, ("load",), ("tip.position.z", "tip.velocity.z"))
    model = open_loop.state_space(6)
    expected = lm.linearise(cantilever(damping=3e-4), ("load",), ("tip.position.z",)).state_space(6)
    np.testing.assert_allclose(np.abs(model.poles()), np.abs(expected.poles()), rtol=1e-9)
    run = lm.simulate(system, 0.3, lm.GeneralizedAlpha(dt=4e-4, rho_inf=0.95))
    A, B, C, *_ = cont2discrete((model.A, model.B, model.C, model.D), period)
    x, z = np.zeros(len(A)), []
    for _ in range(150):
        y = C @ x
        z.append(y[0])
        x = A @ x + B[:, 0] * (0.02 - gain * y[1])
    t = period * np.arange(150)
    found = np.interp(t, run.at, run["tip.position"].values[:, 2])
    # as the step without a loop: phase of the time steps, and modes that they do not resolve
    assert np.abs(found - z).max() < 1e-2 * np.abs(z).max()
    assert np.abs(z[-40:] - np.mean(z[-40:])).max() < 0.2 * np.max(z)  # it is a brake


def sunlit():
    """A plate that the sun heats and bends."""
    foil = lm.Laminate(lm.Isotropic(E=7e9, nu=0.3, rho=2700.0, alpha=2e-5, k=150.0, c=900.0), thickness=2e-3)
    plate = lm.Plate("plate", (0.5, 0.1), (2, 1), foil, damping=1e-3)
    plate.marker("tip", 0.5, 0.05)
    sun = lm.SolarFlux("sun", plate, (0, 0, -1.0), constant=1e5, absorptivity=0.8)
    return system_of(plate, lm.Clamp("root", plate.edge("x-")), lm.TemperatureField("heat", plate), sun)


@pytest.mark.parametrize(
    ("make", "load", "watched"),
    [
        (lambda: pendulum(angle=0.5, torque=lm.Constant(1.0)), "motor", "bob.position"),
        (lambda: hub(omega=5.0, torque=1.0, damping=1e-2), "motor", "tip.position"),
        (sunlit, "sun", "tip.position"),
        (sunlit, "sun", "tip.T_N"),
    ],
    ids=["pendulum", "damped blade on a hub", "heated plate", "its temperature"],
)
def test_samples_without_a_jump_leave_the_motion_as_it_is(make, load, watched):
    """A controller that always asks for the same does not disturb the integrator, which keeps its numerical damping.

    Newton's method leaves 1e-14 of the body's size in a step; errors of velocity add that up to some 5e-11 of it in 100 steps,
    1e-7 of a motion by a thousandth of the size.
    """
    steps = lm.GeneralizedAlpha(dt=1e-3, rho_inf=0.9, newton=lm.Newton(tolerance=1e-12))
    plain = lm.simulate(make(), 0.1, steps)
    pilot = lm.Controller("pilot", ("energy.kinetic",), (load,), lm.FunctionLaw(lambda t, y: 1.0), 2e-3)
    looped = lm.simulate(system_of(*make().declarations, pilot), 0.1, steps)
    once = np.searchsorted(looped.at, plain.at - 1e-9)
    found, expected = looped[watched].values[once], plain[watched].values
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-7 * np.abs(expected - expected[0]).max())


@pytest.mark.parametrize("rho_inf", [0.9, 0.6])
def test_a_turning_plate_with_stiff_damping_is_steered_without_rejected_steps(rho_inf):
    """Its damping brakes what stretches it a hundred times more than critically: any blow at the samples would grow."""
    foam = lm.Laminate(lm.Isotropic(E=1.93e9, nu=0.3, rho=36.8), thickness=10.3e-3)
    ground, body = lm.Ground(), lm.RigidBody("hub", mass=400.0, inertia=(200.0, 200.0, 200.0))
    panel = lm.Plate("panel", (7.5, 0.5), (4, 1), foam, position=(0, -0.25, 0), damping=1e-2)
    bearing = lm.RevoluteJoint("bearing", ground.origin, body.origin, axis=(0, 1, 0))
    wheel = lm.PointMoment("wheel", body.origin, (0, 1.0, 0))
    root = lm.FixedJoint("root", body.origin, panel.edge("x-"), kind="sliding")
    law = lm.FunctionLaw(lambda t, y: 40.0 * (0.1 * min(t / 5.0, 1.0) - y[0]))
    pilot = lm.Controller("pilot", ("bearing.rate",), ("wheel",), law, 0.2)
    system = system_of(ground, body, panel, bearing, root, wheel, pilot)
    run = lm.simulate(system, 30.0, lm.GeneralizedAlpha(dt=0.1, rho_inf=rho_inf, newton=lm.Newton(tolerance=1e-8)))
    assert run.statistics.rejected == 0
    assert run.statistics.steps == 300


@pytest.mark.parametrize(
    ("law", "said"),
    [
        (lm.FunctionLaw(lambda t, y: 1.0 / 0.0 if t > 0.1 else 0.0), r"'pilot' at t = 0.15 s: its law raised ZeroDivisionError"),
        (lm.FunctionLaw(lambda t, y: np.nan), r"at t = 0 s: its law gave the outputs \[nan\]; accepted is one finite number"),
        (lm.FunctionLaw(lambda t, y: 1e300), r"gave the outputs \[1.e\+300\]; accepted is one finite number of up to 1e\+30"),
        (lm.FunctionLaw(lambda t, y: [1.0, 2.0]), r"gave the outputs \[1. 2.\]; accepted is one finite"),
        (lm.FunctionLaw(lambda t, y, x: (0.0, [1.0, 2.0]), start=(0.0,)), r"gave the states \[1. 2.\]; accepted is one finite"),
        (lm.FunctionLaw(lambda t, y, x: 0.0, start=(0.0,)), r"a law with a state gives the pair"),
        (lm.FunctionLaw(lambda t, y: "much"), "its law raised ValueError: could not convert"),
    ],
)
def test_a_law_that_goes_wrong_is_told_with_its_time(law, said):
    with pytest.raises(ModelError, match=said):
        lm.simulate(sledge(law), END, STEPS)


def test_what_was_computed_until_a_law_goes_wrong_is_kept(tmp_path):
    def breaks(t, y):
        if t > 0.1:
            raise LookupError("no more")
        return 0.0

    system = sledge(lm.FunctionLaw(breaks))
    path, signals = tmp_path / "run.h5", system_signals(Equations(system.compile()))
    sink = ResultWriter(path, signals, "time", system.compile().n_q)
    with pytest.raises(FunctionError, match="its law raised LookupError: no more") as caught:
        lm.simulate(system, END, STEPS, sinks=(sink,))
    assert isinstance(caught.value.__cause__, LookupError)
    kept, stored = caught.value.result, read_result(path)
    for result in (kept, stored, lm.simulate(system, END, STEPS, on_failure="return")):
        assert result.outcome.cause is Cause.FUNCTION_FAILED
        assert result.at[-1] == result.outcome.reached == pytest.approx(0.15)
        assert "its law raised LookupError: no more" in result.outcome.detail
    np.testing.assert_array_equal(stored.at, kept.at)


def test_a_function_may_fill_one_array_for_several_controllers():
    """It fills it anew for the second one, which is not what the first one gave."""
    given = np.zeros(1)

    def law(t, y):
        given[:] = -y
        return given

    bodies = [lm.RigidBody(name, mass=MASS, inertia=(1, 1, 1), position=(x, 0, 0)) for name, x in (("one", 1.0), ("two", 5.0))]
    pushes = [lm.PointForce(f"push_{body.name}", body.origin, (1.0, 0, 0)) for body in bodies]
    pilots = [
        lm.Controller(f"pilot_{body.name}", (f"{body.name}.position.x",), (push.name,), lm.FunctionLaw(law), PERIOD)
        for body, push in zip(bodies, pushes, strict=True)
    ]
    run = lm.simulate(system_of(*bodies, *pushes, *pilots), 0.1, STEPS)
    assert [run[f"pilot_{body.name}.output"].values[1] for body in bodies] == [-1.0, -5.0]


def test_a_pid_takes_one_value():
    with pytest.raises(ModelError, match="a PID takes one measured value, 2 are given"):
        lm.simulate(sledge(PD, measures=("sledge.position.x", "sledge.velocity.x")), END, STEPS)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"measures": ("sledge.place.x",)}, r"there is no single value 'sledge.place.x'; accepted are .*sledge\.position\.x"),
        ({"measures": ("sledge.position",)}, "there is no single value 'sledge.position'"),
        ({"on": ("pull",)}, "there is no load 'pull'; there are: push"),
        ({"period": 0.0}, "period"),
    ],
)
def test_wrong_names_are_told(change, said):
    body = lm.RigidBody("sledge", mass=MASS, inertia=(1, 1, 1))
    push = lm.PointForce("push", body.origin, (1.0, 0, 0))
    arguments = {"measures": ("sledge.position.x",), "on": ("push",), "law": PD, "period": PERIOD} | change
    with pytest.raises(DeclarationError, match=said):
        lm.simulate(system_of(body, push, lm.Controller("pilot", **arguments)), END, STEPS)


def test_two_controllers_cannot_drive_one_load():
    system = sledge(PD)
    system.add(lm.Controller("second", ("sledge.position.x",), ("push",), PD, 0.1))
    with pytest.raises(DeclarationError, match="another controller drives 'push'"):
        system.compile()


def test_matrices_that_do_not_fit_are_refused():
    with pytest.raises(DeclarationError, match=r"accepted are A \(n, n\), B \(n, p\)"):
        lm.StateSpaceLaw(A=((0.5,),), B=((1.0, 2.0),), C=((-4.0,),), D=((-20.0,),))
