"""What every integrator must do: order, damping, error control, jumps, failures, and a motion that stays where it belongs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import lamella as lm
from lamella.errors import ConvergenceError, DeclarationError
from lamella.result import Cause
from lamella.roles import ForceBlock
from lamella.state import State

SECTION = lm.Laminate(lm.Isotropic(E=2e9, nu=0.3, rho=1200.0), thickness=0.02)
STIFF = lm.Laminate(lm.Isotropic(E=70e9, nu=0.3, rho=2700.0), thickness=0.02)
W, B, ROD, G = 0.4, 0.6, 0.8, 9.81
INTEGRATORS = {
    "generalised-alpha 1.0": lambda dt, **k: lm.GeneralizedAlpha(dt=dt, rho_inf=1.0, newton=lm.Newton(tolerance=1e-12), **k),
    "generalised-alpha 0.8": lambda dt, **k: lm.GeneralizedAlpha(dt=dt, rho_inf=0.8, newton=lm.Newton(tolerance=1e-12), **k),
    "generalised-alpha 0.0": lambda dt, **k: lm.GeneralizedAlpha(dt=dt, rho_inf=0.0, newton=lm.Newton(tolerance=1e-12), **k),
    "stabilised generalised-alpha 0.8": lambda dt, **k: lm.GeneralizedAlpha(
        dt=dt, rho_inf=0.8, newton=lm.Newton(tolerance=1e-12), stabilised=True, **k
    ),
    # its error is four times that of the trapezoidal rule: half the step for as much
    "bdf of order 2": lambda dt, **k: lm.BDF(dt=0.5 * dt, tolerance=None, newton=lm.Newton(tolerance=1e-10), **k),
}
METHODS = {"generalised-alpha": lm.GeneralizedAlpha, "bdf": lm.BDF}
each = pytest.mark.parametrize("make", INTEGRATORS.values(), ids=INTEGRATORS.keys())
each_method = pytest.mark.parametrize("method", METHODS.values(), ids=METHODS.keys())


def cantilever(strain="linear", mesh=(2, 1), **changes):
    system, plate = lm.System(), lm.Plate("plate", (1.0, 0.3), mesh, SECTION, strain=strain, **changes)
    system.add(plate)
    plate.marker("tip", 1.0, 0.15)
    system.add(lm.Clamp("root", plate.edge("x-")))
    return system, plate


def first_mode(system):
    modes = lm.modes(system, 1)
    return modes, 2 * np.pi * modes.frequencies[0], modes.displaced(0, 0.01) - modes.state


def released(modes, shape):
    zero = np.zeros_like(shape)
    return State(0.0, modes.state + shape, zero, zero, np.zeros(0), np.zeros(0))


def pendulum(first=0.5, second=0.9, load=None):
    """A plate that hangs on a rod, out of its plumb line, under a weight that sets in smoothly."""
    system, ground = lm.System(), lm.Ground()
    system.add(ground)
    hook = np.array([0.0, ROD * np.sin(first), -ROD * np.cos(first)])
    corner = hook + B * np.array([0.0, np.sin(second), -np.cos(second)]) - np.array([W / 2, 0.0, 0.0])
    turn = (np.pi / 2 + second, 0.0, 0.0)
    plate = lm.Plate("plate", (W, B), (1, 1), STIFF, position=tuple(corner), rotation=turn)
    system.add(plate)
    plate.marker("bottom", W / 2, 0.0)
    system.add(lm.DistanceJoint("rod", ground.marker("peg", 0, 0, 0), plate.marker("top", W / 2, B)))
    system.add(lm.Gravity("weight", (0, 0, -G), load or lm.SmoothStep(t_end=0.2)))
    return system


def orders(errors):
    return np.log2(np.array(errors[:-1]) / np.array(errors[1:]))


@each
def test_order_against_an_exact_solution(make):
    """A linear plate released from its first mode swings as cos(omega t)."""
    system, _ = cantilever()
    modes, omega, shape = first_mode(system)
    end, errors = 0.8 * 2 * np.pi / omega, []
    for n in (20, 40, 80):
        final = lm.simulate(system, end, make(end / n), initial=released(modes, shape)).final
        q = modes.state + shape * np.cos(omega * end)
        v = -shape * omega * np.sin(omega * end)
        errors.append(np.hypot(np.abs(final.q - q).max(), np.abs(final.v - v).max() / omega))
    # the period is wrong by (omega dt)^2 / 12 to (omega dt)^2 / 3, with omega dt = 0.063 over 5 radians
    assert errors[-1] < 0.01 * np.abs(shape).max()
    assert (orders(errors) > 1.85).all()


@each
def test_order_of_positions_velocities_and_multipliers_with_a_constraint(make):
    """The rod's force converges with the order of the motion; at 100 steps and fewer some are rejected and cut."""
    system, end = pendulum(), 0.5
    runs = [lm.simulate(system, end, make(end / n)) for n in (200, 400, 1600)]
    finals = [[r["bottom.position"].values[-1], r["bottom.velocity"].values[-1], r.final.lam] for r in runs]
    errors = [[np.abs(x - exact).max() for x, exact in zip(final, finals[-1], strict=True)] for final in finals[:-1]]
    assert (orders(errors)[-1] > 1.8).all()


@each
def test_constraint_holds_at_every_step(make):
    result = lm.simulate(pendulum(), 0.3, make(5e-3))
    distance = np.linalg.norm(result["top.position"].values, axis=1)
    np.testing.assert_allclose(distance, ROD, atol=1e-10)


@pytest.mark.parametrize("rho", [0.0, 0.5, 0.9, 1.0])
def test_spectral_radius_at_infinite_frequency(rho):
    """At omega dt = 1e4 all eigenvalues of a step are -rho: z_n / (-rho)^n is a quadratic in n, its third differences vanish."""
    system, _ = cantilever()
    modes, omega, shape = first_mode(system)
    integrator = lm.GeneralizedAlpha(dt=1e4 / omega, rho_inf=rho, newton=lm.Newton(tolerance=1e-15))
    result = lm.simulate(system, 16e4 / omega, integrator, initial=released(modes, shape))
    z = result["tip.position"].values[:, 2]
    if rho == 0.0:
        assert np.abs(z[4:]).max() < 1e-6 * abs(z[0])
    else:
        shares = z[1:] / (-rho) ** np.arange(1, len(z))
        assert np.abs(np.diff(shares, 3)).max() < 1e-3 * np.abs(shares).max()


def thrown(modes, omega, shape):
    """The reference configuration with the velocity of a mode: no stretching to start with."""
    zero = np.zeros_like(shape)
    return State(0.0, modes.state.copy(), omega * shape, zero, np.zeros(0), np.zeros(0))


def test_error_control_meets_its_tolerance_and_rejects():
    system, _ = cantilever("exact")
    modes, omega, shape = first_mode(system)
    start, end = thrown(modes, omega, shape), 1.5 * 2 * np.pi / omega
    fine = lm.simulate(system, end, lm.GeneralizedAlpha(dt=end / 2000), initial=start)
    errors, steps = [], []
    for tolerance in (1e-4, 1e-5, 1e-6):
        options = lm.GeneralizedAlpha(dt=end / 10, tolerance=tolerance, dt_min=end / 1e6)  # far too long: must be rejected
        result = lm.simulate(system, end, options, initial=start)
        assert result.statistics.rejected >= 1
        errors.append(np.abs(result["tip.position"].values[-1] - fine["tip.position"].values[-1]).max())
        steps.append(result.statistics.steps)
    assert steps[0] < steps[1] < steps[2]
    assert errors[2] < errors[0]
    assert errors[2] < 0.02 * np.abs(shape).max()  # some hundred steps whose local errors of 1e-6 of the length add up


@each_method
def test_error_control_that_cannot_meet_its_tolerance_fails(method):
    system, _ = cantilever("exact")
    modes, omega, shape = first_mode(system)
    options = method(dt=0.05, dt_min=0.02, tolerance=1e-9)
    with pytest.raises(ConvergenceError, match=r"stopped at 0 of 0\.2.*local error") as caught:
        lm.simulate(system, 0.2, options, initial=thrown(modes, omega, shape))
    assert not caught.value.outcome.completed
    assert caught.value.outcome.cause is Cause.INACCURATE


@each_method
def test_error_control_respects_the_largest_step(method):
    system, _ = cantilever()
    modes, _, shape = first_mode(system)
    options = method(dt=1e-4, tolerance=0.5, dt_max=4e-3)
    result = lm.simulate(system, 0.05, options, initial=released(modes, shape))
    assert np.diff(result.at).max() <= 4e-3 * (1 + 1e-9)
    assert np.diff(result.at).max() > 1e-3


def test_jump_of_a_load_is_met_exactly_and_starts_anew():
    system, plate = cantilever("exact")
    jump = 0.0123
    system.add(lm.PointForce("push", lm.Plate.marker(plate, "tip", 1.0, 0.15), (0, 0, 30.0), lm.Step(at=jump)))
    result = lm.simulate(system, 0.03, lm.GeneralizedAlpha(dt=2e-3))
    assert np.abs(result.at - jump).min() < 1e-15
    z = result["tip.position"].values[:, 2]
    assert np.abs(z[result.at <= jump]).max() == 0.0
    other, plate = cantilever("exact")
    other.add(lm.PointForce("push", lm.Plate.marker(plate, "tip", 1.0, 0.15), (0, 0, 30.0)))
    moved = lm.simulate(other, 0.03 - jump, lm.GeneralizedAlpha(dt=2e-3))  # the same, from time zero
    after = z[result.at >= jump]
    steps = min(len(after), len(moved.at)) - 2  # the last steps differ in size
    np.testing.assert_allclose(after[:steps], moved["tip.position"].values[:steps, 2], rtol=1e-6, atol=1e-12)


def test_end_time_is_met_when_the_step_does_not_divide_it():
    system, _ = cantilever()
    result = lm.simulate(system, 0.0107, lm.GeneralizedAlpha(dt=1e-3))
    assert result.at[-1] == 0.0107
    assert np.diff(result.at).min() > 0.5e-3


@each_method
def test_an_equilibrium_stays_at_rest(method):
    system, plate = cantilever("exact")
    system.add(lm.PointForce("push", lm.Plate.marker(plate, "tip", 1.0, 0.15), (0, 0, -40.0)))
    still = lm.equilibrium(system, newton=lm.Newton(tolerance=1e-12, keep=0.0))
    assert still["tip.position"].values[2] < -0.01
    result = lm.simulate(system, 0.1, method(dt=1e-3), initial=still.final)
    z = result["tip.position"].values
    assert np.abs(z - z[0]).max() < 1e-9


def test_release_begins_with_the_acceleration_of_the_load_removed():
    system, plate = cantilever("exact")
    tip = lm.Plate.marker(plate, "tip", 1.0, 0.15)
    system.add(lm.PointForce("push", tip, (0, 0, -40.0), lm.Step(at=1.0)))
    still = lm.equilibrium(system, t=1.0)
    result = lm.simulate(system, 0.15, lm.GeneralizedAlpha(dt=1e-3), initial=still.final)
    z = result["tip.position"].values[:, 2]
    assert z[0] == pytest.approx(still["tip.position"].values[2])
    assert z.max() == pytest.approx(-z[0], rel=0.15)  # it swings to the other side
    balance = result["energy.balance"].values
    assert balance.max() < 1e-4 * result["energy.strain"].values[0]


def test_coarse_steps_do_not_land_on_folded_solutions():
    """With steps of 16 ms the step equations of the swinging plate also have solutions with elements folded over."""
    result = lm.simulate(pendulum(load=lm.Constant(1.0)), 0.4, lm.GeneralizedAlpha(dt=0.016, rho_inf=0.8))
    potential = 0.02 * 2700 * W * B * G * (ROD + B)
    assert np.abs(result["energy.balance"].values).max() < 0.01 * potential


class Breaking(ForceBlock):
    """A force that becomes something else at a time: NaN, or noise that no Newton can follow.

    The noise is without period, as iterates take one evaluation, two or three.
    """

    name = "breaking"
    depends_on_velocity = True  # else it is evaluated once for each time

    def __init__(self, kind, at):
        self.kind, self.at, self.calls = kind, at, 0
        self.f_coords, self.f_scale = np.array([62], dtype=np.int64), np.ones(1)  # z of a free corner
        self.k_rows = self.k_cols = np.zeros(0, dtype=np.int64)
        self.k_scale = np.zeros(0)

    def force(self, t, q, v, f):
        self.calls += 1
        late = t > self.at
        f[0] = (np.nan if self.kind == "nan" else 1e9 * np.cos(self.calls**2)) if late else 0.0

    def force_tangent(self, t, q, v, alpha_q, alpha_v, q_previous, f, k):
        self.force(t, q, v, f)

    def energy(self, t, q):
        return 0.0


class Witness:
    """A sink that remembers how it was closed, and may interrupt."""

    def __init__(self, interrupt_at=np.inf):
        self.interrupt_at, self.closed, self.samples = interrupt_at, [], 0

    def sample(self, at, values):
        self.samples += 1
        if at >= self.interrupt_at:
            raise KeyboardInterrupt

    def frame(self, at, state):
        pass

    def close(self, outcome, statistics):
        self.closed.append(outcome)


def broken(kind):
    from dataclasses import replace

    system, _ = cantilever("exact")
    model = system.compile()
    return replace(model, loads=(Breaking(kind, 0.0052),))


@each_method
@pytest.mark.parametrize(("kind", "cause"), [("nan", Cause.NOT_FINITE), ("noise", Cause.NOT_CONVERGED)])
def test_failure_says_how_far_it_got_and_keeps_what_was_computed(method, kind, cause):
    witness = Witness()
    with pytest.raises(ConvergenceError, match=r"stopped at 0\.005\d* of 0\.02") as caught:
        lm.simulate(broken(kind), 0.02, method(dt=1e-3), sinks=[witness])
    outcome, result = caught.value.outcome, caught.value.result
    assert outcome.cause is cause
    assert 0.005 <= outcome.reached <= 0.0053
    assert outcome.target == 0.02
    assert result.at[-1] == outcome.reached
    assert np.isfinite(result["tip.position"].values).all()
    assert witness.closed == [outcome]


def test_failure_can_be_returned():
    result = lm.simulate(broken("nan"), 0.02, lm.GeneralizedAlpha(dt=1e-3), on_failure="return")
    assert not result.outcome.completed
    assert len(result.at) >= 6


@pytest.mark.parametrize("on_failure", ["raise", "return"])
def test_interruption_closes_the_sinks_and_keeps_the_samples(on_failure):
    system, _ = cantilever()
    witness = Witness(interrupt_at=0.01)
    if on_failure == "raise":
        with pytest.raises(KeyboardInterrupt):
            lm.simulate(system, 0.05, lm.GeneralizedAlpha(dt=1e-3), sinks=[witness])
    else:
        result = lm.simulate(system, 0.05, lm.GeneralizedAlpha(dt=1e-3), sinks=[witness], on_failure="return")
        assert result.outcome.cause is Cause.INTERRUPTED
    (outcome,) = witness.closed
    assert outcome.cause is Cause.INTERRUPTED
    assert outcome.reached == pytest.approx(0.01, abs=1.1e-3)


@pytest.mark.parametrize("t_end", [0.0, -1.0, float("nan"), float("inf")])
def test_impossible_end_is_refused(t_end):
    system, _ = cantilever()
    with pytest.raises(DeclarationError, match=r"t_end = .*accepted is a finite time later than t_start"):
        lm.simulate(system, t_end, lm.GeneralizedAlpha(dt=1e-3))


@pytest.mark.parametrize(
    "options", [{"dt": 0.0}, {"dt": -1e-3}, {"dt": float("nan")}, {"dt": 1e-3, "rho_inf": 1.1}, {"dt": 1e-3, "tolerance": 0}]
)
def test_impossible_options_are_refused(options):
    with pytest.raises(DeclarationError, match="GeneralizedAlpha"):
        lm.GeneralizedAlpha(**options)


@pytest.mark.parametrize("method", [lm.GeneralizedAlpha(1e-3), lm.BDF(1e-3)])
def test_an_integrator_may_be_made_from_another(method: lm.GeneralizedAlpha | lm.BDF) -> None:
    changed = replace(method, dt=5e-4)
    assert (changed.dt, changed.dt_max) == (5e-4, np.inf)
    with pytest.raises(DeclarationError, match="not finite"):
        replace(method, dt=np.inf)
