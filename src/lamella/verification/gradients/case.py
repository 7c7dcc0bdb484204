"""Gradients against closed forms: what they are of is known, so that nothing is compared with differences."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

import lamella as lm
from lamella.verification import Evidence, References

slow = False

LENGTH, WIDTH, THICKNESS, E, RHO, FORCE = 0.5, 0.1, 5e-3, 7e10, 2700.0, 1e-3  # m, m, m, Pa, kg/m^3, N
MASS, STIFFNESS, SPEED, END = 2.0, 50.0, 1.0, 0.3  # kg, N/m, m/s, s


def strip(thickness: float, E: float, force: float, rho: float) -> lm.System:
    """A cantilever strip without lateral contraction, which is a beam."""
    system = lm.System()
    layup = lm.Laminate(lm.Isotropic(E, 0.0, rho), thickness=thickness)
    plate = system.add(lm.Plate("strip", (LENGTH, WIDTH), (4, 1), layup))
    tip = plate.marker("tip", LENGTH, 0.5 * WIDTH)
    system.add(lm.Clamp("root", plate.edge("x-")))
    system.add(lm.PointForce("load", tip, (0.0, 0.0, force)))
    return system


def oscillator(mass: float, stiffness: float) -> lm.System:
    """A rigid body on a rail with a spring, set off with a speed."""
    system = lm.System()
    ground = system.add(lm.Ground())
    body = system.add(lm.RigidBody("body", mass=mass, inertia=(1.0, 1.0, 1.0), velocity=(SPEED, 0.0, 0.0)))
    rail = system.add(lm.PrismaticJoint("rail", ground.origin, body.origin, axis=(1, 0, 0)))
    system.add(lm.SlideSpring("spring", rail, stiffness=stiffness))
    return system


def run() -> Iterator[Evidence]:
    """Yield the checks of this case."""
    references = References.beside(__file__)
    at = {"thickness": THICKNESS, "E": E, "force": FORCE, "rho": RHO}
    outputs = {"tip": lm.SignalOutput("tip.position", component="z"), "frequency": lm.ShapeOutput(1), "mass": lm.MassOutput()}
    found = lm.gradient(strip, at, outputs, analyses=(lm.Statics("still"), lm.NaturalModes("modes", count=1)))
    for output, powers in {
        "tip": {"thickness": -3.0, "E": -1.0, "force": 1.0},
        "frequency": {"thickness": 1.0, "E": 0.5, "rho": -0.5},
        "mass": {"thickness": 1.0, "rho": 1.0},
    }.items():
        for parameter in powers:
            power = found[output, parameter] * at[parameter] / found.values[output]
            yield references.check(f"power of {parameter} in {output}", float(power))
    for dt in (2e-3, 1e-3):
        at = {"mass": MASS, "stiffness": STIFFNESS}
        motion = lm.Motion("swing", END, lm.GeneralizedAlpha(dt, rho_inf=1.0, newton=lm.Newton(tolerance=1e-10)))
        swing = lm.gradient(oscillator, at, {"x": lm.SignalOutput("body.position", component="x")}, analyses=(motion,))
        omega = np.sqrt(STIFFNESS / MASS)
        x, slope = (
            SPEED / omega * np.sin(omega * END),
            SPEED * (END * np.cos(omega * END) / omega - np.sin(omega * END) / omega**2),
        )
        for parameter, rate in (("mass", -0.5 * omega / MASS), ("stiffness", 0.5 * omega / STIFFNESS)):
            error = abs(swing["x", parameter] / (slope * rate) - 1.0)
            yield references.check(f"oscillator, derivative by {parameter}, dt = {1e3 * dt:g} ms", float(error))
        yield references.check(f"oscillator, position, dt = {1e3 * dt:g} ms", abs(swing.values["x"] / x - 1.0))
