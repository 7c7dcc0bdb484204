"""Slider-crank under its weight and driven by a moment, against the equation of its crank angle."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

import lamella as lm
from lamella.roles import Floats
from lamella.verification import Curves, Evidence, References
from lamella.verification.mechanism import G, link, one_degree_of_freedom, solved

slow = True

CRANK, ROD = 0.2, 0.55  # lengths [m]
MASSES = (1.2, 0.9, 1.5)  # crank, rod, slider [kg]
START = 0.9  # crank angle from x towards z [rad]
END = 0.6


def rod_angle(crank: float) -> float:
    """Angle of the rod, whose end lies on the x axis."""
    return -float(np.arcsin(CRANK * np.sin(crank) / ROD))


def slider_crank(moment: float) -> lm.System:
    """Revolute, spherical, universal and prismatic joint: 18 - 5 - 3 - 4 - 5 = 1 degree of freedom, none redundant."""
    elbow = CRANK * np.array((np.cos(START), np.sin(START)))
    end = (elbow[0] + ROD * np.cos(rod_angle(START)), 0.0)
    (crank, a, b), (rod, c, d) = link("crank", (0, 0), tuple(elbow), MASSES[0]), link("rod", tuple(elbow), end, MASSES[1])
    slider = lm.RigidBody("slider", mass=MASSES[2], inertia=(1e-3, 1e-3, 1e-3), position=(end[0], 0.0, 0.0))
    system, ground = lm.System(), lm.Ground()
    hook = ground.marker("hook", 0, 0, 0)
    for item in (
        *(ground, crank, rod, slider, lm.RevoluteJoint("pin", hook, a, axis=(0, 1, 0)), lm.SphericalJoint("elbow", b, c)),
        lm.UniversalJoint("wrist", d, slider.origin, axis_a=(0, 1, 0), axis_b=(0, 0, 1)),
        lm.PrismaticJoint("rail", hook, slider.origin, axis=(1, 0, 0)),
        lm.Gravity("weight", (0, 0, -G)),
    ):
        system.add(item)
    if moment:
        system.add(lm.PointMoment("motor", crank.origin, (0.0, -moment, 0.0)))
    return system


def expected(moment: float, times: Floats) -> Floats:
    """Crank angle, rod angle and crank speed, shape (3, n)."""
    m_1, m_2, m_3 = MASSES

    def along(angles: Floats) -> Floats:
        return np.array([1.0, -CRANK * np.cos(angles[0]) / (ROD * np.cos(angles[1]))])

    def inertia(angles: Floats) -> float:
        (sin, rod_sin), (cos, rod_cos), h = np.sin(angles), np.cos(angles), along(angles)[1]
        x, z = -CRANK * sin - 0.5 * ROD * rod_sin * h, CRANK * cos + 0.5 * ROD * rod_cos * h
        slides = -CRANK * sin - ROD * rod_sin * h
        return m_1 * CRANK**2 / 3 + m_2 * (x**2 + z**2 + ROD**2 * h**2 / 12) + m_3 * slides**2

    def force(angles: Floats) -> float:
        rises = CRANK * np.cos(angles[0]) + 0.5 * ROD * np.cos(angles[1]) * along(angles)[1]
        return moment - G * (0.5 * m_1 * CRANK * np.cos(angles[0]) + m_2 * rises)

    return solved(one_degree_of_freedom(inertia, along, force), [START, rod_angle(START), 0.0], times)


def run() -> Iterator[Evidence]:
    """Yield the checks and pictures of this case."""
    references = References.beside(__file__)
    computed, exact = {}, {}
    for name, moment in (("under its weight", 0.0), ("driven", 2.0)):
        integrator = lm.GeneralizedAlpha(dt=1e-3, rho_inf=0.9, newton=lm.Newton(tolerance=1e-10))
        result = lm.simulate(slider_crank(moment), END, integrator)
        crank, rod, _ = expected(moment, result.at)
        place = CRANK * np.cos(crank) + ROD * np.cos(rod)
        yield references.check(f"crank angle, {name}", np.abs(START - result["pin.angle"].values - crank).max())
        yield references.check(f"place of the slider, {name}", np.abs(result["slider.position"].values[:, 0] - place).max())
        yield references.check(f"turned, {name}", float(np.ptp(crank)))
        computed[name] = (result.at, START - result["pin.angle"].values)
        exact[f"{name}, equation"] = (result.at, crank)
    yield Curves("Crank angle", "Time [s]", "Angle [rad]", computed, exact)
