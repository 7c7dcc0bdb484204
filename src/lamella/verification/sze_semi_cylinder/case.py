"""Semi-cylinder with one end clamped, pinched at the crown of the free end, over the whole load path."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Literal

import numpy as np

import lamella as lm
from lamella.result import Result
from lamella.roles import Floats
from lamella.verification import Curves, Evidence, References, Shape
from lamella.verification.cylinder_series import PinchedCylinder

slow = True

RADIUS, LENGTH, THICKNESS, MODULUS, POISSON, FORCE = 1.016, 3.048, 0.03, 2.0685e7, 0.3, 2000.0
PARTS = ("-W_A, load factors up to 0.2", "-W_A, steep part of the path", "-W_A, from 0.4 to full load")
KINDS = {"Plate48": ("plate48", None), "Plate48, membrane_gauss 3": ("plate48", 3), "Plate36": ("plate36", None)}
MESHES = (6, 8, 12)
SMALL = 1e-4
"""Load factor at which the theory is linear to 1e-4."""

Element = Literal["plate48", "plate36"]


def run() -> Iterator[Evidence]:
    """Yield the checks and pictures of this case."""
    references = References.beside(__file__)
    factors = [factor for part in PARTS for factor in references.at(part)]
    published = [value for part in PARTS for value in references.value(part)]
    results = {"Plate48, 16 x 16": loaded(16, (SMALL, *factors)), "Plate36, 24 x 24": loaded(24, factors, "plate36")}
    result, other = results.values()
    linear = PinchedCylinder(RADIUS, LENGTH, THICKNESS, MODULUS, POISSON, "clamped").deflection(160)
    small = deflections(result, [SMALL])[0] / (SMALL * FORCE)
    yield references.check("-W_A under a small load over that of linear theory", small / linear)
    for part in PARTS:
        yield from references.checks(part, deflections(result, references.at(part)))
    for part in PARTS:
        yield from references.checks(f"{part}, Plate36", deflections(other, references.at(part)))
    computed = {label: ([0.0, *factors], [0.0, *deflections(found, factors)]) for label, found in results.items()}
    points = {"Sze et al., 40 x 40": (factors, published)}
    yield Curves("Point A", "Load factor [–]", "−W_A [m]", computed, points)
    ends = {label: [at_half_load(n, *kind) for n in MESHES] for label, kind in KINDS.items()}
    yield Curves(
        "Point A at half the load over the mesh",
        "Elements along each side of the half [–]",
        "−W_A [m]",
        {label: (MESHES, found) for label, found in ends.items()},
        {"Sze et al., 40 x 40": ([MESHES[0], MESHES[-1]], 2 * [published[factors.index(0.5)]])},
    )
    yield Shape("One half at 35 % and 100 % of the load, 16 x 16 Plate48", result, at=(0.35, 1.0), view=(0.8, 1.0, 0.6))


def loaded(n: int, factors: Sequence[float], element: Element = "plate48", membrane_gauss: Literal[3] | None = None) -> Result:
    """Equilibria of one half at each load factor: the axis is z, the crown along x, the straight edge in the plane x = 0."""
    system = lm.System()
    section = lm.Laminate(lm.Isotropic(E=MODULUS, nu=POISSON, rho=1.0), thickness=THICKNESS)
    surface = lm.CylinderSurface(RADIUS, LENGTH, angle=(0.0, np.pi / 2))
    shell = system.add(lm.Shell("shell", surface, (n, n), section, element=element, membrane_gauss=membrane_gauss))
    A = shell.marker("A", 0.0, LENGTH)
    system.add(lm.Clamp("clamp", shell.edge("y-"), kind="restrained"))
    system.add(lm.Symmetry("crown", shell.edge("x-"), "y"))
    system.add(lm.Symmetry("base", shell.edge("x+"), "x"))
    system.add(lm.PointForce("pinch", A, (-FORCE / 2, 0.0, 0.0)))  # half of it acts on this side of the plane
    return lm.equilibrium(system, steps=list(factors))


def deflections(result: Result, factors: Sequence[float]) -> Floats:
    """-W_A [m] at each load factor, shape (n,)."""
    return RADIUS - result.history("A.position").sel(load_factor=list(factors), method="nearest").values[:, 0]


def at_half_load(n: int, element: Element, membrane_gauss: Literal[3] | None) -> float:
    """-W_A [m] at half the load, reached in few steps."""
    return float(deflections(loaded(n, (0.1, 0.2, 0.3, 0.4, 0.5), element, membrane_gauss), [0.5])[0])
