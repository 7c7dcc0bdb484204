"""Slider-crank with a flexible connecting rod: the benchmark of Simeon in the Test Set for IVP Solvers."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Literal

import numpy as np

import lamella as lm
from lamella.model import Model
from lamella.roles import Floats
from lamella.state import State
from lamella.verification import Curves, Evidence, References

slow = True

CRANK, ROD, SIDE = 0.15, 0.30, 0.008  # lengths and side of the rod's square section [m]
E, RHO, SPEED = 2e11, 7870.0, 150.0  # [N/m^2], [kg/m^3], [rad/s]
CRANK_MASS, SLIDER_MASS = 0.36, 0.075552  # [kg]
END = 0.1

STRETCH = (1.03339863e-5, 1.69327969e-5)
"""q3 and q4 at the start: how far the rod's middle and end have moved along it [m]."""
ROD_SPEED, BEND_SPEEDS, STRETCH_SPEEDS = -74.9957670, (0.444896105, 4.63434311e-3), (-1.78591076e-6, -2.68938672e-6)
"""phi2' [rad/s], (q1', q2') and (q3', q4') [m/s] at the start, close to the smooth motion."""


def slider_crank(strain: Literal["floating", "exact"]) -> lm.System:
    """Crank and rod along x, three revolutes about -y and a prismatic joint; angles count from x towards z."""
    steel = lm.Laminate(lm.Isotropic(E=E, nu=0.0, rho=RHO), thickness=SIDE)
    system, ground = lm.System(), lm.Ground()
    crank = lm.RigidBody("crank", mass=CRANK_MASS, inertia=(1e-4, 1e-3, 1e-3), position=(0.5 * CRANK, 0, 0))
    rod = lm.Plate("rod", (ROD, SIDE), (4, 1), steel, strain=strain, position=(CRANK, -0.5 * SIDE, 0))
    slider = lm.RigidBody("slider", mass=SLIDER_MASS, inertia=(1e-4, 1e-4, 1e-4), position=(CRANK + ROD, 0, 0))
    big, *_, small = (rod.marker(f"at {k}", 0.25 * k * ROD, 0.5 * SIDE) for k in range(5))
    pin = lm.RevoluteJoint("pin", ground.origin, crank.marker("hub", -0.5 * CRANK, 0, 0), axis=(0, -1, 0))
    for item in (
        *(ground, crank, rod, slider, pin),
        lm.RevoluteJoint("elbow", crank.marker("tip", 0.5 * CRANK, 0, 0), big, axis=(0, -1, 0)),
        lm.RevoluteJoint("wrist", slider.origin, small, axis=(0, -1, 0)),
        lm.PrismaticJoint("rail", ground.origin, slider.origin, axis=(1, 0, 0)),
        lm.AngleDrive("motor", pin, speed=lm.Constant(SPEED)),
    ):
        system.add(item)
    return system


def start(model: Model) -> State:
    """The benchmark's initial values on the nodes of the rod, the crank and the slider.

    u = 4 s (1 - s) q3 + s (2 s - 1) q4 along the rod and w = sin(pi s) q1 + sin(2 pi s) q2 across it, s = x / L.
    """
    q, v = model.q0.reshape(-1, 3).copy(), model.v0.reshape(-1, 3).copy()
    (mesh,), (crank, slider) = model.plates, model.rigid_bodies
    for node in range(mesh.n_nodes):
        s = (node % (mesh.nx + 1)) / mesh.nx
        shape, slope = (4 * s * (1 - s), s * (2 * s - 1)), ((4 - 8 * s) / ROD, (4 * s - 1) / ROD)
        r, r_x = mesh.vector(node, "r"), mesh.vector(node, "r_x")
        q[r, 0] += np.dot(shape, STRETCH)
        q[r_x, 0] += np.dot(slope, STRETCH)
        across, along = np.pi * s * np.arange(1, 3), np.pi / ROD * np.arange(1, 3)
        rising = CRANK * SPEED + ROD_SPEED * (q[r, 0] - CRANK) + np.dot(np.sin(across), BEND_SPEEDS)
        v[r] = (np.dot(shape, STRETCH_SPEEDS), 0.0, rising)
        v[r_x] = (np.dot(slope, STRETCH_SPEEDS), 0.0, ROD_SPEED * q[r_x, 0] + np.dot(along * np.cos(across), BEND_SPEEDS))
    q[slider.first, 0] += STRETCH[1]
    v[slider.first, 0] = STRETCH_SPEEDS[1]
    v[crank.first, 2] = 0.5 * CRANK * SPEED
    v[crank.first + 1], v[crank.first + 3] = (0, 0, SPEED), (-SPEED, 0, 0)
    rows = sum(block.n_lam for block in model.constraints)
    return State(0.0, q.reshape(-1), v.reshape(-1), np.zeros(model.n_q), np.zeros(rows), np.zeros(0))


def coordinates(places: Sequence[Floats]) -> tuple[float, float, float, float, float]:
    """phi2, q1, q2, q3 and q4 of the rod from five equally spaced points of it.

    The lateral modes follow by the discrete sine transform of the three inner points.
    """
    points = np.array(places)[:, [0, 2]]
    chord = points[4] - points[0]
    along = chord / np.linalg.norm(chord)
    u = (points - points[0]) @ along - 0.25 * ROD * np.arange(5)
    w = (points - points[0]) @ np.array((-along[1], along[0]))
    q1, q2 = (0.5 * np.dot(w[1:4], np.sin(0.25 * np.pi * k * np.arange(1, 4))) for k in (1, 2))
    return float(np.arctan2(along[1], along[0])), q1, q2, u[2], u[4]


QUANTITIES = ("first bending mode q1", "second bending mode q2", "stretch q3", "stretch q4")


def run() -> Iterator[Evidence]:
    """Yield the checks and pictures of this case."""
    references = References.beside(__file__)
    bending = {}
    strains: tuple[Literal["floating", "exact"], ...] = ("floating", "exact")
    for strain in strains:
        model = slider_crank(strain).compile()
        result = lm.simulate(model, END, lm.GeneralizedAlpha(dt=5e-5, rho_inf=0.8), initial=start(model))
        history = np.array(
            [coordinates(places) for places in zip(*(result[f"at {k}.position"].values for k in range(5)), strict=True)]
        )
        bending[f"strain = {strain}"] = (result.at, history[:, 1])
        phi2, *modes = history[-1]
        if strain == "floating":
            yield references.check("angle of the rod phi2", phi2)
            yield references.check("position of the slider x3", result["slider.position"].values[-1, 0])
        for quantity, value in zip(QUANTITIES, modes, strict=True):
            yield references.check(quantity if strain == "floating" else f"{quantity}, exact strains", value)
    ends = {
        "Simeon": ([END], [references.value("first bending mode q1")]),
        "Ritz, w'^2 / 2": ([END], [references.value("first bending mode q1, exact strains")]),
    }
    yield Curves("First bending mode of the rod", "Time [s]", "q1 [m]", bending, ends)
