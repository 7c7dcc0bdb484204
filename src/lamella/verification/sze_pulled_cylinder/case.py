"""Open cylinder pulled apart by two opposite forces, over the whole load path."""

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

RADIUS, LENGTH, THICKNESS, MODULUS, POISSON, FORCE = 4.953, 10.35, 0.094, 10.5e6, 0.3125, 4e4
NAMES = ("W_A", "-U_B", "-U_C")
SHEARED = "W_A with the transverse shear of linear theory"
KINDS = {"Plate48": ("plate48", None), "Plate48, membrane_gauss 3": ("plate48", 3), "Plate36": ("plate36", None)}
MESHES = (8, 12, 16)
SMALL = 1e-4
"""Load factor at which the theory is linear to 1e-4."""
PUBLISHED_WAVES = 32
"""Waves around the cylinder that the published mesh resolves with three elements each; it has 96 elements around."""

Element = Literal["plate48", "plate36"]


def run() -> Iterator[Evidence]:
    """Yield the checks and pictures of this case."""
    references = References.beside(__file__)
    factors = references.at(NAMES[0])
    result = lm.equilibrium(octant(16), steps=[SMALL, *factors])
    coarse = lm.equilibrium(octant(16, "plate36"), steps=factors)
    paths = {"Plate48": displacements(result, factors), "Plate36": displacements(coarse, factors)}
    linear = PinchedCylinder(RADIUS, LENGTH / 2, THICKNESS, MODULUS, POISSON, "symmetric")
    thin, sheared = linear.deflection(96), linear.deflection(PUBLISHED_WAVES, shear=True)
    small = displacements(result, [SMALL])[0, 0] / (SMALL * FORCE)
    yield references.check("W_A under a small load over that of linear theory", small / thin)
    shear = (sheared - linear.deflection(PUBLISHED_WAVES)) * FORCE * np.array(factors)
    for label, path in paths.items():
        suffix = "" if label == "Plate48" else f", {label}"
        for name, values in ((SHEARED, path[:, 0] + shear), (NAMES[1], path[:, 1]), (NAMES[2], path[:, 2])):
            yield from references.checks(name + suffix, values)
    yield path_picture(references, factors, paths, shear)
    ends = {label: [at_full_load(n, *kind) for n in MESHES] for label, kind in KINDS.items()}
    yield Curves(
        "Point B at full load over the mesh",
        "Elements along each side of the octant [–]",
        "−U_B [m]",
        {label: (MESHES, found) for label, found in ends.items()},
        {"Sze et al., 24 x 36": ([MESHES[0], MESHES[-1]], 2 * [references.value("-U_B")[-1]])},
    )
    yield Shape("An octant at 50 % and 100 % of the load, 16 x 16 Plate48", result, at=(0.5, 1.0), view=(1.0, 1.0, 0.7))


def octant(n: int, element: Element = "plate48", membrane_gauss: Literal[3] | None = None) -> lm.System:
    """One eighth of the cylinder, n x n elements; A is pulled along x, B is at the side, C at the side of the free end."""
    system = lm.System()
    section = lm.Laminate(lm.Isotropic(E=MODULUS, nu=POISSON, rho=1.0), thickness=THICKNESS)
    surface = lm.CylinderSurface(RADIUS, LENGTH / 2, angle=(0.0, np.pi / 2))
    shell = system.add(lm.Shell("shell", surface, (n, n), section, element=element, membrane_gauss=membrane_gauss))
    A, _, _ = shell.marker("A", 0.0, 0.0), shell.marker("B", surface.size[0], 0.0), shell.marker("C", *surface.size)
    system.add(lm.Symmetry("middle", shell.edge("y-"), "z"))
    system.add(lm.Symmetry("plane y", shell.edge("x-"), "y"))
    system.add(lm.Symmetry("plane x", shell.edge("x+"), "x"))
    system.add(lm.PointForce("pull", A, (FORCE / 4, 0.0, 0.0)))  # a quarter of it acts on this side of both planes
    return system


def displacements(result: Result, factors: Sequence[float]) -> Floats:
    """W_A outwards, -U_B and -U_C inwards [m] at each load factor, shape (n, 3)."""
    A, B, C = (result.history(f"{name}.position").sel(load_factor=list(factors), method="nearest").values for name in "ABC")
    return np.stack([A[:, 0] - RADIUS, RADIUS - B[:, 1], RADIUS - C[:, 1]], axis=1)


def at_full_load(n: int, element: Element, membrane_gauss: Literal[3] | None) -> float:
    """-U_B [m] at full load, by the arc length: the cylinder snaps at about half the load."""
    path = lm.equilibrium_path(octant(n, element, membrane_gauss))
    return RADIUS - float(path["B.position"].values[-1, 1])


def path_picture(references: References, factors: Sequence[float], paths: dict[str, Floats], shear: Floats) -> Curves:
    """The three displacements over the load, with the published points."""
    computed = {
        f"{name.replace('-', '−')}, {label}": ([0.0, *factors], [0.0, *values])
        for label, path in paths.items()
        for name, values in zip(NAMES, path.T, strict=True)
    }
    computed["W_A, Plate48, with shear"] = ([0.0, *factors], [0.0, *paths["Plate48"][:, 0] + shear])
    published = {f"{name.replace('-', '−')}, Sze et al.": references.points(name) for name in NAMES}
    return Curves("Points A, B and C, mesh 16 x 16", "Load factor [–]", "Displacement [m]", computed, published)
