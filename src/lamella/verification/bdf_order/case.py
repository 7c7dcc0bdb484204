"""Observed order of backward differentiation formulas, against an exact solution and with constraints."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

import lamella as lm
from lamella.roles import Floats
from lamella.verification import Evidence, Orders, References

slow = False

TIGHT = lm.Newton(tolerance=1e-10)
ORDERS = (1, 2, 3, 4, 5)
COUNTS, END = (50, 100), 0.5
"""Steps in a second on the spring, which are twice as many for the pendulum; end of the pendulum's motion [s]."""


def steps(order: int, dt: float) -> lm.BDF:
    """Steps of fixed size and order."""
    return lm.BDF(dt=dt, tolerance=None, max_order=order, newton=TIGHT)


def on_a_spring() -> lm.System:
    """A body of 2 kg on a spring of 50 N/m, 0.1 m from where it would rest."""
    system = lm.System()
    ground = system.add(lm.Ground())
    body = system.add(lm.RigidBody("ball", mass=2.0, inertia=(0.1, 0.1, 0.1), position=(0, 0, 1.0)))
    system.add(
        lm.SpringDamper("spring", ground.marker("o", 0, 0, -4.0), body.origin, stiffness=50.0, rest_length=lm.Constant(4.9))
    )
    return system


def double_pendulum() -> lm.System:
    """Two rods whose hinges are not parallel, released from the horizontal."""
    system = lm.System()
    ground = system.add(lm.Ground())
    upper = system.add(lm.RigidBody("upper", mass=1.0, inertia=(0.1, 0.1, 0.02), position=(0.5, 0, 0)))
    lower = system.add(lm.RigidBody("lower", mass=0.7, inertia=(0.05, 0.05, 0.02), position=(1.3, 0, 0)))
    system.add(lm.RevoluteJoint("top", ground.marker("o", 0, 0, 0), upper.marker("in", -0.5, 0, 0), axis=(0, 1, 0)))
    system.add(lm.RevoluteJoint("knee", upper.marker("out", 0.5, 0, 0), lower.marker("at", -0.3, 0, 0), axis=(0, 1, 0.3)))
    system.add(lm.Gravity("weight", (0, 0, -9.81)))
    return system


def spring_errors(order: int) -> list[float]:
    """Errors of position and velocity [m] for two steps."""
    errors = []
    for n in COUNTS:
        final = lm.simulate(on_a_spring(), 1.0, steps(order, 1.0 / n)).final
        errors.append(float(np.hypot(final.q[2] - 0.9 - 0.1 * np.cos(5.0), final.v[2] / 5.0 + 0.1 * np.sin(5.0))))
    return errors


def pendulum_errors() -> Floats:
    """Relative errors of positions, velocities and multipliers, by order and step."""
    exact = lm.simulate(double_pendulum(), END, lm.BDF(dt=1e-3, tolerance=1e-10, max_order=5, newton=TIGHT)).final
    found = []
    for order in ORDERS[:4]:  # with order 5 the finer error would be that of the reference
        finals = [lm.simulate(double_pendulum(), END, steps(order, END / (2 * n))).final for n in COUNTS]
        pairs = [[(getattr(final, name), getattr(exact, name)) for name in ("q", "v", "lam")] for final in finals]
        found.append([[np.abs(x - y).max() / np.abs(y).max() for x, y in pair] for pair in pairs])
    return np.array(found)


def run() -> Iterator[Evidence]:
    """Yield the checks and pictures of this case."""
    references = References.beside(__file__)
    series = {}
    for order in ORDERS:
        errors = spring_errors(order)
        yield references.check(f"order of q and v, formula of order {order}", np.log2(errors[0] / errors[1]))
        series[f"order {order}"] = (1.0 / np.array(COUNTS), errors)
    yield Orders("A body on a spring", "Time step [s]", series, ORDERS, "Error [m]")
    errors = pendulum_errors()
    series = {}
    for k, order in enumerate(ORDERS[:4]):
        for place, name in enumerate(("positions", "velocities", "multipliers")):
            yield references.check(
                f"order of {name}, formula of order {order}", np.log2(errors[k, 0, place] / errors[k, 1, place])
            )
        series[f"multipliers, order {order}"] = (0.5 * END / np.array(COUNTS), errors[k, :, 2])
    yield Orders("A double pendulum (stabilised index 2)", "Time step [s]", series, ORDERS[:4])
