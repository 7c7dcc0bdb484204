"""Cantilever strip under a shear force at its end, over the whole load path."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Literal

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import root_scalar

import lamella as lm
from lamella.result import Result
from lamella.roles import Floats
from lamella.verification import Curves, Evidence, References, Shape

slow = False

LENGTH, WIDTH, THICKNESS, MODULUS, FORCE = 10.0, 1.0, 0.1, 1.2e6, 4.0
BENDING_STIFFNESS = MODULUS * WIDTH * THICKNESS**3 / 12


def run() -> Iterator[Evidence]:
    """Yield the checks and pictures of this case."""
    references = References.beside(__file__)
    factors = references.at("W, published")
    result = loaded((16, 1), factors)
    path = tip_path(result, factors)
    yield from references.checks("-U, published", (-path[:, 0]).tolist())
    yield from references.checks("W, published", path[:, 1].tolist())
    exact = np.array([elastica(factor * FORCE) for factor in factors])
    worst = np.abs(path - exact).max(axis=0)
    yield references.check("U, mesh 16 x 1: largest distance to the elastica over the path", worst[0])
    yield references.check("W, mesh 16 x 1: largest distance to the elastica over the path", worst[1])
    yield references.check("-U at full load, mesh 16 x 1", -path[-1, 0])
    yield references.check("W at full load, mesh 16 x 1", path[-1, 1])
    fine = tip_path(loaded((64, 1), [0.5, 1.0]), [1.0])[-1]
    yield references.check("-U at full load, mesh 64 x 1", -fine[0])
    yield references.check("W at full load, mesh 64 x 1", fine[1])
    other = tip_path(loaded((16, 2), factors, "plate36"), factors)
    for name, distance in zip("UW", np.abs(other - exact).max(axis=0), strict=True):
        yield references.check(f"{name}, Plate36, mesh 16 x 2: largest distance to the elastica over the path", distance)
    computed = {"−U": ([0.0, *factors], [0.0, *-path[:, 0]]), "W": ([0.0, *factors], [0.0, *path[:, 1]])}
    published = {f"{name}, Sze et al.": references.points(f"{name.replace('−', '-')}, published") for name in computed}
    computed |= {"−U, Plate36": (factors, -other[:, 0]), "W, Plate36": (factors, other[:, 1])}
    elastic = {"−U, elastica": (factors, -exact[:, 0]), "W, elastica": (factors, exact[:, 1])}
    yield Curves("Displacement of the tip", "Load factor [–]", "Displacement [m]", computed, published | elastic)
    yield Shape("At 20 % and 100 % of the load", result, at=(0.2, 1.0), view=(0.3, 1.0, -0.3))


def loaded(mesh: tuple[int, int], factors: Sequence[float], element: Literal["plate48", "plate36"] = "plate48") -> Result:
    """Equilibria of the strip at each load factor."""
    system = lm.System()
    strip = lm.Laminate(lm.Isotropic(E=MODULUS, nu=0.0, rho=1.0), thickness=THICKNESS)
    plate = system.add(lm.Plate("strip", (LENGTH, WIDTH), mesh, strip, element=element))
    plate.marker("tip", LENGTH, WIDTH / 2)
    system.add(lm.Clamp("root", plate.edge("x-")))
    system.add(lm.EdgeForce("shear", plate.edge("x+"), (0.0, 0.0, FORCE / WIDTH)))
    return lm.equilibrium(system, steps=list(factors))


def tip_path(result: Result, factors: Sequence[float]) -> Floats:
    """Displacements (U, W) of the tip [m] at each load factor, shape (n, 2)."""
    tip = result.history("tip.position").sel(load_factor=list(factors), method="nearest").values
    return tip[:, [0, 2]] - [LENGTH, 0.0]


def elastica(force: float) -> Floats:
    """Tip displacements (U, W) [m] of the inextensible cantilever: EI theta'' = -F cos theta, theta(0) = 0, theta'(L) = 0."""

    def shot(curvature: float) -> Floats:
        def slope(_: float, y: Floats) -> list[float]:
            return [y[1], -force / BENDING_STIFFNESS * np.cos(y[0]), np.cos(y[0]), np.sin(y[0])]

        return solve_ivp(slope, (0.0, LENGTH), [0.0, curvature, 0.0, 0.0], rtol=1e-10, atol=1e-12).y[:, -1]

    bracket = (0.0, force * LENGTH / BENDING_STIFFNESS)
    end = shot(root_scalar(lambda curvature: shot(curvature)[1], bracket=bracket, xtol=1e-13).root)
    return np.array([end[2] - LENGTH, end[3]])
