"""Springs, dampers, stops and latches: derivatives through the equations, energy, and closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from mechanisms import ABOUT_PIN, ARM, MASS, G, arm, leaves, pair, resultants, simulated, slider
from scipy.integrate import solve_ivp

import lamella as lm
from lamella.assembly.equations import Equations
from lamella.assembly.point import Point, Weights
from lamella.errors import DeclarationError


def spring(**given):
    return lambda s, joint, body: lm.SpringDamper(
        "spring", lm.Ground().marker("peg", 1.2, 0.3, 0.9), body.marker("end", 0.2, 0.1, 0.0), **given
    )


ELASTIC = {
    "spring": lambda c: arm(spring(stiffness=300.0, damping=c, rest_length=0.7, preload=3.0)),
    "spring on a plate": lambda c: leaves(
        lambda s, hinge, plate: lm.SpringDamper(
            "spring", lm.Ground().marker("peg", 1.5, 0.1, 0.8), plate.marker("m", 0.4, 0.3), 50.0, c
        ),
        lambda s, hinge, plate: lm.Gravity("gravity"),
    ),
    "torsion spring": lambda c: arm(lambda s, pin, body: lm.TorsionSpring("spring", pin, 40.0, c, rest_angle=-0.2, preload=1.0)),
    "torsion spring of a cylindrical joint": lambda c: arm(
        lambda s, pin, body: lm.TorsionSpring("spring", pin, 40.0, c), joint=lm.CylindricalJoint
    ),
    "torsion spring along a hinge": lambda c: leaves(
        lambda s, hinge, plate: lm.TorsionSpring("spring", hinge, 30.0, c), lambda s, hinge, plate: lm.Gravity("gravity")
    ),
    "slide spring": lambda c: slider(lambda s, guide, body: lm.SlideSpring("spring", guide, 200.0, c, rest=0.05, preload=2.0)),
    "end stop": lambda c: arm(lambda s, pin, body: lm.EndStop("spring", pin, 5e3, upper=-0.05, damping=c / 10, width=0.02)),
    "elastic coupling": lambda c: pair(
        lambda s, joints, bodies: lm.AngleCoupling("spring", tuple(joints), (2, -1), stiffness=30.0, damping=c),
        lambda s, joints, bodies: lm.PointForce("push", bodies[0].marker("rim", 0.3, 0.0, 0.0), (0, 5, 0)),
    ),
}
kinds = pytest.mark.parametrize("kind", ELASTIC)


def moved(model, size=0.05):
    """A configuration and velocities beside the reference, the same each time."""
    rng = np.random.default_rng(2)
    return model.q0 + size * rng.uniform(-1.0, 1.0, model.n_q), rng.uniform(-1.0, 1.0, model.n_q)


@kinds
@pytest.mark.parametrize("c", [0.0, 4.0])
def test_tangent_is_the_derivative_of_the_residual(kind, c):
    equations = Equations(ELASTIC[kind](c).compile(), symmetric=False)
    rng = np.random.default_rng(3)
    u = equations.start().u + 0.05 * rng.uniform(-1, 1, equations.n_u)
    ud, lam = rng.uniform(-1, 1, equations.n_u), rng.uniform(-3, 3, equations.n_lam)
    alpha = 0.8

    def residual(d, h):
        return equations.residual(Point(0.1, u + h * d, ud + alpha * h * d, np.zeros_like(u), lam))[0]

    _, _, k, _ = equations.linearise(Point(0.1, u, ud, np.zeros_like(u), lam), Weights(1.0, alpha, 0.0))
    K = equations.matrix.pattern.matrix(k).toarray()
    scale = np.abs(K).max()
    for place in rng.choice(equations.n_u, min(12, equations.n_u), replace=False):
        d, h = np.eye(equations.n_u)[place], 1e-4 * equations.magnitude[place]
        numeric = (8 * (residual(d, h) - residual(d, -h)) - (residual(d, 2 * h) - residual(d, -2 * h))) / (12 * h)
        np.testing.assert_allclose(K[:, place], numeric, atol=1e-8 * scale)  # rounding of 1e-16 / 1e-4 of large forces


@kinds
def test_force_is_the_derivative_of_the_energy(kind):
    model = ELASTIC[kind](0.0).compile()
    (block,) = [block for block in model.forces if block.name == "spring"]
    q, _ = moved(model)
    f, total = np.empty(len(block.f_coords)), np.zeros(model.n_q)
    block.force(0.1, q, np.zeros_like(q), f)
    np.add.at(total, block.f_coords, f)
    for d in np.random.default_rng(4).uniform(-1, 1, (6, model.n_q)):
        V = [block.energy(0.1, q + s * 1e-4 * d) for s in (1, -1, 2, -2)]
        slope = (8 * (V[0] - V[1]) - (V[2] - V[3])) / 12e-4
        assert total @ d == pytest.approx(slope, rel=1e-7, abs=1e-7)  # a stop's third derivative jumps
    assert np.abs(total).max() > 0


@kinds
@pytest.mark.parametrize("c", [0.0, 4.0])
def test_energy_is_balanced_in_motion(kind, c):
    result = simulated(ELASTIC[kind](c), 0.3, dt=1e-3, rho_inf=1.0 if "plate" not in kind and "hinge" not in kind else 0.9)
    exchanged = max(np.ptp(result["energy.strain"].values), np.ptp(result["work.loads"].values))
    # second order in dt = 1e-3 s against motions of some 20 rad/s; plates lose what the integrator damps in their fast modes
    assert np.abs(result["energy.balance"].values).max() < 5e-3 * exchanged
    heat = result["work.dissipated"].values
    assert np.all(np.diff(heat) >= 0.0)
    assert (heat[-1] > 0.0) == (c > 0.0)


def test_torsion_spring_against_an_integrated_pendulum():
    k, c = 50.0, 0.5
    result = simulated(arm(lambda s, pin, body: lm.TorsionSpring("spring", pin, k, c)), 1.0, dt=1e-3)
    exact = solve_ivp(
        lambda t, y: [y[1], (MASS * G * ARM * np.cos(y[0]) - k * y[0] - c * y[1]) / ABOUT_PIN],
        (0.0, 1.0),
        [0.0, 0.0],
        rtol=1e-11,
        atol=1e-12,
    ).y[:, -1]
    assert result["pin.angle"].values[-1] == pytest.approx(exact[0], abs=2e-5)  # (8.5 rad/s 1e-3 s)^2 / 12 of the phase, 8 rad
    torque = k * result["pin.angle"].values[-1] + c * result["pin.rate"].values[-1]
    assert result["spring.torque"].values[-1] == pytest.approx(torque, rel=1e-9)


def test_spring_and_slide_spring_carry_a_weight():
    still = lm.equilibrium(slider(lambda s, guide, body: lm.SlideSpring("spring", guide, 200.0, rest=0.05, preload=2.0)))
    assert still["spring.force"].item() == pytest.approx(MASS * G, rel=1e-9)
    assert still["guide.displacement"].item() == pytest.approx(0.05 + (MASS * G - 2.0) / 200.0, rel=1e-9)

    def hung(s, guide, body):
        return lm.SpringDamper("spring", lm.Ground().marker("peg", 0.0, 0.0, 1.3), body.origin, 150.0, 5.0)

    still = lm.equilibrium(slider(hung))
    assert still["spring.tension"].item() == pytest.approx(MASS * G, rel=1e-9)
    assert still["spring.length"].item() == pytest.approx(1.0 + MASS * G / 150.0, rel=1e-9)


@pytest.mark.parametrize("points", [None, (0.1, 0.5)])
def test_spring_of_a_hinge_turns_both_leaves_and_pushes_neither(points):
    k, phi = 30.0, 0.4
    model = leaves(lambda s, hinge, plate: lm.TorsionSpring("spring", hinge, k), points=points).compile()
    about, q = np.array([1.0, 0.3, 0.0]), model.q0.reshape(-1, 3).copy()
    R = np.array([[np.cos(phi), 0.0, np.sin(phi)], [0.0, 1.0, 0.0], [-np.sin(phi), 0.0, np.cos(phi)]])  # about y
    mine = np.array([name == "second" for name in model.owners])
    turned = q @ R.T
    turned[model.is_position] = about + (q[model.is_position] - about) @ R.T
    q[mine] = turned[mine]
    (block,) = [block for block in model.forces if block.name == "spring"]
    f, total = np.empty(len(block.f_coords)), np.zeros(model.n_q)
    block.force(0.0, q.reshape(-1), np.zeros(model.n_q), f)
    np.add.at(total, block.f_coords, -f)
    for owner, sign in (("second", -1.0), ("first", 1.0)):
        force, torque = resultants(model, total, owner, (q.reshape(-1), about))
        np.testing.assert_allclose(force, 0.0, atol=1e-12)
        np.testing.assert_allclose(torque, [0.0, sign * k * phi, 0.0], atol=1e-12 * k)


@pytest.mark.parametrize("side", ["upper", "lower"])
def test_an_arm_comes_to_rest_at_its_stop(side):
    bound = {"upper": {"upper": 0.5}, "lower": {"lower": -0.5}}[side]

    def stop(s, pin, body):
        return lm.EndStop("stop", pin, 1e4, **bound, damping=0.5, width=1e-3)

    def lift(s, pin, body):
        return lm.PointForce("lift", body.origin, (0, 0, 2.0 * MASS * G if side == "lower" else 0.0))

    # without the weak spring nothing holds the arm between its stops
    still = lm.equilibrium(arm(stop, lift, lambda s, pin, body: lm.TorsionSpring("weak", pin, 2.0)), steps=4)
    weight = MASS * G * (1.0 if side == "upper" else -1.0)
    phi = still["pin.angle"].item()
    assert still["stop.torque"].item() + 2.0 * phi == pytest.approx(weight * ARM * np.cos(phi), rel=1e-7)
    depth = abs(phi) - 0.5
    assert abs(still["stop.torque"].item()) == pytest.approx(1e4 * (depth - 0.5e-3) if depth > 1e-3 else 1e7 / 2 * depth**2)
    result = simulated(arm(stop, lift), 1.0)
    assert 0.5 < np.abs(result["pin.angle"].values).max() < 0.56  # 3.6 rad/s on arrival against 120 rad/s of the stop
    assert result["work.dissipated"].values[-1] > 0.0


def test_a_latch_holds_the_arm_where_it_found_it():
    result = simulated(arm(lambda s, pin, body: lm.Latch("latch", pin, 2e4, at=0.6, damping=200.0)), 1.0)
    engaged, angle = result["latch.engaged"].values, result["pin.angle"].values
    first = int(np.argmax(engaged > 0))
    assert np.all(engaged[first:] == 1.0)
    assert angle[first - 1] == pytest.approx(0.6, abs=1e-7)  # the step was cut there, a millionth of 2e-3 s behind, at 3 rad/s
    sag = MASS * G * ARM * np.cos(0.6) / 2e4
    assert angle[-1] == pytest.approx(0.6 + sag, abs=2e-5)  # held at the angle a millionth of a step after 0.6
    assert [event.name for event in result.outcome.events] == ["latch"]


MESSAGES = {
    "stiffness of a spring": (lambda: arm(spring(stiffness=-1.0)), "SpringDamper 'spring': stiffness = -1"),
    "damping of a spring": (lambda: arm(spring(damping=-1.0)), "SpringDamper 'spring': damping = -1"),
    "stiffness of a hinge": (lambda: arm(lambda s, p, b: lm.TorsionSpring("t", p, -1.0)), "TorsionSpring 't': stiffness = -1"),
    "stiffness of a slide": (lambda: slider(lambda s, p, b: lm.SlideSpring("t", p, -1.0)), "SlideSpring 't': stiffness = -1"),
    "stiffness of a stop": (lambda: arm(lambda s, p, b: lm.EndStop("t", p, 0.0, 0.1)), "EndStop 't': stiffness = 0"),
    "stop without bound": (lambda: arm(lambda s, p, b: lm.EndStop("t", p, 1.0)), "neither 'lower' nor 'upper' is given"),
    "bounds of a stop": (
        lambda: arm(lambda s, p, b: lm.EndStop("t", p, 1.0, lower=0.5, upper=0.5)),
        "EndStop 't': lower = 0.5 rad; accepted is less than upper = 0.5 rad",
    ),
    "width of a stop": (lambda: arm(lambda s, p, b: lm.EndStop("t", p, 1.0, upper=0.5, width=0.0)), "width = 0"),
    "latch on a slide": (lambda: slider(lambda s, p, b: lm.Latch("t", p, 1.0)), "Latch 't': on"),
    "slide of a pin": (lambda: arm(lambda s, p, b: lm.SlideSpring("t", p, 1.0)), "SlideSpring 't': on"),
    "coinciding points": (
        lambda: arm(lambda s, p, b: lm.SpringDamper("t", p.a, p.b, 1.0)).compile(),
        "SpringDamper 't': ground.origin and arm.heel coincide; accepted are distinct points",
    ),
    "joint not added": (
        lambda: arm(
            lambda s, p, b: lm.TorsionSpring("t", lm.RevoluteJoint("loose", p.a, p.b), 1.0),
        ).compile(),
        "TorsionSpring 't': the joint 'loose' is not in the system; accepted is a joint that has been added",
    ),
}


@pytest.mark.parametrize("name", MESSAGES)
def test_impossible_values_are_named(name):
    make, message = MESSAGES[name]
    with pytest.raises(DeclarationError) as error:
        make()
    assert message in str(error.value)
