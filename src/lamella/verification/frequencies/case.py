"""Natural frequencies of laminated and isotropic plates."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

import lamella as lm
from lamella.verification import Curves, Evidence, References, Shape

slow = True

CORNERS = ("x-y-", "x+y-", "x+y+", "x-y+")
SIDES = ("x-", "x+", "y-", "y+")


def laminated(support: str) -> lm.System:
    """The [0/90/0] plate of 1.5 m x 2 m, clamped along x = 0 or pinned at its corners."""
    ply = lm.Lamina(E1=181e9, E2=103e9, G12=7.7e9, nu12=0.28, rho=1560)
    layup = lm.Laminate(ply, angles=(0, 90, 0), thickness=1.5e-3)
    system = lm.System()
    plate = system.add(lm.Plate("plate", size=(1.5, 2.0), mesh=(12, 12), laminate=layup))
    if support == "clamped":
        system.add(lm.Clamp("root", plate.edge("x-")))
    else:
        for corner in CORNERS:
            system.add(lm.PointSupport(f"pin {corner}", plate.corner(corner)))
    return system


def square(mesh: int, held: bool) -> tuple[lm.System, float]:
    """An isotropic square of 1 m, free or simply supported, and its unit of frequency (pi / L^2) sqrt(D / (rho h)) / 2 [Hz]."""
    E, nu, rho, h = 2e10, 0.3, 7800.0, 0.02
    system = lm.System()
    layup = lm.Laminate(lm.Isotropic(E=E, nu=nu, rho=rho), thickness=h)
    plate = system.add(lm.Plate("plate", size=(1.0, 1.0), mesh=(mesh, mesh), laminate=layup))
    if held:
        for side in SIDES:
            system.add(lm.EdgeSupport(f"support {side}", plate.edge(side), axes="z"))
    return system, 0.5 * np.pi * np.sqrt(E * h**3 / (12 * (1 - nu**2)) / (rho * h))


def run() -> Iterator[Evidence]:
    """Yield the checks and pictures of this case."""
    references = References.beside(__file__)
    modes = {
        "cantilever laminate": lm.modes(laminated("clamped"), 10),
        "corner-pinned laminate": lm.modes(laminated("pinned"), 10),
    }
    for name, found in modes.items():
        yield from references.checks(name, found.frequencies)
    free, unit = square(12, held=False)
    yield from references.checks("free square", lm.modes(free, 9).frequencies[6:] / unit)
    held, unit = square(8, held=True)
    in_plane = 3  # the supports leave translations in the plane and the rotation about z
    yield from references.checks("simply supported square", lm.modes(held, 9).frequencies[in_plane:] / unit)
    computed = {name: (range(1, 11), found.frequencies) for name, found in modes.items()}
    linear = {f"{name}, 48 x 48": references.points(name) for name in modes}
    yield Curves("Natural frequencies of the laminates", "Mode [–]", "Frequency [Hz]", computed, linear, joined=False)
    for name, found in modes.items():
        yield Shape(f"Modes of the {name}", found)
