"""Cantilever strip rolled up to a full circle by a moment at its end."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal

import numpy as np
from scipy.optimize import root_scalar

import lamella as lm
from lamella.assembly.equations import Equations
from lamella.assembly.point import STATIC
from lamella.result import Result
from lamella.roles import Floats
from lamella.solve.linear import linear_solver
from lamella.verification import Curves, Evidence, References, Shape

slow = False

LENGTH, THICKNESS, MODULUS = 12.0, 0.1, 1.2e6
FULL_CIRCLE = 50 * np.pi / 3
A, D = MODULUS * THICKNESS, MODULUS * THICKNESS**3 / 12


def run() -> Iterator[Evidence]:
    """Yield the checks and pictures of this case."""
    references = References.beside(__file__)
    factors = np.array(references.at("u, mesh 16 x 1"))
    coarse = rolled((16, 1), follower=True)
    path = tip(coarse, factors)
    yield from references.checks("u, mesh 16 x 1", path[:, 0].tolist())
    yield from references.checks("w, mesh 16 x 1", path[:, 1].tolist())
    fixed_axis = tip(rolled((16, 1), follower=False), factors)
    yield references.check("moment about a fixed axis against follower moment", np.abs(fixed_axis - path).max())
    model = np.array([extensible_circle(factor * FULL_CIRCLE) for factor in factors])
    fine = rolled((64, 1), follower=True)
    yield references.check("mesh 64 x 1 against the extensible circle", np.abs(tip(fine, factors) - model).max())
    yield references.check("membrane strain at full load", membrane_strain(fine))
    yield references.check("order of Newton's iteration", newton_order(coarse))
    other = tip(rolled((16, 2), follower=True, element="plate36"), factors)
    yield from references.checks("u, Plate36, mesh 16 x 2", other[:, 0].tolist())
    yield from references.checks("w, Plate36, mesh 16 x 2", other[:, 1].tolist())
    computed = {"u": ([0.0, *factors], [0.0, *path[:, 0]]), "w": ([0.0, *factors], [0.0, *path[:, 1]])}
    circle = {f"{name}, circle": references.points(f"{name}, mesh 16 x 1") for name in computed}
    computed |= {"u, Plate36": (factors, other[:, 0]), "w, Plate36": (factors, other[:, 1])}
    yield Curves("Displacement of the tip", "Moment / moment of a full circle [–]", "Displacement [m]", computed, circle)
    yield Shape("At 20, 50 and 100 % of the moment", coarse, at=(0.2, 0.5, 1.0), view=(0.3, 1.0, -0.3))


def rolled(mesh: tuple[int, int], *, follower: bool, element: Literal["plate48", "plate36"] = "plate48") -> Result:
    """The strip rolled up in ten load steps."""
    system = lm.System()
    section = lm.Laminate(lm.Isotropic(E=MODULUS, nu=0.0, rho=1.0), thickness=THICKNESS)
    plate = system.add(lm.Plate("strip", (LENGTH, 1.0), mesh, section, element=element))
    plate.marker("tip", LENGTH, 0.5)
    system.add(lm.Clamp("root", plate.edge("x-")))
    edge = plate.edge("x+")
    if follower:
        system.add(lm.EdgeMoment("moment", edge, bending=-FULL_CIRCLE))
    else:
        system.add(lm.EdgeMoment("moment", edge, moment=(0.0, -FULL_CIRCLE, 0.0)))
    return lm.equilibrium(system, steps=10)


def tip(result: Result, factors: Floats) -> Floats:
    """Displacements (u, w) of the tip [m], shape (n, 2)."""
    position = result.history("tip.position").sel(load_factor=factors, method="nearest").values
    return position[:, [0, 2]] - [LENGTH, 0.0]


def membrane_strain(result: Result) -> float:
    """Mean strain along the strip, from nine points in each element without the ends."""
    return float(result.model.plates[0].sample(result.final.q, 9).strains[:, 1:-1, 0].mean())


def extensible_circle(moment: float) -> tuple[float, float]:
    """Tip displacements (u, w) [m] of the formulation's own uniform state.

    With stretch g and rotation theta' per reference length, eps = (g^2 - 1)/2, kap = g theta', the energy
    A eps^2/2 + D kap^2/2 - M theta' is stationary for A eps g^2 = -D kap^2 and M = D g^2 theta'.
    """

    def unbalanced(g: float) -> float:
        return A * (g * g - 1) / 2 + D * (moment / (D * g * g)) ** 2

    g = root_scalar(unbalanced, bracket=(0.9, 1.1), xtol=1e-15).root
    rate = moment / (D * g * g)
    angle = rate * LENGTH
    return g * np.sin(angle) / rate - LENGTH, g * (1 - np.cos(angle)) / rate


def newton_order(result: Result) -> float:
    """Order p of |error after one iteration| ~ |error before|^p, from two disturbances of the solution, one half of the other."""
    equations = Equations(result.model, symmetric=False)
    solution = equations.point_of(result.final, result.final.t)
    solution.at_rest, solution.factor = True, 1.0
    linear = linear_solver(equations.matrix.pattern)
    flat = equations.start(factor=0.0, at_rest=True)
    left = []
    for size in (1e-6, 5e-7):  # small against the membrane strain, which a disturbance of 1e-4 exceeds
        point = solution.copy()
        point.u += size * (flat.u - solution.u)
        r, phi, k, j = equations.linearise(point, STATIC)
        linear.factorise(k, j)
        du, _ = linear.solve(-r, -phi)
        left.append(np.abs((point.u + du - solution.u) / equations.magnitude).max())
    return float(np.log2(left[0] / left[1]))
