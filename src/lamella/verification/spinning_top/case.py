"""Heavy symmetrical top: nutation and precession against the equation of its Euler angles."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

import lamella as lm
from lamella.roles import Floats
from lamella.verification import Check, Curves, Evidence, References
from lamella.verification.mechanism import G, solved

slow = False

MASS, ARM, ACROSS, ALONG = 0.8, 0.15, 2e-3, 3e-3  # kg, m, and moments about the centre of mass [kg m^2]
TILT, SPIN = 0.6, 80.0  # rad, rad/s
A = ACROSS + MASS * ARM**2
END = 0.8


def top() -> lm.System:
    """The top on a ball joint, let go with spin about its tilted axis."""
    n = np.array((np.sin(TILT), 0.0, np.cos(TILT)))
    system, ground = lm.System(), lm.Ground()
    given = {"rotation": (0.0, TILT, 0.0), "angular_velocity": tuple(SPIN * n), "position": tuple(ARM * n)}
    body = lm.RigidBody("top", mass=MASS, inertia=(ACROSS, ACROSS, ALONG), **given)
    tip = lm.SphericalJoint("tip", ground.marker("floor", 0, 0, 0), body.marker("foot", 0, 0, -ARM))
    for item in (ground, body, tip, lm.Gravity("weight", (0, 0, -G))):
        system.add(item)
    return system


def expected(times: Floats) -> tuple[Floats, Floats, Floats]:
    """Nutation theta, precession phi and position of the centre of mass, shape (n,), (n,), (n, 3).

    With w_3 the spin about the axis, which is constant (Goldstein, Classical Mechanics, section 5.7):

        A theta'' = A phi'^2 sin theta cos theta - C w_3 phi' sin theta + m g c sin theta
        A phi' sin^2 theta = C w_3 (cos theta_0 - cos theta)
    """

    def precession(theta: float) -> float:
        return ALONG * SPIN * (np.cos(TILT) - np.cos(theta)) / (A * np.sin(theta) ** 2)

    def rates(t: float, y: Floats) -> Floats:
        theta, _, rate = y
        turning = precession(theta)
        torque = A * turning**2 * np.sin(theta) * np.cos(theta) - ALONG * SPIN * turning * np.sin(theta)
        return np.array([rate, turning, (torque + MASS * G * ARM * np.sin(theta)) / A])

    theta, phi, _ = solved(rates, [TILT, 0.0, 0.0], times)
    return theta, phi, ARM * np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=1)


def run() -> Iterator[Evidence]:
    """Yield the checks and pictures of this case."""
    references = References.beside(__file__)
    result = lm.simulate(top(), END, lm.GeneralizedAlpha(dt=5e-4, rho_inf=0.9, newton=lm.Newton(tolerance=1e-10)))
    theta, phi, position = expected(result.at)
    found = result["top.position"].values
    tilt = np.arccos(found[:, 2] / ARM)
    turned = np.unwrap(np.arctan2(found[:, 1], found[:, 0]))
    source, why = "Euler angles of the heavy top", "second order: w_3 dt = 0.04, so (w_3 dt)^2 = 1.6e-3"
    yield Check("largest tilt", tilt.max(), theta.max(), 1e-3, source=source, unit="rad", reason=why)
    yield Check("precession at the end", turned[-1], phi[-1], 3e-3, source=source, unit="rad", reason=why)
    yield references.check("largest error of the centre of mass", np.abs(found - position).max() / ARM)
    yield Curves("Nutation", "Time [s]", "Tilt [rad]", {"lamella": (result.at, tilt)}, {"Euler angles": (result.at, theta)})
    paths = {"lamella": (found[:, 0], found[:, 1])}, {"Euler angles": (position[:, 0], position[:, 1])}
    yield Curves("Path of the centre of mass, seen from above", "x [m]", "y [m]", *paths)
    axis = result["top.rotation"].values.reshape(-1, 3, 3)[:, :, 2]
    spin = np.einsum("ti,ti->t", axis, result["top.angular_velocity"].values)
    yield references.check("change of the spin about its axis", np.abs(spin / SPIN - 1).max())
    yield references.check("change of energy", np.abs(result["energy.balance"].values).max() / (MASS * G * ARM))
