"""Four laminated cantilever plates under their own weight."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.integrate import solve_bvp

import lamella as lm
from lamella.roles import Floats
from lamella.verification import Check, References

slow = False

SIDE, THICKNESS, GRAVITY = 0.5, 1e-3, 9.81
PLY = lm.Lamina(E1=177e9, E2=10.8e9, G12=7.6e9, nu12=0.0, rho=7800)
STACKS = {
    "[0]4, along the fibre": (0, 0, 0, 0),
    "[0]4, across the fibre": (90, 90, 90, 90),
    "[0/90/90/0], along x": (0, 90, 90, 0),
    "[0/90/90/0], along y": (90, 0, 0, 90),
}


def run() -> Iterator[Check]:
    """Yield the checks of this case."""
    references = References.beside(__file__)
    for name, angles in STACKS.items():
        laminate = lm.Laminate(PLY, angles=angles, thickness=THICKNESS)
        sag = tip_height(laminate, (32, 2))
        yield references.check(name, sag)
        exact = elastica(laminate.mass_per_area * GRAVITY, laminate.D[0, 0])
        yield Check(f"{name}, elastica", sag, exact, 1e-4, source="analytic: elastica under its own weight", unit="m")
    softest = lm.Laminate(PLY, angles=STACKS["[0]4, across the fibre"], thickness=THICKNESS)
    yield references.check("[0]4, across the fibre, mesh 8 x 8", tip_height(softest, (8, 8)))


def tip_height(laminate: lm.Laminate, mesh: tuple[int, int]) -> float:
    """Height of the middle of the free edge [m] in equilibrium."""
    system = lm.System()
    plate = system.add(lm.Plate("plate", (SIDE, SIDE), mesh, laminate))
    plate.marker("tip", SIDE, SIDE / 2)
    system.add(lm.Clamp("root", plate.edge("x-")))
    system.add(lm.Gravity("weight", (0.0, 0.0, -GRAVITY)))
    return float(lm.equilibrium(system)["tip.position"][2])


def elastica(weight: float, stiffness: float) -> float:
    """Tip height [m] of D theta'' = q (L - s) cos theta, theta(0) = 0, theta'(L) = 0 (cylindrical bending, inextensible)."""

    def slope(s: Floats, y: Floats) -> Floats:
        return np.array([y[1], weight * (SIDE - s) * np.cos(y[0]) / stiffness, np.sin(y[0])])

    def ends(left: Floats, right: Floats) -> Floats:
        return np.array([left[0], left[2], right[1]])

    s = np.linspace(0.0, SIDE, 100)
    return float(solve_bvp(slope, ends, s, np.zeros((3, len(s))), tol=1e-8).y[2, -1])
