"""Cylinder on rigid diaphragms, pinched by two opposite forces at half its length."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal

import numpy as np

import lamella as lm
from lamella.result import Result
from lamella.roles import Floats
from lamella.verification import Curves, Evidence, Orders, References, Shape
from lamella.verification.koiter_cylinder import pinched_cylinder

slow = True

RADIUS, LENGTH, THICKNESS, FORCE = 300.0, 600.0, 3.0, 1.0
MATERIAL = lm.Isotropic(E=3e6, nu=0.3, rho=1.0)
MESHES = (4, 8, 16, 32)
UPRIGHT = (np.pi / 2, 0.0, 0.0)  # lays the axis of the cylinder along -y
Element = Literal["plate48", "plate36"]


def run() -> Iterator[Evidence]:
    """Yield the checks and pictures of this case."""
    references = References.beside(__file__)
    exact = pinched_cylinder(MATERIAL, RADIUS, LENGTH, THICKNESS, FORCE)
    yield references.check("series of Koiter's theory: deflection", exact)
    full = shares("plate48", exact)
    reduced = shares("plate48", exact, membrane_gauss=3, meshes=MESHES[:3])
    without_twist = shares("plate36", exact)
    yield references.check("plate48, 32 x 32: deflection over the series", full[3])
    yield references.check("plate36, 32 x 32: deflection over the series", without_twist[3])
    order = float(np.log2((1 - full[2]) / (1 - full[3])))
    yield references.check("plate48: order of the deflection, 16 to 32 elements", order)
    yield references.check("plate48, 4 x 4: deflection with membrane_gauss = 3 over that with 4", reduced[0] / full[0])
    yield references.check("plate48, 16 x 16: deflection with membrane_gauss = 3 over that with 4", reduced[2] / full[2])
    found = {"plate48": full, "plate48, membrane_gauss = 3": reduced, "plate36": without_twist}
    lines = {label: (list(MESHES[: len(share)]), share) for label, share in found.items()}
    one = {"Koiter's theory": ([4.0, 32.0], [1.0, 1.0])}
    yield Curves("Deflection over the series", "Elements along a side of the octant [–]", "w / w of the series [–]", lines, one)
    errors = {name: ([LENGTH / 2 / n for n in meshes], np.abs(1 - share)) for name, (meshes, share) in lines.items()}
    yield Orders("Error against the series", "Element along the axis [m]", errors, (2,))
    yield Shape("An octant, displacement x 2e6", octant(16, "plate48"), scale=2e6)


def shares(
    element: Element, exact: float, *, membrane_gauss: Literal[3] | None = None, meshes: tuple[int, ...] = MESHES
) -> Floats:
    """Deflection over the exact one on each mesh."""
    return np.array([dent(octant(n, element, membrane_gauss)) / exact for n in meshes])


def octant(n: int, element: Element, membrane_gauss: Literal[3] | None = None) -> Result:
    """Equilibrium of an octant on n x n elements under a quarter of the force."""
    surface = lm.CylinderSurface(RADIUS, LENGTH / 2, angle=(0.0, np.pi / 2))
    system, section = lm.System(), lm.Laminate(MATERIAL, thickness=THICKNESS)
    shell = system.add(
        lm.Shell(
            "cylinder",
            surface,
            (n, n),
            section,
            rotation=UPRIGHT,
            strain="linear",
            element=element,
            membrane_gauss=membrane_gauss,
        )
    )
    pinched = shell.marker("C", RADIUS * np.pi / 2, LENGTH / 2)
    system.add(lm.Diaphragm("wall", shell.edge("y-"), normal="y"))
    system.add(lm.Symmetry("middle", shell.edge("y+"), normal="y"))
    system.add(lm.Symmetry("side", shell.edge("x-"), normal="z"))
    system.add(lm.Symmetry("top", shell.edge("x+"), normal="x"))
    system.add(lm.PointForce("pinch", pinched, (0.0, 0.0, -FORCE / 4)))
    return lm.equilibrium(system, newton=lm.Newton(tolerance=1e-11, keep=0.0))


def dent(result: Result) -> float:
    """Inward displacement of C, where the force acts [m]."""
    return RADIUS - float(result["C.position"].values[2])
