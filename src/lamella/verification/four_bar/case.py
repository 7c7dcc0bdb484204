"""Planar four-bar of revolute joints in space, redundant three times, against the equation of its crank angle."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

import lamella as lm
from lamella.assembly.equations import Equations
from lamella.roles import Floats
from lamella.verification import Curves, Evidence, References
from lamella.verification.mechanism import G, link, one_degree_of_freedom, solved

slow = False

POINTS = ((0.0, 0.0), (0.1, 0.3), (1.0, 0.6), (0.9, 0.0))  # A, B, C, D in the x-z plane [m]
MASSES = (1.0, 2.0, 3.0)  # crank AB, coupler BC, rocker CD [kg]
END = 1.0


def four_bar() -> lm.System:
    """Three links and four revolutes about y; 18 - 4 x 5 = -2 equations count, but the mechanism moves."""
    system, ground = lm.System(redundant="drop"), lm.Ground()
    names = ("crank", "coupler", "rocker")
    links = [link(name, POINTS[k], POINTS[k + 1], MASSES[k]) for k, name in enumerate(names)]
    left, right = ground.marker("left", 0, 0, 0), ground.marker("right", POINTS[3][0], 0, 0)
    ends = [(left, links[0][1]), (links[0][2], links[1][1]), (links[1][2], links[2][1]), (right, links[2][2])]
    joints = [lm.RevoluteJoint(name, a, b, axis=(0, 1, 0)) for name, (a, b) in zip("ABCD", ends, strict=True)]
    for item in (ground, *(body for body, _, _ in links), *joints, lm.Gravity("weight", (0, 0, -G))):
        system.add(item)
    return system


def expected(times: Floats) -> tuple[Floats, Floats]:
    """Angles (crank, coupler, rocker seen from D) and centre (x, z) of the coupler, shape (3, n) and (n, 2)."""
    spans = [np.subtract(POINTS[1], POINTS[0]), np.subtract(POINTS[2], POINTS[1]), np.subtract(POINTS[2], POINTS[3])]
    lengths = [float(np.hypot(*span)) for span in spans]
    start = [float(np.arctan2(span[1], span[0])) for span in spans]
    (l_1, l_2, l_3), (m_1, m_2, m_3) = lengths, MASSES

    def along(angles: Floats) -> Floats:
        a, b, c = angles
        return np.array([1.0, l_1 * np.sin(c - a) / (l_2 * np.sin(b - c)), l_1 * np.sin(b - a) / (l_3 * np.sin(b - c))])

    def inertia(angles: Floats) -> float:
        _, h_2, h_3 = along(angles)
        (sin, sin_2, _), (cos, cos_2, _) = np.sin(angles), np.cos(angles)
        x, z = l_1 * sin + 0.5 * l_2 * sin_2 * h_2, l_1 * cos + 0.5 * l_2 * cos_2 * h_2
        return m_1 * l_1**2 / 3 + m_2 * (x**2 + z**2 + l_2**2 * h_2**2 / 12) + m_3 * l_3**2 * h_3**2 / 3

    def force(angles: Floats) -> float:
        _, h_2, h_3 = along(angles)
        cos, cos_2, cos_3 = np.cos(angles)
        coupler, rocker = l_1 * cos + 0.5 * l_2 * cos_2 * h_2, 0.5 * l_3 * cos_3 * h_3
        return -G * (0.5 * m_1 * l_1 * cos + m_2 * coupler + m_3 * rocker)

    angles = solved(one_degree_of_freedom(inertia, along, force), [*start, 0.0], times)[:3]
    return angles, (l_1 * _direction(angles[0]) + 0.5 * l_2 * _direction(angles[1])).T


def _direction(angle: Floats) -> Floats:
    return np.stack([np.cos(angle), np.sin(angle)])


def run() -> Iterator[Evidence]:
    """Yield the checks and pictures of this case."""
    references = References.beside(__file__)
    system = four_bar()
    equations = Equations(system.compile())
    yield references.check("degrees of freedom", equations.mobility)
    yield references.check("equations left out", sum(note.count("follows from") for note in equations.notes))
    integrator = lm.GeneralizedAlpha(dt=2e-3, rho_inf=0.9, newton=lm.Newton(tolerance=1e-10))
    result = lm.simulate(system, END, integrator)
    angles, centre = expected(result.at)
    found = result["coupler.position"].values
    yield references.check("crank angle", np.abs(result["A.angle"].values + angles[0] - angles[0, 0]).max())
    yield references.check("rocker angle", np.abs(result["D.angle"].values + angles[2] - angles[2, 0]).max())
    computed, exact = {}, {}
    for name, joint, angle in (("crank", "A", angles[0]), ("rocker", "D", angles[2])):
        computed[name] = (result.at, angle[0] - result[f"{joint}.angle"].values)
        exact[f"{name}, equation"] = (result.at, angle)
    yield Curves("Angles of crank and rocker", "Time [s]", "Angle [rad]", computed, exact)
    yield references.check("centre of the coupler", np.abs(found[:, [0, 2]] - centre).max())
    yield references.check("motion out of the plane", np.abs(found[:, 1]).max())
    yield references.check("turned by the crank", float(np.ptp(angles[0])))
