"""Slit annular plate lifted at one side of the slit, over the whole load path."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Literal

import numpy as np

import lamella as lm
from lamella.result import Result
from lamella.roles import Floats
from lamella.verification import Curves, Evidence, References, Shape

slow = True

RADII, THICKNESS, MODULUS, FORCE = (6.0, 10.0), 0.03, 21e6, 0.8
INNER, OUTER = "W_A, inner edge", "W_B, outer edge"
KINDS = {"Plate48": ("plate48", None), "Plate48, membrane_gauss 3": ("plate48", 3), "Plate36": ("plate36", None)}
MESHES = ((2, 12), (4, 24), (6, 36))

Element = Literal["plate48", "plate36"]


def run() -> Iterator[Evidence]:
    """Yield the checks and pictures of this case."""
    references = References.beside(__file__)
    factors = references.at(INNER)
    results = {"Plate48": loaded((6, 30), factors), "Plate36": loaded((6, 30), factors, "plate36")}
    paths = {label: lifts(result, factors) for label, result in results.items()}
    for name, values in zip((INNER, OUTER), paths["Plate48"].T, strict=True):
        yield from references.checks(name, values)
    for name, values in zip((INNER, OUTER), paths["Plate36"].T, strict=True):
        yield from references.checks(f"{name}, Plate36", values)
    ends = {label: [at_full_load(mesh, *kind) for mesh in MESHES] for label, kind in KINDS.items()}
    yield path_picture(references, factors, paths)
    across = [mesh[0] for mesh in MESHES]
    published = ([across[0], across[-1]], 2 * [references.value(OUTER)[-1]])
    yield Curves(
        "Point B at full load over the mesh",
        "Elements across the ring [–], six times as many around",
        "W_B [m]",
        {label: (across, found) for label, found in ends.items()},
        {"Sze et al., 10 x 80": published},
    )
    yield Shape("At 10 % and 100 % of the load, 6 x 30 Plate48", results["Plate48"], at=(0.1, 1.0), view=(0.5, -1.0, 0.5))


def loaded(
    mesh: tuple[int, int], factors: Sequence[float], element: Element = "plate48", membrane_gauss: Literal[3] | None = None
) -> Result:
    """Equilibria of the ring at each load factor; the slit lies along the x axis, its far side is lifted."""
    system = lm.System()
    section = lm.Laminate(lm.Isotropic(E=MODULUS, nu=0.0, rho=1.0), thickness=THICKNESS)
    surface = lm.AnnulusSurface(RADII)
    ring = system.add(lm.Shell("ring", surface, mesh, section, element=element, membrane_gauss=membrane_gauss))
    ring.marker("A", 0.0, surface.size[1])
    ring.marker("B", *surface.size)
    system.add(lm.Clamp("clamp", ring.edge("y-")))
    system.add(lm.EdgeForce("lift", ring.edge("y+"), (0.0, 0.0, FORCE)))
    return lm.equilibrium(system, steps=list(factors))


def lifts(result: Result, factors: Sequence[float]) -> Floats:
    """W_A and W_B [m] at each load factor, shape (n, 2)."""
    A, B = (result.history(f"{name}.position").sel(load_factor=list(factors), method="nearest").values for name in "AB")
    return np.stack([A[:, 2], B[:, 2]], axis=1)


def at_full_load(mesh: tuple[int, int], element: Element, membrane_gauss: Literal[3] | None) -> float:
    """W_B [m] at full load, reached in few steps."""
    return float(lifts(loaded(mesh, (0.02, 0.1, 0.3, 0.6, 1.0), element, membrane_gauss), [1.0])[0, 1])


def path_picture(references: References, factors: Sequence[float], paths: dict[str, Floats]) -> Curves:
    """Both lifts over the load, with the published points."""
    computed = {
        f"{name}, {label}": ([0.0, *factors], [0.0, *values])
        for label, path in paths.items()
        for name, values in zip((INNER, OUTER), path.T, strict=True)
    }
    published = {f"{name}, Sze et al.": references.points(name) for name in (INNER, OUTER)}
    return Curves("Lift of the slit's free side, mesh 6 x 30", "Load factor [–]", "Lift [m]", computed, published)
