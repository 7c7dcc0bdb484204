"""Hemisphere with a hole under two pairs of radial forces, over the whole load path."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Literal

import numpy as np

import lamella as lm
from lamella.result import Result
from lamella.roles import Floats
from lamella.verification import Curves, Evidence, References, Shape

slow = False

RADIUS, THICKNESS, MODULUS, POISSON, FORCE = 10.0, 0.04, 6.825e7, 0.3, 400.0
LATITUDE, QUARTER = np.radians(72.0), np.radians(90.0)
OUTWARD, INWARD = "V_A", "-U_B"
KINDS = {"Plate48": ("plate48", None), "Plate48, membrane_gauss 3": ("plate48", 3), "Plate36": ("plate36", None)}
MESHES = (8, 12, 16)
FINE = 8.1454
"""-U_B at full load on 32 x 32 Plate48 [m], computed once."""

Element = Literal["plate48", "plate36"]


def run() -> Iterator[Evidence]:
    """Yield the checks and pictures of this case."""
    references = References.beside(__file__)
    factors = references.at(OUTWARD)
    results = {"Plate48": loaded(16, factors), "Plate36": loaded(16, factors, "plate36")}
    paths = {label: displacements(result, factors) for label, result in results.items()}
    for name, values in zip((OUTWARD, INWARD), paths["Plate48"].T, strict=True):
        yield from references.checks(name, values)
    for name, values in zip((OUTWARD, INWARD), paths["Plate36"].T, strict=True):
        yield from references.checks(f"{name}, Plate36", values)
    ends = {label: [at_full_load(n, *kind) for n in MESHES] for label, kind in KINDS.items()}
    errors = FINE - np.array(ends["Plate48"])
    order = float(np.log2(errors[0] / errors[-1]))
    yield references.check("order of convergence of -U_B at full load, 8 x 8 to 16 x 16", order)
    yield path_picture(references, factors, paths)
    published = ([MESHES[0], MESHES[-1]], 2 * [references.value(INWARD)[-1]])
    yield Curves(
        "Point B at full load over the mesh",
        "Elements along each side of the quarter [–]",
        "−U_B [m]",
        {label: (MESHES, found) for label, found in ends.items()},
        {"Sze et al., 16 x 16": published},
    )
    yield Shape("A quarter at full load, 16 x 16 Plate48", results["Plate48"], view=(1.0, 1.0, 0.6))


def loaded(n: int, factors: Sequence[float], element: Element = "plate48", membrane_gauss: Literal[3] | None = None) -> Result:
    """Equilibria of a quarter of the hemisphere at each load factor, n x n elements; A on its x axis, B on its y axis."""
    system = lm.System()
    section = lm.Laminate(lm.Isotropic(E=MODULUS, nu=POISSON, rho=1.0), thickness=THICKNESS)
    surface = lm.SphereSurface(RADIUS, latitude=(0.0, LATITUDE), angle=(0.0, QUARTER))
    shell = system.add(lm.Shell("shell", surface, (n, n), section, element=element, membrane_gauss=membrane_gauss))
    A, B = shell.marker("A", 0.0, 0.0), shell.marker("B", surface.size[0], 0.0)
    system.add(lm.Symmetry("plane y", shell.edge("x-"), "y"))
    system.add(lm.Symmetry("plane x", shell.edge("x+"), "x"))
    system.add(lm.PointSupport("height", A, "z"))
    system.add(lm.PointForce("pull", A, (FORCE / 2, 0.0, 0.0)))  # half of it acts on this side of the plane
    system.add(lm.PointForce("push", B, (0.0, -FORCE / 2, 0.0)))
    return lm.equilibrium(system, steps=list(factors))


def displacements(result: Result, factors: Sequence[float]) -> Floats:
    """V_A outwards and -U_B inwards [m] at each load factor, shape (n, 2)."""
    A, B = (result.history(f"{name}.position").sel(load_factor=list(factors), method="nearest").values for name in "AB")
    return np.stack([A[:, 0] - RADIUS, RADIUS - B[:, 1]], axis=1)


def at_full_load(n: int, element: Element, membrane_gauss: Literal[3] | None) -> float:
    """-U_B [m] at full load, reached in few steps."""
    return float(displacements(loaded(n, (0.1, 0.3, 0.6, 1.0), element, membrane_gauss), [1.0])[0, 1])


def path_picture(references: References, factors: Sequence[float], paths: dict[str, Floats]) -> Curves:
    """Both displacements over the load, with the published points."""
    computed = {
        f"{name.replace('-', '−')}, {label}": ([0.0, *factors], [0.0, *values])
        for label, path in paths.items()
        for name, values in zip((OUTWARD, INWARD), path.T, strict=True)
    }
    published = {f"{name.replace('-', '−')}, Sze et al.": references.points(name) for name in (OUTWARD, INWARD)}
    return Curves("Points A and B, mesh 16 x 16", "Load factor [–]", "Displacement [m]", computed, published)
