"""The belt pulled tight by two rollers, at rest without friction: exact strains and small deformation, by mesh.

A small-deformation element that lengthens by nothing in its own frame lengthens by half the square of its slopes there. Where the
curvature of the belt changes by dk, the slopes in the frame of an element of length a reach dk a / 2, so the belt is longer by

    e = 1/24 a^2 int dk^2 ds,      dk = 1/(R + h/2) - 1/R0 on the rollers of radius R,  -1/R0 in the strands

than it should be, and roller 2 comes to rest e / 2 too far away.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

import lamella as lm
from lamella.examples.swing import Numbers, rounded
from lamella.study.findings import Finding
from lamella.study.study import Study

Strain = Literal["exact", "corotational"]
MESHES: dict[Strain, tuple[int, ...]] = {"exact": (20, 40, 80, 160), "corotational": (20, 40, 80, 160, 240)}
FINEST = MESHES["exact"][-1]
PULL = 7000.0
"""Sum of the forces on both ends of roller 2 [N]."""
DEPTH = 0.5e-3
"""How deep the rollers touch the belt at the start, so that it is held between them [m]."""
STEPS = (30.0 / PULL, 1.0)
NEWTON = lm.Newton(tolerance=1e-6, max_iterations=40, keep=0.0, line_search="residual")


@dataclass(frozen=True)
class Tight:
    """One solution.

    Args:
        displacement: of roller 2 from where it touches the circular belt [m].
        stress: mean von Mises stress in the middle of the belt's width, on the side where it is larger [Pa].
        coordinates: number of coordinates of the system.
        steps: load steps.
        iterations: of Newton's method.
        seconds: of computing, without compilation.
    """

    displacement: float
    stress: float
    coordinates: int
    steps: int
    iterations: int
    seconds: float


def tightened(study: Study, elements: int, strain: Strain) -> Tight:
    """The belt and the rollers of the model, its mesh and strain model exchanged, under the full pull."""
    given = {item.name: item for item in study.read().system.declarations}
    belt, first, second = given["belt"], given["touch1"], given["touch2"]
    assert isinstance(belt, lm.Shell)
    assert isinstance(first, lm.CylinderContact)
    assert isinstance(second, lm.CylinderContact)
    length, width = belt.geometry.size
    belt = replace(belt, mesh=(elements, 1), strain=strain, markers={})
    x = length / (2 * np.pi) - second.radius - 0.5 * belt.laminate.h
    system = lm.System()
    system.add(belt)
    ground = system.add(lm.Ground())
    at = x + DEPTH
    roller = system.add(lm.RigidBody("roller2", mass=60.0, inertia=(1.0, 1.0, 1.0), position=(at, 0.0, 0.0)))
    system.add(lm.PrismaticJoint("slide2", ground.marker("guide2", at, 0.0, 0.0), roller.origin, axis=(1.0, 0.0, 0.0)))
    system.add(replace(first, shell=belt, at=ground.marker("axle1", -at, 0.0, 0.0), mu=0.0))
    system.add(replace(second, shell=belt, at=roller.origin, mu=0.0))
    system.add(lm.PointSupport("around", belt.marker("left", 0.5 * length, 0.5 * width), "yz"))
    system.add(lm.PointSupport("askew", belt.marker("top", 0.25 * length, 0.5 * width), "z"))
    system.add(lm.PointForce("pull", roller.origin, (PULL, 0.0, 0.0)))
    result = lm.equilibrium(system, steps=STEPS, newton=NEWTON)
    sample = result.plate("belt", len(result.frame_at) - 1, 8)
    stress = np.maximum(sample.von_mises(0, "bottom"), sample.von_mises(0, "top"))[4, :-1]
    spent = result.statistics
    return Tight(
        float(result["roller2.position"].sel(component="x")) - x,
        float(stress.mean()),
        len(result.model.q0),
        spent.steps,
        spent.newton_iterations,
        spent.seconds_run,
    )


def lengthening(length: float, radius: float, thickness: float, elements: int) -> float:
    """The e of the module's docstring [m]."""
    own, outer = 2 * np.pi / length, radius + 0.5 * thickness
    wrapped = 2 * np.pi * outer
    return (length / elements) ** 2 / 24 * (wrapped * (1 / outer - own) ** 2 + (length - wrapped) * own**2)


def all_meshes(study: Study) -> dict[tuple[Strain, int], Tight]:
    """Both strain models on all their meshes."""
    return {(strain, n): tightened(study, n, strain) for strain, meshes in MESHES.items() for n in meshes}


def errors(found: Mapping[tuple[Strain, int], Tight]) -> dict[str, dict[int, float]]:
    """Displacement of roller 2 less that with exact strains on their finest mesh [m], by strain model and number of elements."""
    best = found["exact", FINEST].displacement
    return {
        s: {n: found[s, n].displacement - best for n in meshes if n != FINEST or s != "exact"} for s, meshes in MESHES.items()
    }


def small_deformation(found: Mapping[tuple[Strain, int], Tight], length: float, radius: float, thickness: float) -> Finding:
    """How many elements of both strain models are needed for the displacement of roller 2."""
    off = errors(found)
    numbers: Numbers = {}
    for (strain, n), solution in found.items():
        numbers[f"{strain}, {n} elements: displacement of roller 2 [mm]"] = 1e3 * solution.displacement
        if n in off[strain]:
            numbers[f"{strain}, {n} elements: error of it [mm]"] = 1e3 * off[strain][n]
        if strain == "corotational":
            numbers[f"{strain}, {n} elements: error by theory [mm]"] = 5e2 * lengthening(length, radius, thickness, n)
        numbers[f"{strain}, {n} elements: mean von Mises stress [MPa]"] = 1e-6 * solution.stress
        numbers[f"{strain}, {n} elements: cost"] = (
            f"{solution.coordinates} coordinates, {solution.steps} load steps, "
            f"{solution.iterations} iterations, {solution.seconds:.1f} s"
        )
    small, wanted = off["corotational"], abs(off["exact"][40])
    numbers["corotational elements for the error of 40 exact ones"] = as_good(small, wanted)
    explained = all(abs(small[n] / (0.5 * lengthening(length, radius, thickness, n)) - 1.0) < 0.1 for n in (40, 80))
    return Finding(
        "Shells of small deformation (corotational) need a finer mesh than shells of absolute nodal coordinates.",
        explained and small[80] > 2.0 * wanted,
        rounded(numbers),
        "At rest, pulled by 7000 N without friction. A small-deformation element does not see the square of its slopes as "
        "stretching, so the belt is too long by a^2/24 times the integral of the squared change of curvature. On equal meshes "
        "stresses agree and times are alike.",
    )


def as_good(found: Mapping[int, float], wanted: float) -> float:
    """Elements for an error, by the power law of the two finest meshes."""
    (n, e), (finer, less) = sorted(found.items())[-2:]
    return finer * (wanted / less) ** (np.log(finer / n) / np.log(less / e))
