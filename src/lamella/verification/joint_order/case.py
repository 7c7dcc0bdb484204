"""Order of convergence of a mechanism with joints in space: positions, velocities, multipliers and reactions."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

import lamella as lm
from lamella.result import Result
from lamella.roles import Floats
from lamella.verification import Evidence, Orders, References

slow = True

END = 0.4
STEPS = (100, 200, 800)


def mechanism() -> lm.System:
    """A body on a universal joint, with a second one that slides on it along a skew axis and a third that turns on that."""
    inertia = {
        "mass": 1.3,
        "inertia": (0.02, 0.03, 0.04),
        "products": (0.002, -0.003, 0.001),
        "centre_of_mass": (0.02, 0.01, -0.03),
    }
    system, ground = lm.System(), lm.Ground()
    first = lm.RigidBody("first", **inertia, position=(0.3, 0.0, 0.0))
    second = lm.RigidBody("second", **inertia, position=(0.6, 0.1, 0.0))
    third = lm.RigidBody("third", **inertia, position=(0.8, 0.1, 0.2))
    hook = ground.marker("hook", 0, 0, 0)
    rail = (0.3, 0.1, 0.0)
    for item in (
        *(ground, first, second, third),
        lm.UniversalJoint("hanger", hook, first.marker("start", -0.3, 0, 0), axis_a=(0, 1, 0), axis_b=(0.2, 0, 1)),
        lm.CylindricalJoint("rail", first.origin, second.origin, axis=rail),
        lm.RevoluteJoint("elbow", second.marker("end", 0.2, 0, 0), third.marker("root", 0.0, 0, -0.2), axis=(0.3, 1.0, 0.2)),
        lm.Gravity("weight"),
    ):
        system.add(item)
    return system


def solutions() -> list[Result]:
    """The same motion with three steps; the last one serves as the reference."""
    newton = lm.Newton(tolerance=1e-12)
    return [lm.simulate(mechanism(), END, lm.GeneralizedAlpha(dt=END / n, rho_inf=0.8, newton=newton)) for n in STEPS]


def run() -> Iterator[Evidence]:
    """Yield the checks and pictures of this case."""
    references = References.beside(__file__)
    results = solutions()
    series = {}
    for name, values in (
        ("positions", [result.final.q for result in results]),
        ("velocities", [result.final.v for result in results]),
        ("multipliers", [result.final.lam for result in results]),
        ("reaction force of the rail", [result["rail.force"].values[-1] for result in results]),
        ("reaction torque of the elbow", [result["elbow.torque"].values[-1] for result in results]),
    ):
        yield references.check(f"order of {name}", _order(values))
        series[name] = ([END / n for n in STEPS[:2]], [_error(value, values[2]) for value in values[:2]])
    yield Orders("A mechanism with joints in space", "Time step [s]", series, (2,))
    yield references.check("relative error of the multipliers", _error(results[1].final.lam, results[2].final.lam))


def _error(found: Floats, reference: Floats) -> float:
    return float(np.abs(found - reference).max() / np.abs(reference).max())


def _order(values: list[Floats]) -> float:
    coarse, fine, reference = values
    return float(np.log2(_error(coarse, reference) / _error(fine, reference)))
