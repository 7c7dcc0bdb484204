"""Times of contact between a belt of 40 elements and three rollers in milliseconds: minimum over many repeats on one thread.

Run ``python benchmarks/contact.py``; the first run also compiles. The goals for all three rollers together, 5880 pairs of points
and rollers of which a third touch: at most 1.5 for force and tangent and 0.3 for the force alone. The exit code is 1 when one is
missed.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable

import numpy as np

import lamella as lm
from lamella.contact.block import ContactBlock
from lamella.roles import Floats

LENGTH, WIDTH, THICKNESS, DEPTH = 2.5, 0.8, 0.004, 2e-4  # m
GOALS = {"force": 0.3, "force + tangent": 1.5}


def blocks() -> tuple[list[ContactBlock], Floats, Floats]:
    """The contact blocks of a circular belt that lies on one roller all around, while two others touch it from outside."""
    laminate = lm.Laminate(lm.Isotropic(E=1e9, nu=0.3, rho=1200), thickness=THICKNESS)
    system = lm.System()
    belt = system.add(lm.Shell("belt", lm.BeltSurface(LENGTH, WIDTH), (40, 1), laminate, position=(0, 0, -0.5 * WIDTH)))
    around = LENGTH / (2 * np.pi)
    places = {"inside": (around - 0.5 * THICKNESS + DEPTH, 0.0)}
    places |= {name: (0.12, sign * (around + 0.12 + 0.5 * THICKNESS - DEPTH)) for name, sign in (("left", -1), ("right", 1))}
    for name, (radius, x) in places.items():
        solid = lm.Cylinder(radius=radius, length=1.2)
        roller = system.add(lm.RigidBody(name, mass=60.0, shape=solid, position=(x, 0, 0), angular_velocity=(0, 0, 3.0)))
        law = {"stiffness": 1e10, "damping": 0.05, "mu": 0.3}
        system.add(lm.CylinderContact(f"on {name}", belt, roller.origin, radius, 1.2, **law))
    model = system.compile()
    return [block for block in model.forces if isinstance(block, ContactBlock)], model.q0, model.v0


def best(call: Callable[[], None], repeats: int = 200) -> float:
    """Shortest time of a call [ms]."""
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        call()
        times.append(time.perf_counter() - start)
    return 1e3 * min(times)


def measured() -> dict[str, float]:
    """Times of all blocks together [ms]."""
    made, q, v = blocks()
    f = [np.zeros(len(block.f_coords)) for block in made]
    k = [np.zeros(len(block.k_rows)) for block in made]
    found = [block.totals(q, v) for block in made]
    print(f"{sum(t.evaluated for t in found)} of 5880 pairs evaluated, {sum(t.points for t in found)} touch")

    def force() -> None:
        for block, own in zip(made, f, strict=True):
            block.force(0.0, q, v, own)

    def tangent() -> None:
        for block, own, matrix in zip(made, f, k, strict=True):
            block.force_tangent(0.0, q, v, 1.0, 1e3, q, own, matrix)

    return {"force": best(force), "force + tangent": best(tangent)}


def main() -> int:
    """Print the table; 1 when a goal is missed."""
    missed = False
    for name, found in measured().items():
        missed |= found > GOALS[name]
        print(f"{name:20} {found:8.3f} ms   goal {GOALS[name]}")
    return int(missed)


if __name__ == "__main__":
    sys.exit(main())
