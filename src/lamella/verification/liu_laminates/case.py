"""Four laminated cantilever plates under their own weight."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.integrate import solve_bvp

import lamella as lm
from lamella.roles import Floats
from lamella.verification import Check, Curves, Evidence, References, Shape

slow = False

SIDE, THICKNESS, GRAVITY = 0.5, 1e-3, 9.81
PLY = lm.Lamina(E1=177e9, E2=10.8e9, G12=7.6e9, nu12=0.0, rho=7800)
STACKS = {
    "[0]4, along the fibre": (0, 0, 0, 0),
    "[0]4, across the fibre": (90, 90, 90, 90),
    "[0/90/90/0], along x": (0, 90, 90, 0),
    "[0/90/90/0], along y": (90, 0, 0, 90),
}


def run() -> Iterator[Evidence]:
    """Yield the checks and pictures of this case."""
    references = References.beside(__file__)
    lines, exact = {}, {}
    for name, angles in STACKS.items():
        laminate = lm.Laminate(PLY, angles=angles, thickness=THICKNESS)
        result = sagging(laminate, (32, 2))
        sag = float(result["tip.position"][2])
        yield references.check(name, sag)
        s, z = elastica(laminate.mass_per_area * GRAVITY, laminate.D[0, 0])
        source, why = "analytic: elastica under its own weight", "mesh 32 x 2, and the plate's own stretch"
        yield Check(f"{name}, elastica", sag, z[-1], 1e-4, source=source, unit="m", reason=why)
        sample = result.model.plates[0].sample(result.final.q)
        lines[name], exact[f"{name}, elastica"] = (sample.x, sample.r[len(sample.y) // 2, :, 2]), (s[::10], z[::10])
    softest = lm.Laminate(PLY, angles=STACKS["[0]4, across the fibre"], thickness=THICKNESS)
    square = sagging(softest, (8, 8))
    yield references.check("[0]4, across the fibre, mesh 8 x 8", float(square["tip.position"][2]))
    yield Curves("Middle lines under their own weight", "Distance along the plate [m]", "z [m]", lines, exact)
    yield Shape("[0]4, across the fibre", square)


def sagging(laminate: lm.Laminate, mesh: tuple[int, int]) -> lm.Result:
    """Equilibrium, with the middle of the free edge recorded as ``tip``."""
    system = lm.System()
    plate = system.add(lm.Plate("plate", (SIDE, SIDE), mesh, laminate))
    plate.marker("tip", SIDE, SIDE / 2)
    system.add(lm.Clamp("root", plate.edge("x-")))
    system.add(lm.Gravity("weight", (0.0, 0.0, -GRAVITY)))
    return lm.equilibrium(system)


def elastica(weight: float, stiffness: float) -> tuple[Floats, Floats]:
    """Distance from the root and height [m], cylindrical bending without extension:

    D theta'' = q (L - s) cos theta, theta(0) = 0, theta'(L) = 0.
    """

    def slope(s: Floats, y: Floats) -> Floats:
        return np.array([y[1], weight * (SIDE - s) * np.cos(y[0]) / stiffness, np.sin(y[0])])

    def ends(left: Floats, right: Floats) -> Floats:
        return np.array([left[0], left[2], right[1]])

    s = np.linspace(0.0, SIDE, 100)
    return s, solve_bvp(slope, ends, s, np.zeros((3, len(s))), tol=1e-8).sol(s)[2]
