"""Plate36 beside Plate48: plates and strips with published or exact solutions, on the same meshes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Literal

import numpy as np

import lamella as lm
from lamella.roles import Floats
from lamella.verification import Check, References

slow = True

Element = Literal["plate36", "plate48"]
ELEMENTS: tuple[Element, ...] = ("plate48", "plate36")
ROLLED: tuple[tuple[Element, tuple[int, int]], ...] = (
    ("plate48", (16, 1)),
    ("plate36", (16, 1)),
    ("plate36", (64, 1)),
    ("plate36", (16, 2)),
)
SIDES = ("x-", "x+", "y-", "y+")
PRECISE = lm.Newton(tolerance=1e-12, keep=0.0)


def run() -> Iterator[Check]:
    """Yield the checks of this case."""
    references = References.beside(__file__)
    for support in ("simply supported", "clamped"):
        name = f"{support} square under a point load, plate36: deflection w D / (F L^2), mesh n x n"
        found = [deflection("plate36", int(n), support) for n in references.at(name)]
        yield from references.checks(name, found)
    coarse, fine = 8, 16
    for element in ELEMENTS:
        exact = np.array(references.value(f"free square, {element}, mesh 8 x 8: frequency factor"))
        found = {n: free_square(element, n) for n in (coarse, fine)}
        yield from references.checks(f"free square, {element}, mesh 8 x 8: frequency factor", found[coarse])
        orders = np.log2(np.abs(found[coarse] / exact - 1) / np.abs(found[fine] / exact - 1))
        yield references.check(f"free square, {element}: order of convergence of the first frequency", orders[0])
    for element in ELEMENTS:
        yield from references.checks(f"simply supported square, {element}, mesh 8 x 8: frequency factor", held_square(element, 8))
    for element in ELEMENTS:
        for quantity, value in zip(("deflection / (F L^3 / 3 EI)", "first frequency factor"), strip(element), strict=True):
            check = references.check(f"clamped strip, mesh 8 x 1: {quantity}", value)
            yield replace(check, quantity=f"{check.quantity}, {element}")
    circle = rolled("plate48", (64, 1))
    for element, mesh in ROLLED:
        error = np.abs(rolled(element, mesh) - circle).max()
        yield references.check(f"strip rolled up, {element}, mesh {mesh[0]} x {mesh[1]}: error of the tip over L", error)


def deflection(element: Element, n: int, support: str) -> float:
    """Deflection w D / (F L^2) under a force in the middle of a square, linear theory."""
    E, nu, h, L, F = 70e9, 0.3, 1e-3, 0.5, 1e-3
    system = lm.System()
    layup = lm.Laminate(lm.Isotropic(E=E, nu=nu, rho=2700), thickness=h)
    plate = system.add(lm.Plate("plate", (L, L), (n, n), layup, strain="linear", element=element))
    for side in SIDES:
        edge = plate.edge(side)
        system.add(lm.Clamp(side, edge) if support == "clamped" else lm.EdgeSupport(side, edge, axes="z"))
    if support != "clamped":
        system.add(lm.PointSupport("pin", plate.corner("x-y-"), axes="xy"))
        system.add(lm.PointSupport("line", plate.corner("x+y-"), axes="y"))
    system.add(lm.PointForce("force", plate.marker("middle", L / 2, L / 2), (0.0, 0.0, F)))
    w = float(lm.equilibrium(system, newton=PRECISE)["middle.position"][2])
    return w * E * h**3 / (12 * (1 - nu**2)) / (F * L**2)


def square(element: Element, n: int) -> tuple[lm.System, lm.Plate, float]:
    """A free square of 1 m and its unit of frequency (pi / L^2) sqrt(D / (rho h)) / 2 [Hz]."""
    E, nu, rho, h = 2e10, 0.3, 7800.0, 0.02
    system = lm.System()
    layup = lm.Laminate(lm.Isotropic(E=E, nu=nu, rho=rho), thickness=h)
    plate = system.add(lm.Plate("plate", (1.0, 1.0), (n, n), layup, element=element))
    return system, plate, 0.5 * np.pi * np.sqrt(E * h**3 / (12 * (1 - nu**2)) / (rho * h))


def free_square(element: Element, n: int) -> Floats:
    """The first three factors above the six rigid motions."""
    system, _, unit = square(element, n)
    return lm.modes(system, 9).frequencies[6:] / unit


def held_square(element: Element, n: int) -> Floats:
    """The first four factors; the supports leave three rigid motions in the plane."""
    system, plate, unit = square(element, n)
    for side in SIDES:
        system.add(lm.EdgeSupport(f"support {side}", plate.edge(side), axes="z"))
    return lm.modes(system, 7).frequencies[3:] / unit


def strip(element: Element) -> tuple[float, float]:
    """Tip deflection under an end force and first frequency of a clamped strip with nu = 0, in units of beam theory."""
    E, rho, h, L, b, F = 70e9, 2700.0, 1e-3, 0.4, 0.02, 1e-6
    system = lm.System()
    layup = lm.Laminate(lm.Isotropic(E=E, nu=0.0, rho=rho), thickness=h)
    plate = system.add(lm.Plate("strip", (L, b), (8, 1), layup, element=element))
    plate.marker("tip", L, b / 2)
    system.add(lm.Clamp("root", plate.edge("x-")))
    first = lm.modes(system, 1).frequencies[0]
    system.add(lm.EdgeForce("force", plate.edge("x+"), (0.0, 0.0, F / b)))
    w = float(lm.equilibrium(system, newton=PRECISE)["tip.position"][2])
    return w / (F * L**3 / (3 * E * b * h**3 / 12)), 2 * np.pi * first * L**2 / np.sqrt(E * h**2 / (12 * rho))


def rolled(element: Element, mesh: tuple[int, int]) -> Floats:
    """Tip positions over L of the strip of ``sze-roll-up`` in ten steps of its end moment, shape (11, 2)."""
    length, moment = 12.0, 50 * np.pi / 3
    system = lm.System()
    section = lm.Laminate(lm.Isotropic(E=1.2e6, nu=0.0, rho=1.0), thickness=0.1)
    plate = system.add(lm.Plate("strip", (length, 1.0), mesh, section, element=element))
    plate.marker("tip", length, 0.5)
    system.add(lm.Clamp("root", plate.edge("x-")))
    system.add(lm.EdgeMoment("moment", plate.edge("x+"), bending=-moment))
    factors = np.linspace(0.0, 1.0, 11)
    path = lm.equilibrium(system, steps=10).history("tip.position").sel(load_factor=factors, method="nearest")
    return path.values[:, [0, 2]] / length
