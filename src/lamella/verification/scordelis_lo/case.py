"""Roof of Scordelis and Lo: a cylindrical shell on diaphragms under its weight."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal

import numpy as np

import lamella as lm
from lamella.result import Result
from lamella.verification import Curves, Evidence, References, Shape
from lamella.verification.koiter_cylinder import roof_under_weight

slow = False

RADIUS, LENGTH, THICKNESS, HALF_ANGLE = 25.0, 50.0, 0.25, np.radians(40.0)
MATERIAL = lm.Isotropic(E=4.32e8, nu=0.0, rho=1.0)
WEIGHT = 90.0
UPRIGHT = (np.pi / 2, 0.0, 0.0)  # lays the axis of the cylinder along -y
MESHES = (2, 4, 8, 16)
SMALL = 1e-3
"""Share of the weight under which exact strains are compared with linear ones."""
Element = Literal["plate48", "plate36"]


def run() -> Iterator[Evidence]:
    """Yield the checks and pictures of this case."""
    references = References.beside(__file__)
    exact = roof_under_weight(MATERIAL, RADIUS, LENGTH, THICKNESS, HALF_ANGLE, WEIGHT)
    yield references.check("series of Koiter's theory: deflection", exact)
    found, errors = {}, {}
    for element in ("plate48", "plate36"):
        sags = [sag(quarter(n, element)) for n in MESHES]
        found[element] = list(MESHES), sags
        errors[element] = list(MESHES), [abs(value / exact - 1) for value in sags]
        yield references.check(f"{element}, 16 x 16: deflection over the series", sags[-1] / exact)
        yield references.check(f"{element}, 16 x 16: deflection", sags[-1])
        first = 1 if element == "plate48" else 2  # beyond which its error is of one sign, and above rounding
        order = np.log2(errors[element][1][first] / errors[element][1][first + 1])
        name = f"{element}: order of the deflection, {MESHES[first]} to {MESHES[first + 1]} elements"
        yield references.check(name, order)
    small, linear = (sag(quarter(8, "plate48", strain, SMALL)) for strain in ("exact", "linear"))
    yield references.check("exact strains under a thousandth of the weight, over linear ones", small / linear)
    axis = "Elements along a side of the quarter [–]"
    series = {"Koiter's theory": ([2.0, 16.0], [exact, exact])}
    yield Curves("Deflection of the free edge", axis, "Deflection [m]", found, series)
    yield Curves("Error against the series", axis, "Relative error [–]", errors, log="xy")
    yield Shape("A quarter of the roof, displacement x 10", quarter(8, "plate48"), scale=10.0)


def quarter(n: int, element: Element, strain: Literal["exact", "linear"] = "linear", share: float = 1.0) -> Result:
    """Equilibrium of a quarter of the roof on n x n elements under a share of the weight."""
    surface = lm.CylinderSurface(RADIUS, LENGTH / 2, angle=(np.pi / 2 - HALF_ANGLE, np.pi / 2))
    system, section = lm.System(), lm.Laminate(MATERIAL, thickness=THICKNESS)
    roof = system.add(lm.Shell("roof", surface, (n, n), section, rotation=UPRIGHT, strain=strain, element=element))
    roof.marker("B", 0.0, LENGTH / 2)
    system.add(lm.Diaphragm("wall", roof.edge("y-"), normal="y"))
    system.add(lm.Symmetry("middle", roof.edge("y+"), normal="y"))
    system.add(lm.Symmetry("crown", roof.edge("x+"), normal="x"))
    system.add(lm.SurfaceForce("weight", roof, (0.0, 0.0, -share * WEIGHT)))
    return lm.equilibrium(system, newton=lm.Newton(tolerance=1e-11, keep=0.0))


def sag(result: Result) -> float:
    """Downward displacement of B, the middle of the free edge."""
    return RADIUS * float(np.cos(HALF_ANGLE)) - float(result["B.position"].values[2])
