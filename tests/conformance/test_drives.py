"""Drives, couplings and cables: derivatives through the equations, energy, and closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from mechanisms import ABOUT_PIN, ARM, MASS, G, arm, leaves, pair, simulated, slider

import lamella as lm
from lamella.assembly.equations import Equations
from lamella.assembly.point import Point, Weights
from lamella.errors import DeclarationError

RISE = lm.SmoothStep(t_end=0.4, end=0.8)


def rope(*extra, closed=False, pegs=((-1.0, 0.0, 0.0), (1.0, 0.0, 0.5)), hook=(0.2, 0.0, -0.9), mass=MASS):
    """A weight on a rope over two pegs, hung at its centre of mass."""
    system, ground = lm.System(), lm.Ground()
    weight = system.add(lm.RigidBody("weight", mass=mass, inertia=(0.1, 0.1, 0.1), position=hook))
    left, right = (ground.marker(name, *place) for name, place in zip(("left", "right"), pegs, strict=True))
    points = (left, right, weight.origin) if closed else (left, weight.origin, right)
    system.add(lm.Cable("rope", points, closed=closed))
    system.add(lm.Gravity("gravity"))
    for make in extra:
        system.add(make(system))
    return system


def sliders(*extra):
    """Two blocks on rails along x, moved in the ratio 1 to 2; a force of 6 N pushes the first."""
    system, ground = lm.System(), lm.Ground()
    blocks = []
    for k in range(2):
        block = system.add(lm.RigidBody(f"block{k}", mass=1.0 + k, inertia=(0.1, 0.1, 0.1), position=(0.5 * k, 1.0 * k, 0.0)))
        centre = block.marker(f"centre{k}", 0.0, 0.0, 0.0)
        rail = ground.marker(f"rail{k}", 0.5 * k, 1.0 * k, 0.0)
        system.add(lm.PrismaticJoint(f"guide{k}", rail, centre, axis=(1, 0, 0)))
        blocks.append(centre)
    system.add(lm.PositionCoupling("loop", tuple(blocks), ("x", "x"), (2, -1)))
    system.add(lm.PointForce("push", blocks[0], (6, 0, 0)))
    return system


HELD = {
    "angle drive": lambda: arm(lambda s, pin, body: lm.AngleDrive("drive", pin, angle=RISE)),
    "angle drive by speed": lambda: arm(lambda s, pin, body: lm.AngleDrive("drive", pin, speed=RISE)),
    "drive of a hinge": lambda: leaves(
        lambda s, hinge, plate: lm.AngleDrive("drive", hinge, angle=RISE), lambda s, hinge, plate: lm.Gravity("gravity")
    ),
    "slide drive": lambda: slider(lambda s, guide, body: lm.SlideDrive("drive", guide, displacement=RISE)),
    "slide drive by speed": lambda: slider(lambda s, guide, body: lm.SlideDrive("drive", guide, speed=RISE)),
    "rigid coupling": lambda: pair(
        lambda s, joints, bodies: lm.AngleCoupling("drive", tuple(joints), (2, -1)),
        lambda s, joints, bodies: lm.PointForce("push", bodies[0].marker("rim", 0.3, 0.0, 0.0), (0, 5, 0)),
    ),
    "rope": lambda: rope(),
    "closed rope": lambda: rope(closed=True),
    "winch": lambda: rope(
        lambda s: lm.Cable(
            "winch", (lm.Ground().marker("top", 0, 0, 3), s.bodies[0].origin), change=lm.SmoothStep(0, t_end=0.4, end=-0.2)
        )
    ),
    "sliders": sliders,
}
kinds = pytest.mark.parametrize("kind", HELD)


@kinds
def test_tangent_is_the_derivative_of_the_residual(kind):
    equations = Equations(HELD[kind]().compile(), symmetric=False)
    rng = np.random.default_rng(3)
    u, zero = equations.start().u + 0.05 * rng.uniform(-1, 1, equations.n_u), np.zeros(equations.n_u)
    lam = rng.uniform(-3, 3, equations.n_lam)
    _, _, k, j = equations.linearise(Point(0.1, u, zero, zero, lam), Weights(1.0, 0.0, 0.0))
    pattern = equations.matrix.pattern
    K, J = pattern.matrix(k).toarray(), pattern.jacobian(j).toarray()
    for place in rng.choice(equations.n_u, min(12, equations.n_u), replace=False):
        d, h = np.eye(equations.n_u)[place], 1e-4 * equations.magnitude[place]
        r = [np.concatenate(equations.residual(Point(0.1, u + s * h * d, zero, zero, lam))) for s in (1, -1, 2, -2)]
        numeric = (8 * (r[0] - r[1]) - (r[2] - r[3])) / (12 * h)
        np.testing.assert_allclose(K[:, place], numeric[: equations.n_u], atol=1e-8 * max(np.abs(K).max(), 1.0))
        np.testing.assert_allclose(J[:, place], numeric[equations.n_u :], atol=1e-8)  # rounding of 1e-16 / 1e-4


@kinds
def test_energy_is_balanced_in_motion(kind):
    result = simulated(HELD[kind](), 0.4, dt=1e-3)
    names = ("energy.kinetic", "energy.strain", "work.loads", "work.supports")
    exchanged = max(np.ptp(result[name].values) for name in names)
    assert exchanged > 0.1
    # second order in dt = 1e-3 s; what rho_inf = 0.9 damps of a plate's fast modes comes on top
    assert np.abs(result["energy.balance"].values).max() < (2e-2 if "hinge" in kind else 2e-3) * exchanged


def test_an_angle_is_driven_by_speed_over_many_turns():
    result = simulated(arm(lambda s, pin, body: lm.AngleDrive("motor", pin, speed=lm.SmoothStep(t_end=0.5, end=20.0))), 1.5)
    assert result["pin.angle"].values[-1] == pytest.approx(
        25.0, abs=1e-8
    )  # 5 rad while it starts, 20 in the second after: 4 turns
    assert result["pin.rate"].values[-1] == pytest.approx(20.0, rel=1e-3)  # axes that turn by 0.04 rad a step: 0.04^2 / 2
    carried = -MASS * G * ARM * np.cos(25.0)
    # the rest of the start's oscillation in the multipliers, which rho_inf = 0.9 damps slowly
    assert result["motor.torque"].values[-1] == pytest.approx(carried, abs=0.02 * MASS * G * ARM)


def test_an_angle_drive_gives_the_torque_of_inertia_and_weight():
    result = simulated(arm(lambda s, pin, body: lm.AngleDrive("motor", pin, angle=RISE)), 0.3, dt=1e-3)
    t = result.at[-1]
    np.testing.assert_allclose(result["pin.angle"].values, [RISE.value(t) for t in result.at], atol=1e-9)
    exact = ABOUT_PIN * RISE.acceleration(t) - MASS * G * ARM * np.cos(RISE.value(t))
    assert result["motor.torque"].values[-1] == pytest.approx(exact, abs=5e-3 * MASS * G * ARM)


@pytest.mark.parametrize("by", ["displacement", "speed"])
def test_a_slide_drive_gives_the_force_of_inertia_and_weight(by):
    result = simulated(slider(lambda s, guide, body: lm.SlideDrive("motor", guide, **{by: RISE})), 0.3, dt=1e-3)
    t = result.at[-1]
    place, acceleration = (RISE.value(t), RISE.acceleration(t)) if by == "displacement" else (None, RISE.rate(t))
    if place is not None:
        assert result["guide.displacement"].values[-1] == pytest.approx(place, abs=1e-10)
    else:
        assert result["guide.speed"].values[-1] == pytest.approx(RISE.value(t), rel=1e-5)
    assert result["motor.force"].values[-1] == pytest.approx(MASS * (acceleration - G), rel=2e-3)


def test_a_position_coupling_keeps_the_ratio_and_reports_its_force():
    result = simulated(sliders(), 0.5)
    first, second = (result[f"centre{k}.position"].values[:, 0] for k in range(2))
    np.testing.assert_allclose(second - 0.5, 2.0 * first, atol=1e-12)
    acceleration = 6.0 / (1.0 + 4.0 * 2.0)
    np.testing.assert_allclose(first, 0.5 * acceleration * result.at**2, atol=1e-9)  # constant: exact up to Newton's tolerance
    # the force on marker i is c_i times it: -1 times it moves the second block of 2 kg
    np.testing.assert_allclose(result["loop.force"].values, -2.0 * 2.0 * acceleration, rtol=1e-6)


def test_an_angle_coupling_shares_the_torque():
    def push(s, joints, bodies):
        return lm.PointForce("push", bodies[0].marker("rim", 0.3, 0.0, 0.0), (0, 5, 0), follower=True)

    result = simulated(pair(lambda s, joints, bodies: lm.AngleCoupling("gear", tuple(joints), (2, -1)), push), 0.5)
    acceleration = 0.3 * 5.0 / (0.2 + 4.0 * 0.3)
    np.testing.assert_allclose(result["pin1.angle"].values, 2.0 * result["pin0.angle"].values, atol=1e-9)
    assert result["pin0.angle"].values[-1] == pytest.approx(0.5 * acceleration * 0.25, rel=1e-4)
    # T times -1 acts against the second angle: it turns 0.3 kg m^2 at twice the acceleration
    assert result["gear.torque"].values[-1] == pytest.approx(0.3 * 2.0 * acceleration, rel=1e-3)


@pytest.mark.parametrize("closed", [False, True])
def test_a_weight_rests_on_a_rope_over_two_pegs(closed):
    """Both spans make the angle theta with the vertical, sin theta = distance / length: T = W / (2 cos theta)."""
    length, distance, height = 3.0, 2.0, 0.5
    sine = distance / length
    cosine = np.sqrt(1.0 - sine**2)
    left = 0.5 * (length - height / cosine)  # the right peg is higher by the height
    hook = (-1.0 + left * sine, 0.0, -left * cosine)
    result = simulated(rope(closed=closed, hook=hook), 0.1)
    np.testing.assert_allclose(result["rope.tension"].values, 0.5 * MASS * G / cosine, rtol=1e-9)
    np.testing.assert_allclose(result["weight.position"].values, np.tile(hook, (len(result.at), 1)), atol=1e-9)
    spans = [np.linalg.norm(np.subtract(hook, peg)) for peg in ((-1.0, 0.0, 0.0), (1.0, 0.0, height))]
    assert sum(spans) == pytest.approx(length)


MESSAGES = {
    "both": (
        lambda: arm(lambda s, p, b: lm.AngleDrive("m", p, RISE, RISE)),
        "AngleDrive 'm': both 'angle' and 'speed' are given",
    ),
    "neither": (lambda: arm(lambda s, p, b: lm.AngleDrive("m", p)), "AngleDrive 'm': neither 'angle' nor 'speed' is given"),
    "both of a slide": (
        lambda: slider(lambda s, p, b: lm.SlideDrive("m", p, RISE, RISE)),
        "SlideDrive 'm': both 'displacement' and 'speed' are given; accepted is one of them",
    ),
    "joint not added": (
        lambda: arm(lambda s, p, b: lm.AngleDrive("m", lm.RevoluteJoint("loose", p.a, p.b), RISE)).compile(),
        "AngleDrive 'm': the joint 'loose' is not in the system",
    ),
    "joint of a coupling not added": (
        lambda: pair(lambda s, j, b: lm.AngleCoupling("m", (j[0], lm.RevoluteJoint("loose", j[1].a, j[1].b)), (1, 1))).compile(),
        "AngleCoupling 'm': the joint 'loose' is not in the system",
    ),
    "zero factor": (lambda: pair(lambda s, j, b: lm.AngleCoupling("m", tuple(j), (1, 0))), "factors = [1.0, 0.0]; accepted are"),
    "one factor": (lambda: pair(lambda s, j, b: lm.AngleCoupling("m", tuple(j), (1, 2, 3))), "2 joints and 3 factors; accepted"),
    "damping of a rigid coupling": (
        lambda: pair(lambda s, j, b: lm.AngleCoupling("m", tuple(j), (1, 2), damping=1.0)),
        "damping = 1 without 'stiffness'; a rigid coupling has no damping",
    ),
    "stiffness of a coupling": (
        lambda: pair(lambda s, j, b: lm.AngleCoupling("m", tuple(j), (1, 2), stiffness=-1.0)),
        "AngleCoupling 'm': stiffness = -1",
    ),
    "zero factor of positions": (
        lambda: lm.PositionCoupling("m", (lm.Ground().origin,) * 2, ("x", "y"), (0, 1)),
        "PositionCoupling 'm': factors = [0.0, 1.0]; accepted are factors other than zero",
    ),
    "counts of positions": (
        lambda: lm.PositionCoupling("m", (lm.Ground().origin,) * 2, ("x",), (1, 1)),
        "2 markers, 1 axes and 2 factors; accepted is one axis and one factor for each marker",
    ),
    "ground cannot move": (
        lambda: arm(lambda s, p, b: lm.PositionCoupling("m", (p.a, p.b), ("x", "x"), (1, 1))).compile(),
        "PositionCoupling 'm': ground.origin cannot move; accepted are markers of bodies",
    ),
    "cable of coinciding points": (
        lambda: arm(lambda s, p, b: lm.Cable("m", (p.a, p.b))).compile(),
        "Cable 'm': ground.origin and arm.heel coincide; accepted are distinct points",
    ),
    "cable that cannot move": (
        lambda: arm(lambda s, p, b: lm.Cable("m", (p.a, lm.Ground().marker("peg", 1, 0, 0)))).compile(),
        "Cable 'm': none of its points can move; accepted is a cable with a point on a body",
    ),
    "cable of one point": (lambda: lm.Cable("m", (lm.Ground().origin,)), "Cable 'm': points"),
    "table of a drive": (
        lambda: arm(lambda s, p, b: lm.AngleDrive("m", p, lm.Table((0.0, 1.0, 0.5), (0.0, 1.0, 2.0)))),
        "times 2 and 3 are 1 and 0.5; accepted are strictly increasing times",
    ),
    "drive of a slide's angle": (lambda: slider(lambda s, p, b: lm.AngleDrive("m", p, RISE)), "AngleDrive 'm': on"),
}


@pytest.mark.parametrize("name", MESSAGES)
def test_impossible_values_are_named(name):
    make, message = MESSAGES[name]
    with pytest.raises(DeclarationError) as error:
        make()
    assert message in str(error.value)
