"""Physical, double and spherical pendulum against their equations in minimal coordinates."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

import lamella as lm
from lamella.math.rotation import matrix_from_vector
from lamella.roles import Floats
from lamella.verification import Curves, Evidence, References
from lamella.verification.mechanism import G, link, solved

slow = False

INTEGRATOR = lm.GeneralizedAlpha(dt=2e-3, rho_inf=0.9, newton=lm.Newton(tolerance=1e-10))
END = 1.0


def physical() -> tuple[Floats, Floats, Floats]:
    """Times, and angles computed and expected (n, 1) of an unsymmetric body that turns about a skew axis off its centre."""
    axis, tilt, arm = np.array((0.8, 0.6, 0.0)), 1.2, 0.4
    turn = matrix_from_vector(tilt * axis)
    inertia = {"mass": 2.5, "inertia": (0.10, 0.14, 0.17), "products": (0.01, -0.02, 0.015)}
    system, ground = lm.System(), lm.Ground()
    body = lm.RigidBody("body", **inertia, position=tuple(turn @ (0.0, 0.0, -arm)), rotation=tuple(tilt * axis))
    pin = lm.RevoluteJoint("pin", ground.marker("hook", 0, 0, 0), body.marker("hole", 0, 0, arm), axis=tuple(axis))
    for item in (ground, body, pin, lm.Gravity("weight", (0, 0, -G))):
        system.add(item)
    result = lm.simulate(system, END, INTEGRATOR)
    about_axis = axis @ body.inertia_matrix() @ axis + 2.5 * arm**2  # the turn is about the axis itself
    found = solved(lambda t, y: np.array([y[1], -2.5 * G * arm * np.sin(y[0]) / about_axis]), [tilt, 0.0], result.at)
    return result.at, result["pin.angle"].values[:, None] + tilt, found[:1].T


def double() -> tuple[Floats, Floats, Floats]:
    """Times, and positions (x, z) computed and expected of the end of two links that hang on each other."""
    (l_1, m_1), (l_2, m_2), start = (0.5, 1.0), (0.7, 1.5), np.array((1.1, 2.0))
    elbow = l_1 * np.array((np.sin(start[0]), -np.cos(start[0])))
    tip = elbow + l_2 * np.array((np.sin(start[1]), -np.cos(start[1])))
    (upper, a, b), (lower, c, _) = link("upper", (0, 0), tuple(elbow), m_1), link("lower", tuple(elbow), tuple(tip), m_2)
    system, ground = lm.System(), lm.Ground()
    shoulder = lm.RevoluteJoint("shoulder", ground.marker("hook", 0, 0, 0), a, axis=(0, 1, 0))
    for item in (
        ground,
        upper,
        lower,
        shoulder,
        lm.RevoluteJoint("elbow", b, c, axis=(0, 1, 0)),
        lm.Gravity("weight", (0, 0, -G)),
    ):
        system.add(item)
    result = lm.simulate(system, END, INTEGRATOR)

    def rates(t: float, y: Floats) -> Floats:
        difference = y[0] - y[1]
        cross = 0.5 * m_2 * l_1 * l_2
        M = np.array([[(m_1 / 3 + m_2) * l_1**2, cross * np.cos(difference)], [cross * np.cos(difference), m_2 * l_2**2 / 3]])
        force = -cross * np.sin(difference) * np.array([y[3] ** 2, -(y[2] ** 2)])
        force -= G * np.array([(0.5 * m_1 + m_2) * l_1 * np.sin(y[0]), 0.5 * m_2 * l_2 * np.sin(y[1])])
        return np.append(y[2:], np.linalg.solve(M, force))

    angles = solved(rates, [*start, 0.0, 0.0], result.at)
    expected = np.stack([l_1 * np.sin(angles[0]) + l_2 * np.sin(angles[1]), -l_1 * np.cos(angles[0]) - l_2 * np.cos(angles[1])])
    return result.at, result["lower end.position"].values[:, [0, 2]], expected.T


def spherical() -> tuple[Floats, Floats, Floats]:
    """Times, and positions computed and expected of the centre of a symmetric body on a ball joint, thrown sideways.

    With the unit vector n from the joint to the centre of mass and no spin about n:

        A n'' = -A (n'.n') n + m c (g - (g.n) n)
    """
    mass, arm, across = 1.5, 0.6, 0.02
    n, rate = np.array((np.sin(1.0), 0.0, -np.cos(1.0))), np.array((0.0, 1.7, 0.0))
    system, ground = lm.System(), lm.Ground()
    given = {"rotation": (0.0, -1.0, 0.0), "velocity": tuple(arm * rate), "angular_velocity": tuple(np.cross(n, rate))}
    body = lm.RigidBody("bob", mass=mass, inertia=(across, across, 0.01), position=tuple(arm * n), **given)
    ball = lm.SphericalJoint("ball", ground.marker("hook", 0, 0, 0), body.marker("socket", 0, 0, arm))
    for item in (ground, body, ball, lm.Gravity("weight", (0, 0, -G))):
        system.add(item)
    result = lm.simulate(system, END, INTEGRATOR)
    weight, A = np.array((0.0, 0.0, -mass * arm * G)), across + mass * arm**2

    def rates(t: float, y: Floats) -> Floats:
        n, rate = y[:3], y[3:]
        return np.append(rate, -(rate @ rate) * n + (weight - (weight @ n) * n) / A)

    return result.at, result["bob.position"].values, arm * solved(rates, [*n, *rate], result.at)[:3].T


def run() -> Iterator[Evidence]:
    """Yield the checks and pictures of this case."""
    references = References.beside(__file__)
    for name, make, parts, label in (
        ("angle of the physical pendulum", physical, ("angle",), "Angle [rad]"),
        ("end of the double pendulum", double, ("x", "z"), "Position [m]"),
        ("centre of the spherical pendulum", spherical, ("x", "y", "z"), "Position [m]"),
    ):
        t, found, expected = make()
        yield references.check(f"largest error of the {name}", np.abs(found - expected).max())
        computed = {part: (t, values) for part, values in zip(parts, found.T, strict=True)}
        exact = {f"{part}, equation": (t, values) for part, values in zip(parts, expected.T, strict=True)}
        yield Curves(name.capitalize(), "Time [s]", label, computed, exact)
