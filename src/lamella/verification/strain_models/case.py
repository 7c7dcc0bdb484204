"""Small-deformation strain models against the exact one: loads that vanish, rigid rotation, large bending."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Literal

import numpy as np

import lamella as lm
from lamella.element.plate48.block import STRAIN_MODELS
from lamella.math.rotation import matrix_from_vector
from lamella.roles import Floats
from lamella.verification import Check, Evidence, Orders, References

slow = False

PLY = lm.Lamina(E1=181e9, E2=10.3e9, G12=7.17e9, nu12=0.28, rho=1600)
SECTIONS = {"symmetric laminate": ((0, 45, 45, 0), -0.04), "unsymmetric laminate": ((0, 45, -45, 90), -2e-3)}
"""Fibre angles, and the largest of three forces [N]."""
Strain = Literal["exact", "linear", "floating", "corotational"]
MODULUS, THICKNESS, WIDTH = 1e7, 0.02, 0.2
STRIP = lm.Laminate(lm.Isotropic(E=MODULUS, nu=0.0, rho=1000.0), thickness=THICKNESS)
D = MODULUS * THICKNESS**3 / 12
"""Section of strips of 1 m length, and its bending stiffness [N m]."""


def run() -> Iterator[Evidence]:
    """Yield the checks and pictures of this case."""
    references = References.beside(__file__)
    yield from small_loads(references)
    yield from rigid_rotation(references)
    yield from large_bending(references)


def small_loads(references: References) -> Iterator[Evidence]:
    """All models agree as the load vanishes, in a known order."""
    for section, (angles, largest) in SECTIONS.items():
        forces = (largest, largest / 2, largest / 4)
        exact, gaps = np.array([corner(angles, force, "exact") for force in forces]), {}
        for name in sorted(set(STRAIN_MODELS) - {"exact"}):
            small = np.array([corner(angles, force, name) for force in forces])
            gap = np.abs(exact - small)
            gaps[name] = (np.abs(forces), gap[:, 2] / np.abs(exact[:, 2]))
            frame = "" if name == "linear" else ", moving frames"
            difference = gap[2, 2] / abs(exact[2, 2])
            check = references.check(f"{section}: difference of z relative to z, smallest load{frame}", difference)
            yield replace(check, quantity=f"{check.quantity}, strain = {name}")
            check = references.check(f"{section}: order of the difference of z", np.log2(gap[1, 2] / gap[2, 2]))
            yield replace(check, quantity=f"{check.quantity}, strain = {name}")
            if name == "linear":
                bent = small[0] - 2 * small[1]
                yield references.check(f"{section}: linear model, proportional to the load", np.abs(bent / small[0, 2]).max())
        yield Orders(f"Models against exact strains, {section}", "Force [N]", gaps, y_label="Relative difference of z [–]")


def corner(angles: tuple[int, ...], force: float, strain: str) -> Floats:
    """Displacement of the loaded corner [m], shape (3,)."""
    system = lm.System()
    section = lm.Laminate(PLY, angles=angles, thickness=2e-3)
    plate = system.add(lm.Plate("plate", (0.6, 0.4), (4, 3), section, strain=strain))  # pyright: ignore[reportArgumentType]
    system.add(lm.Clamp("root", plate.edge("x-")))
    system.add(lm.PointForce("force", plate.marker("corner", 0.6, 0.4), (0.0, 0.0, force)))
    result = lm.equilibrium(system, newton=lm.Newton(tolerance=1e-13, keep=0.0))
    return result["corner.position"].values - [0.6, 0.4, 0.0]


def rigid_rotation(references: References) -> Iterator[Check]:
    """A turn about the plate's y axis by 2 rad, with a translation, strains the linear model alone."""
    angle, energies = 2.0, {}
    for strain in STRAIN_MODELS:
        system = lm.System()
        system.add(lm.Plate("strip", (1.0, WIDTH), (3, 2), STRIP, strain=strain))  # pyright: ignore[reportArgumentType]
        model = system.compile()
        q = model.q0.reshape(-1, 3) @ matrix_from_vector(np.array([0.0, angle, 0.0])).T
        q[model.is_position] += [3.0, -1.0, 2.0]
        energies[strain] = sum(block.energy(0.0, q.reshape(-1)) for block in model.forces)
    expected = 0.5 * MODULUS * THICKNESS * (1.0 - np.cos(angle)) ** 2 * WIDTH  # r_x = (cos, 0, -sin): eps_x = cos - 1
    yield references.check("rigid rotation: energy of the linear model by the closed form", energies["linear"] / expected)
    for strain in sorted(set(STRAIN_MODELS) - {"linear"}):
        check = references.check("rigid rotation: energy relative to the linear model's", energies[strain] / energies["linear"])
        yield replace(check, quantity=f"{check.quantity}, strain = {strain}")


def large_bending(references: References) -> Iterator[Evidence]:
    """Frames of elements follow large bending on finer meshes; one frame for the body does not see a strip being stretched."""
    exact = cantilever(32, "exact")
    tips = {n: cantilever(n, "corotational") for n in (8, 16, 32)}
    gaps = {n: np.linalg.norm(tip - exact) for n, tip in tips.items()}
    yield references.check("large bending: deflection, strain = corotational", -tips[32][2])
    yield references.check("large bending: shortening, strain = corotational", 1.0 - tips[32][0])
    yield references.check("large bending: order of the corotational model, 8 to 16 elements", np.log2(gaps[8] / gaps[16]))
    yield references.check("large bending: order of the corotational model, 16 to 32 elements", np.log2(gaps[16] / gaps[32]))
    error = {"tip": ([1 / n for n in gaps], list(gaps.values()))}
    yield Orders("Large bending, frames of elements", "Element [m]", error, y_label="Error [m]")
    linear = spanning(8, "linear")
    yield references.check("both ends clamped: floating model by the linear one", spanning(8, "floating") / linear)
    stiffened = spanning(32, "exact") / linear
    yield references.check("both ends clamped: exact strains by the linear model", stiffened)
    yield references.check(
        "both ends clamped: corotational model by exact strains", spanning(32, "corotational") / linear / stiffened
    )


def cantilever(n: int, strain: Strain) -> Floats:
    """Tip of a strip under the end force F = 4 D / L^2 [m], shape (3,)."""
    system = lm.System()
    strip = system.add(lm.Plate("strip", (1.0, WIDTH), (n, 1), STRIP, strain=strain))
    strip.marker("tip", 1.0, WIDTH / 2)
    system.add(lm.Clamp("root", strip.edge("x-")))
    system.add(lm.EdgeForce("force", strip.edge("x+"), (0.0, 0.0, -4.0 * D)))
    return lm.equilibrium(system, steps=8)["tip.position"].values


def spanning(n: int, strain: Strain) -> float:
    """Deflection of the middle of a strip that is clamped at both ends, under a force there [m]."""
    system = lm.System()
    strip = system.add(lm.Plate("strip", (1.0, WIDTH), (n, 1), STRIP, strain=strain))
    for side in ("x-", "x+"):
        system.add(lm.Clamp(f"end {side}", strip.edge(side)))
    system.add(lm.PointForce("force", strip.marker("middle", 0.5, WIDTH / 2), (0.0, 0.0, -4.0)))
    return float(lm.equilibrium(system, steps=4, newton=lm.Newton(tolerance=1e-12))["middle.position"].values[2])
