"""A force that turns with its body: thrust on spinning bodies against closed forms, and a plate under a follower force."""

from __future__ import annotations

import numpy as np

import lamella as lm

MASS, INERTIA, THRUST, SPIN = 3.0, 0.4, 6.0, 5.0


def test_thrust_of_a_spinning_body_goes_round():
    system = lm.System()
    body = system.add(lm.RigidBody("body", mass=MASS, inertia=(0.3, 0.3, INERTIA), angular_velocity=(0.0, 0.0, SPIN)))
    centre = body.marker("centre", 0.0, 0.0, 0.0)
    system.add(lm.PointForce("thrust", centre, (THRUST, 0.0, 0.0), follower=True))
    result = lm.simulate(system, 1.0, lm.GeneralizedAlpha(dt=1e-3))
    angle, scale = SPIN * result.at, THRUST / (MASS * SPIN**2)
    exact = scale * np.stack([1.0 - np.cos(angle), angle - np.sin(angle), 0.0 * angle], axis=1)
    # the spin lags by (SPIN dt)^2 / 12 = 2e-6 of the angle in each of 5 rad, and the path by as much
    np.testing.assert_allclose(result["centre.position"].values, exact, atol=5e-5 * scale)


def test_thrust_beside_the_centre_turns_a_tilted_body_evenly():
    """About the body's own axis the torque is constant, wherever that axis points."""
    system = lm.System()
    tilt = (0.0, np.pi / 2, 0.0)  # the body's z axis along x
    body = system.add(lm.RigidBody("body", mass=MASS, inertia=(0.3, 0.3, INERTIA), rotation=tilt))
    side = body.marker("side", 0.0, 0.25, 0.0)
    # inertial axes at the start: the thrust along -z acts 0.25 m along y, a torque of -0.25 THRUST about x
    system.add(lm.PointForce("thrust", side, (0.0, 0.0, -THRUST), follower=True))
    result = lm.simulate(system, 1.0, lm.GeneralizedAlpha(dt=1e-3))
    angle = 0.5 * -0.25 * THRUST / INERTIA * result.at**2
    R = result.model.rigid_bodies[0].rotation(result.final.q)
    np.testing.assert_allclose(R[:, 1], [0.0, np.cos(angle[-1]), np.sin(angle[-1])], atol=2e-5)


def test_a_strip_under_an_end_follower_bends_further_than_under_a_dead_force():
    """The tip's normal turns, and the follower force keeps its lever; reaction and force are in balance."""
    sheet = lm.Laminate(lm.Isotropic(E=70e9, nu=0.0, rho=2700.0), thickness=0.01)
    rotations = {}
    for follower in (False, True):
        system = lm.System()
        strip = system.add(lm.Plate("strip", (1.0, 0.1), (4, 1), sheet))
        tip = strip.marker("tip", 1.0, 0.05)
        system.add(lm.Clamp("root", strip.edge("x-")))
        system.add(lm.PointForce("end", tip, (0.0, 0.0, 1500.0), follower=follower))
        result = lm.equilibrium(system, steps=4)
        mesh = result.model.plates[0]
        tangent = mesh.locate((1.0, 0.05)).tangents[0].at(result.final.q.reshape(-1, 3))
        rotations[follower] = np.arctan2(tangent[2], tangent[0])
        normal = np.array([-np.sin(rotations[follower]), 0.0, np.cos(rotations[follower])])
        wanted = 1500.0 * (normal if follower else np.array([0.0, 0.0, 1.0]))
        np.testing.assert_allclose(-result["root.force"].values, wanted, atol=1e-4 * 1500.0)  # Newton's tolerance
    # elastica: moment EI kappa with EI = 583 N m^2, load 1500 L^2 / EI = 2.57
    assert 0.8 < rotations[False] < rotations[True] < 1.6
