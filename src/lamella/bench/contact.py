"""Contact between a belt of 40 elements and three rollers, of which one touches all of it: 5880 pairs of points and rollers."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

import lamella as lm
from lamella.bench.clock import best
from lamella.bench.row import Row
from lamella.contact.block import ContactBlock
from lamella.roles import Floats

CASE, CODE = "contact", "lamella"
LENGTH, WIDTH, THICKNESS, DEPTH = 2.5, 0.8, 0.004, 2e-4  # m


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
        law: Any = {"stiffness": 1e10, "damping": 0.05, "mu": 0.3}
        system.add(lm.CylinderContact(f"on {name}", belt, roller.origin, radius, 1.2, **law))
    model = system.compile()
    return [block for block in model.forces if isinstance(block, ContactBlock)], model.q0, model.v0


def calls() -> tuple[dict[str, Callable[[], object]], str]:
    """What contact computes for all three rollers together, and how many pairs that is, in words."""
    made, q, v = blocks()
    f = [np.zeros(len(block.f_coords)) for block in made]
    k = [np.zeros(len(block.k_rows)) for block in made]
    found = [block.totals(q, v) for block in made]
    pairs = f"{sum(total.evaluated for total in found)} pairs evaluated, {sum(total.points for total in found)} touch"

    def force() -> None:
        for block, own in zip(made, f, strict=True):
            block.force(0.0, q.copy(), v, own)  # a block knows the forces of a state that it has just seen

    def tangent() -> None:
        for block, own, matrix in zip(made, f, k, strict=True):
            block.force_tangent(0.0, q, v, 1.0, 1e3, q, own, matrix)

    return {"force": force, "force + tangent": tangent}, pairs


def run(runs: int) -> Iterator[Row]:
    """All three rollers together; the shortest of many calls, ``runs`` times as long."""
    work, pairs = calls()
    for what, call in work.items():
        call()  # compiles what is not in the cache
        yield Row(case=CASE, code=CODE, what=what, time=best(call, 0.1 * runs) * 1e3, unit="ms", note=pairs)
