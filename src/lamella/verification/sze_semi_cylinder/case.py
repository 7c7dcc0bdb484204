"""Semi-cylinder clamped at one end, pinched at the crown of the other, isotropic and of three plies, over the whole load path."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Literal

import numpy as np

import lamella as lm
from lamella.result import Result
from lamella.roles import Floats
from lamella.verification import Check, Curves, Evidence, References, Shape
from lamella.verification.cylinder_series import PinchedCylinder
from lamella.verification.diagram import distances

slow = True

RADIUS, LENGTH, THICKNESS, MODULUS, POISSON, FORCE = 1.016, 3.048, 0.03, 2.0685e7, 0.3, 2000.0
METAL = lm.Isotropic(E=MODULUS, nu=POISSON, rho=1.0)
PLY = lm.Lamina(E1=2.0685e7, E2=0.517125e7, G12=0.7956e7, nu12=0.3, rho=1.0)
ISOTROPIC = lm.Laminate(METAL, thickness=THICKNESS)
PLIES = {
    "[0/90/0]": lm.Laminate(PLY, angles=(0, 90, 0), thickness=THICKNESS),
    "[90/0/90]": lm.Laminate(PLY, angles=(90, 0, 90), thickness=THICKNESS),
}
"""Sections of three equal plies; 0 deg is the direction of the axis."""
PARTS = ("-W_A, load factors up to 0.2", "-W_A, steep part of the path", "-W_A, from 0.4 to full load")
BENDING = 0.2
"""Load factor up to which the crown bends before it dents."""
MESHES = (6, 8, 10)
BEGIN = (1e-4, 0.02)
"""Load factors before the published ones; at the first the theory is linear to 1e-4."""

Element = Literal["plate48", "plate36"]
Points = tuple[list[float], list[float]]


def run() -> Iterator[Evidence]:
    """Yield the checks and pictures of this case."""
    references = References.beside(__file__)
    isotropic: Points = (
        [factor for part in PARTS for factor in references.at(part)],
        [value for part in PARTS for value in references.value(part)],
    )
    factors = [*BEGIN, *isotropic[0]]
    result, other = loaded(16, factors), loaded(24, factors, "plate36")
    linear = PinchedCylinder(RADIUS, LENGTH, THICKNESS, MODULUS, POISSON, "clamped").deflection(160)
    small = deflections(result, BEGIN[:1])[0] / (BEGIN[0] * FORCE)
    yield references.check("-W_A under a small load over that of linear theory", small / linear)
    for part in PARTS:
        yield from references.checks(part, deflections(result, references.at(part)))
    yield from beside(references, "Plate48, 16 x 16", isotropic, result)
    yield from beside(references, "Plate36, 24 x 24", isotropic, other)
    lines = {"Plate48, 16 x 16": path(result), "Plate36, 24 x 24": path(other)}
    yield Curves("Point A, isotropic", "Load factor [–]", "−W_A [m]", lines, {"Sze et al., 40 x 40": isotropic})
    yield from laminated(references)
    finest: dict[Element, tuple[int, Result]] = {"plate48": (16, result), "plate36": (24, other)}
    ends = {
        element: ([*MESHES, n], [*(at_half_load(mesh, element) for mesh in MESHES), float(deflections(fine, [0.5])[0])])
        for element, (n, fine) in finest.items()
    }
    half = isotropic[1][isotropic[0].index(0.5)]
    yield Curves(
        "Point A at half the load over the mesh, isotropic",
        "Elements along each side of the half [–]",
        "−W_A [m]",
        ends,
        {"Sze et al., 40 x 40": ([MESHES[0], 24], [half, half])},
    )
    yield Shape("One half at 35 % and 100 % of the load, 16 x 16 Plate48", result, at=(0.35, 1.0), view=(0.8, 1.0, 0.6))


def laminated(references: References) -> Iterator[Evidence]:
    """The two laminates against their published paths."""
    lines, points = {}, {}
    for layup, section in PLIES.items():
        published = references.points(f"{layup}: published path")
        result = loaded(14, [*BEGIN, *published[0]], section=section)
        yield from beside(references, layup, published, result)
        lines[f"{layup}, 14 x 14"], points[f"{layup}, Sze et al., 40 x 40"] = path(result), published
    yield Curves("Point A, three plies, Plate48", "Load factor [–]", "−W_A [m]", lines, points)


def beside(references: References, label: str, published: Points, result: Result) -> Iterator[Check]:
    """Largest distance of published points from a path in the diagram of logarithms, while the crown bends and beyond."""
    at = np.array(published[0])
    curve = np.array(path(result))[:, 1:]  # without the origin
    found = distances(np.log(published), np.log(curve))
    for range_, chosen in (("up to 0.2", at <= BENDING), ("beyond 0.2", at > BENDING)):
        yield references.check(f"{label}: distance of the published path, load factors {range_}", found[chosen].max())


def loaded(n: int, factors: Sequence[float], element: Element = "plate48", section: lm.Laminate = ISOTROPIC) -> Result:
    """Equilibria of one half at each load factor: the axis is z, the crown along x, the straight edge in the plane x = 0."""
    system = lm.System()
    surface = lm.CylinderSurface(RADIUS, LENGTH, angle=(0.0, np.pi / 2))
    shell = system.add(lm.Shell("shell", surface, (n, n), section, element=element, ply_direction=(0, 0, 1)))
    A = shell.marker("A", 0.0, LENGTH)
    system.add(lm.Clamp("clamp", shell.edge("y-"), kind="restrained"))
    system.add(lm.Symmetry("crown", shell.edge("x-"), "y"))
    system.add(lm.Symmetry("base", shell.edge("x+"), "x"))
    system.add(lm.PointForce("pinch", A, (-FORCE / 2, 0.0, 0.0)))  # half of it acts on this side of the plane
    return lm.equilibrium(system, steps=list(factors))


def path(result: Result) -> Points:
    """Load factors and -W_A [m] of all equilibria, from the unloaded one on."""
    factors = [float(factor) for factor in result.at]
    return factors, list(deflections(result, factors))


def deflections(result: Result, factors: Sequence[float]) -> Floats:
    """-W_A [m] at each load factor, shape (n,)."""
    return RADIUS - result.history("A.position").sel(load_factor=list(factors), method="nearest").values[:, 0]


def at_half_load(n: int, element: Element) -> float:
    """-W_A [m] at half the load, reached in few steps."""
    return float(deflections(loaded(n, (0.1, 0.2, 0.3, 0.4, 0.5), element), [0.5])[0])
