"""Rigid bodies: mass matrix, momentum, signals, loads on markers, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest

import lamella as lm
from lamella.assembly.equations import Equations
from lamella.errors import DeclarationError
from lamella.math.rotation import matrix_from_quaternion, matrix_from_vector
from lamella.solve.initial import make_consistent
from lamella.solve.linear import linear_solver

TIGHT = lm.Newton(tolerance=1e-11)
SIZE, RHO, CENTRE = np.array((0.3, 0.5, 0.8)), 700.0, np.array((0.2, -0.1, 0.35))


def alone(body, *others):
    system = lm.System()
    for item in (body, *others):
        system.add(item)
    return system


def box(**changes):
    given = {"shape": lm.Box(tuple(SIZE)), "density": RHO, "centre_of_mass": tuple(CENTRE)}
    return lm.RigidBody("box", **(given | changes))


def gauss_points():
    """Points and masses of a box: two Gauss points in each direction are exact for second moments."""
    x = np.array([(i, j, k) for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)]) / np.sqrt(3)
    return CENTRE + 0.5 * SIZE * x, np.full(8, RHO * SIZE.prod() / 8)


def test_mass_matrix_of_a_box_about_an_offset_origin():
    model = alone(box(rotation=(0.3, -0.8, 1.1))).compile()
    points, masses = gauss_points()
    X = np.hstack([np.ones((8, 1)), points])
    expected = np.kron(X.T @ (masses[:, None] * X), np.eye(3))
    np.testing.assert_allclose(model.mass.toarray(), expected, rtol=1e-12, atol=1e-12 * expected.max())


def test_products_of_inertia_have_the_sign_of_the_inertia_matrix():
    """Eight point masses, turned from their principal axes: I = sum m (x.x 1 - x x^T)."""
    points, masses = gauss_points()
    x = (points - CENTRE) @ matrix_from_vector(np.array((0.4, 0.9, -0.3))).T
    inertia = sum(m * (p @ p * np.eye(3) - np.outer(p, p)) for m, p in zip(masses, x, strict=True))
    products = (inertia[0, 1], inertia[0, 2], inertia[1, 2])
    body = lm.RigidBody("body", mass=masses.sum(), inertia=tuple(np.diag(inertia)), products=products)
    M = alone(body).compile().mass.toarray()[3::3, 3::3]
    np.testing.assert_allclose(M, x.T @ (masses[:, None] * x), rtol=1e-12, atol=1e-12)


def test_momentum_and_energy_are_those_of_point_masses():
    spin, velocity = np.array((1.0, -2.0, 0.5)), np.array((0.3, 0.1, -0.4))
    turn = (0.3, -0.8, 1.1)
    body = box(rotation=turn, velocity=tuple(velocity), angular_velocity=tuple(spin), position=(1.0, 2.0, 3.0))
    model = alone(body).compile()
    points, masses = gauss_points()
    x = (1.0, 2.0, 3.0) + points @ matrix_from_vector(np.array(turn)).T
    v = velocity + np.cross(spin, x - (1.0, 2.0, 3.0))
    p = (model.mass @ model.v0).reshape(-1, 3)
    np.testing.assert_allclose(p[0], masses @ v, rtol=1e-12)
    np.testing.assert_allclose(np.cross(model.q0.reshape(-1, 3), p).sum(axis=0), masses @ np.cross(x, v), rtol=1e-12)
    assert 0.5 * model.v0 @ model.mass @ model.v0 == pytest.approx(0.5 * masses @ (v**2).sum(axis=1))


def test_signals_of_a_known_spin():
    """A sphere turns about a fixed axis at a constant rate; yaw, pitch and roll, quaternion and matrix say the same."""
    spin, turn = np.array((0.6, -1.5, 2.0)), (0.2, 0.4, -0.3)
    sphere = {"mass": 2.0, "shape": lm.Sphere(0.3), "velocity": (0.1, 0.2, 0.3)}
    body = lm.RigidBody("ball", **sphere, rotation=turn, angular_velocity=tuple(spin))
    body.marker("point", 0.1, 0.2, -0.2)
    result = lm.simulate(alone(body), 0.5, lm.GeneralizedAlpha(dt=1e-3, newton=TIGHT))
    R = matrix_from_vector(0.5 * spin) @ matrix_from_vector(np.array(turn))
    # second order: phase error (omega dt)^2 / 12 of an angle of 1.3 rad is 7e-7
    np.testing.assert_allclose(result["ball.rotation"].values[-1].reshape(3, 3), R, atol=3e-6)
    np.testing.assert_allclose(matrix_from_quaternion(result["ball.quaternion"].values[-1]), R, atol=3e-6)
    yaw, pitch, roll = result["ball.euler"].values[-1]
    turned = [matrix_from_vector(np.array(v)) for v in ((0, 0, yaw), (0, pitch, 0), (roll, 0, 0))]
    np.testing.assert_allclose(turned[0] @ turned[1] @ turned[2], R, atol=3e-6)
    np.testing.assert_allclose(result["ball.angular_velocity"].values, np.tile(spin, (501, 1)), atol=1e-5)
    np.testing.assert_allclose(result["ball.position"].values[-1], 0.5 * np.array((0.1, 0.2, 0.3)), atol=1e-12)
    point = 0.5 * np.array((0.1, 0.2, 0.3)) + R @ (0.1, 0.2, -0.2)
    np.testing.assert_allclose(result["point.position"].values[-1], point, atol=3e-6)
    velocity = np.array((0.1, 0.2, 0.3)) + np.cross(spin, R @ (0.1, 0.2, -0.2))
    np.testing.assert_allclose(result["point.velocity"].values[-1], velocity, atol=1e-5)


def test_weight_acts_at_the_centre_of_mass():
    system = alone(body := box(rotation=(0.3, -0.8, 1.1)), lm.Gravity("weight", (1.0, -2.0, -9.0)))
    result = lm.simulate(system, 0.1, lm.GeneralizedAlpha(dt=1e-2, newton=TIGHT))
    fallen = 0.5 * 0.1**2 * np.array((1.0, -2.0, -9.0))
    np.testing.assert_allclose(result["box.position"].values[-1] - body.position, fallen, atol=1e-12)
    np.testing.assert_allclose(result["box.angular_velocity"].values, 0.0, atol=1e-12)


def accelerations(load, **changes):
    """Acceleration of the centre of mass and angular acceleration at the start of a box at rest under one load."""
    equations = Equations(alone(box(**changes), load).compile())
    point = equations.start()
    make_consistent(equations, point, linear_solver(equations.matrix.pattern))
    state = equations.state(point)
    a, x = state.a.reshape(-1, 3), state.q.reshape(-1, 3)
    return a[0] + CENTRE @ a[1:], 0.5 * np.cross(x[1:], a[1:]).sum(axis=0)


def inertia_in_space(turn):
    R = matrix_from_vector(np.array(turn))
    points, masses = gauss_points()
    x = (points - CENTRE) @ R.T
    return masses.sum(), R @ CENTRE, sum(m * (p @ p * np.eye(3) - np.outer(p, p)) for m, p in zip(masses, x, strict=True))


def test_force_on_a_marker_obeys_newton_and_euler():
    turn, force = (0.3, -0.8, 1.1), np.array((30.0, -20.0, 50.0))
    body = box(rotation=turn)
    a, alpha = accelerations(lm.PointForce("load", body.marker("tip", 0.5, 0.1, -0.4), tuple(force)), rotation=turn)
    mass, centre, inertia = inertia_in_space(turn)
    arm = matrix_from_vector(np.array(turn)) @ (0.5, 0.1, -0.4) - centre
    np.testing.assert_allclose(a, force / mass, rtol=1e-8)
    np.testing.assert_allclose(inertia @ alpha, np.cross(arm, force), rtol=1e-8)


@pytest.mark.parametrize("follower", [False, True])
def test_moment_on_a_marker_obeys_euler(follower):
    turn, moment = (0.3, -0.8, 1.1), np.array((3.0, -2.0, 5.0))
    body = box(rotation=turn)
    load = lm.PointMoment("load", body.marker("tip", 0.5, 0.1, -0.4), tuple(moment), follower=follower)
    a, alpha = accelerations(load, rotation=turn)
    _, _, inertia = inertia_in_space(turn)
    in_space = matrix_from_vector(np.array(turn)) @ moment if follower else moment
    np.testing.assert_allclose(a, 0.0, atol=1e-8)
    np.testing.assert_allclose(inertia @ alpha, in_space, rtol=1e-8)


def test_following_moment_keeps_turning_a_body_about_its_axis():
    """About a principal axis fixed in the body: angle = m t^2 / (2 I), however far it has turned."""
    body = lm.RigidBody("rotor", mass=1.0, inertia=(0.2, 0.3, 0.4), rotation=(0.7, 0.2, -0.5))
    load = lm.PointMoment("motor", body.origin, (0.0, 6.0, 0.0), follower=True)
    result = lm.simulate(alone(body, load), 1.0, lm.GeneralizedAlpha(dt=2e-3, newton=TIGHT))
    R = matrix_from_vector(np.array((0.7, 0.2, -0.5)))
    # 20 rad/s^2; after a second omega dt = 0.04 and (omega dt)^2 / 12 of 10 rad is 1.3e-3
    np.testing.assert_allclose(result["rotor.angular_velocity"].values[-1], R @ (0, 20.0, 0), atol=0.03)
    np.testing.assert_allclose(result["rotor.rotation"].values[-1].reshape(3, 3)[:, 1], R[:, 1], atol=1e-9)
    angle = np.arccos(0.5 * (np.trace(result["rotor.rotation"].values[-1].reshape(3, 3) @ R.T) - 1))
    assert angle == pytest.approx(4 * np.pi - 10.0, abs=4e-3)


def test_density_and_mass_give_the_same_body():
    given = box()
    other = box(density=None, mass=given.total_mass)
    np.testing.assert_allclose(alone(given).compile().mass.toarray(), alone(other).compile().mass.toarray())


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"density": None}, r"RigidBody 'box': its mass is not known; accepted is 'mass', or 'density'"),
        ({"density": None, "mass": 0.0}, r"RigidBody 'box'.*mass.*greater than 0"),
        ({"density": None, "mass": -1.0}, r"RigidBody 'box'.*mass.*greater than 0"),
        ({"mass": 3.0}, r"RigidBody 'box': both 'mass' and 'density' are given"),
        ({"density": None, "mass": 2.0, "shape": None}, r"RigidBody 'box': its inertia is not known; accepted is 'inertia'"),
        ({"shape": None}, r"RigidBody 'box': its mass is not known"),
        ({"inertia": (1.0, 1.0, 3.0)}, r"principal moments of inertia 1, 1, 3 kg m\^2 belong to no body"),
        ({"inertia": (1.0, 1.0, 1.0), "products": (2.0, 0.0, 0.0)}, r"belong to no body"),
        ({"inertia": (1.0, 0.0, 1.0)}, r"RigidBody 'box'.*inertia.*greater than 0"),
    ],
)
def test_impossible_bodies_are_refused_with_a_message(changes, message):
    with pytest.raises(DeclarationError, match=message):
        box(**changes)


def test_a_marker_has_one_place():
    body = box()
    body.marker("tip", 1.0, 0.0, 0.0)
    with pytest.raises(DeclarationError, match=r"RigidBody 'box': marker 'tip' is already at \(1\.0, 0\.0, 0\.0\)"):
        body.marker("tip", 2.0, 0.0, 0.0)


def test_thin_rod_and_point_mass_on_an_axis_are_bodies():
    """A rod has no second moment across its axis: the mass matrix is semi-definite, and it moves all the same."""
    rod = lm.RigidBody("rod", mass=3.0, inertia=(1e-12, 1.0, 1.0), position=(1.0, 0.0, 0.0))
    ground = lm.Ground()
    pin = lm.RevoluteJoint("pin", ground.marker("o", 0, 0, 0), rod.marker("end", -1.0, 0, 0), axis=(0, 1, 0))
    system = alone(rod, ground, pin, lm.Gravity("g"))
    result = lm.simulate(system, 0.01, lm.GeneralizedAlpha(dt=1e-3, newton=TIGHT))
    rate = 3.0 * 9.81 * 1.0 / (1.0 + 3.0) * 0.01  # of the angle from the horizontal, about +y; it changes by 1e-6 of itself
    assert result["pin.rate"].values[-1] == pytest.approx(rate, rel=1e-5)
