"""Observed order of the integrator against an exact solution, and with a constraint of index 3."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

import lamella as lm
from lamella.state import State
from lamella.verification import Evidence, Orders, References
from lamella.verification.distance_joint.case import HEIGHT, RHO, ROD, THICKNESS, WIDTH, G

slow = False

TIGHT = lm.Newton(tolerance=1e-12)
PER_SWING = (40, 80, 160)
"""Steps in 0.8 of a period."""


def linear_errors(rho: float) -> np.ndarray:
    """Errors of position and velocity of a linear plate that swings in its first mode, for three steps."""
    layup = lm.Laminate(lm.Isotropic(E=2e9, nu=0.3, rho=1200.0), thickness=0.02)
    system = lm.System()
    plate = system.add(lm.Plate("plate", (1.0, 0.3), (2, 1), layup, strain="linear"))
    system.add(lm.Clamp("root", plate.edge("x-")))
    modes = lm.modes(system, 1)
    omega, shape = 2 * np.pi * modes.frequencies[0], modes.displaced(0, 0.01) - modes.state
    start = State(0.0, modes.state + shape, 0.0 * shape, 0.0 * shape, np.zeros(0), np.zeros(0))
    end, errors = 0.8 * 2 * np.pi / omega, []
    for n in PER_SWING:
        options = lm.GeneralizedAlpha(dt=end / n, rho_inf=rho, newton=TIGHT)
        final = lm.simulate(system, end, options, initial=start).final
        of_q = np.abs(final.q - modes.state - shape * np.cos(omega * end)).max()
        of_v = np.abs(final.v + shape * omega * np.sin(omega * end)).max() / omega
        errors.append(np.hypot(of_q, of_v))
    return np.array(errors)


def swinging() -> lm.System:
    """A plate on a rod far from its plumb line, with a weight that sets in smoothly."""
    layup = lm.Laminate(lm.Isotropic(E=70e9, nu=0.3, rho=RHO), thickness=THICKNESS)
    rod, tilt = 0.5, 0.9
    hook = ROD * np.array([0.0, np.sin(rod), -np.cos(rod)])
    corner = hook + HEIGHT * np.array([0.0, np.sin(tilt), -np.cos(tilt)]) - np.array([0.5 * WIDTH, 0.0, 0.0])
    system, ground = lm.System(), lm.Ground()
    system.add(ground)
    given = {"position": tuple(corner), "rotation": (0.5 * np.pi + tilt, 0.0, 0.0)}
    body = system.add(lm.Plate("plate", (WIDTH, HEIGHT), (1, 1), layup, **given))
    body.marker("bottom", 0.5 * WIDTH, 0.0)
    system.add(lm.DistanceJoint("rod", ground.marker("peg", 0, 0, 0), body.marker("hook", 0.5 * WIDTH, HEIGHT)))
    system.add(lm.Gravity("weight", (0, 0, -G), lm.SmoothStep(t_end=0.2)))
    return system


def constrained_errors(rho: float) -> np.ndarray:
    """Errors of position, velocity and multiplier for two steps, against a run with an eighth of the smaller one."""
    finals = []
    for n in (100, 200, 1600):
        options = lm.GeneralizedAlpha(dt=0.5 / n, rho_inf=rho, newton=TIGHT)
        result = lm.simulate(swinging(), 0.5, options)
        finals.append([result["bottom.position"].values[-1], result["bottom.velocity"].values[-1], result.final.lam])
    return np.array([[np.abs(x - y).max() for x, y in zip(final, finals[-1], strict=True)] for final in finals[:-1]])


def run() -> Iterator[Evidence]:
    """Yield the checks and pictures of this case."""
    references = References.beside(__file__)
    series = {}
    for rho in (1.0, 0.9, 0.0):
        errors = linear_errors(rho)
        yield references.check(f"order of q and v, rho_inf = {rho:g}", np.log2(errors[0] / errors[2]) / 2)
        series[f"rho_inf = {rho:g}"] = (0.8 / np.array(PER_SWING), errors)
    yield Orders("A linear plate in its first mode", "Time step / period [–]", series, (2,), "Error [m]")
    errors = constrained_errors(0.8)
    names = ("positions", "velocities", "the multiplier")
    for place, name in enumerate(names):
        yield references.check(f"order of {name} with a rod", np.log2(errors[0, place] / errors[1, place]))
    series = {name: ((5e-3, 2.5e-3), errors[:, place] / errors[0, place]) for place, name in enumerate(names)}
    yield Orders("A plate on a rod (index 3)", "Time step [s]", series, (2,), "Error / error of the coarser step [–]")
