"""Plates, strips and a column with closed-form solutions."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product
from typing import Literal

import numpy as np
from scipy.special import ellipk

import lamella as lm
from lamella.result import Result
from lamella.verification import Check, Curves, Evidence, Orders, References, Shape

slow = False

E, H = 70e9, 1e-3
SIDE, PRESSURE = 0.5, 1.0
LENGTH, WIDTH = 0.4, 0.02
PRECISE = lm.Newton(tolerance=1e-12, keep=0.0)


def run() -> Iterator[Evidence]:
    """Yield the checks and pictures of this case."""
    references = References.beside(__file__)
    yield from supported_plate(references)
    yield from strips(references)
    yield from column(references)


def supported_plate(references: References) -> Iterator[Evidence]:
    """Square plate, simply supported, uniform pressure: Navier's series, and the order of convergence."""
    exact_w, exact_energy = navier()
    errors = []
    for n in (4, 8, 16):
        result = square_plate(n, PRESSURE, "linear")
        w, energy = -float(result["centre.position"][2]), float(result["energy.strain"])
        errors.append((abs(w / exact_w - 1), abs(energy / exact_energy - 1)))
    yield references.check("simply supported plate: deflection, mesh 16 x 16", w / exact_w)
    yield references.check("simply supported plate: energy, mesh 16 x 16", energy / exact_energy)
    order = np.log2(np.array(errors[:-1]) / errors[1:])
    yield references.check("order of the deflection, 8 to 16 elements", order[1, 0])
    yield references.check("order of the energy, 8 to 16 elements", order[1, 1])
    series = {name: (SIDE / np.array([4, 8, 16]), np.array(errors)[:, k]) for k, name in enumerate(("deflection", "energy"))}
    yield Orders("Simply supported plate against Navier's series", "Element [m]", series, (4,))
    small = 1e-4
    exact_strain = -float(square_plate(8, small * PRESSURE, "exact")["centre.position"][2]) / small
    linear = -float(square_plate(8, PRESSURE, "linear")["centre.position"][2])
    yield references.check("simply supported plate: exact strains under a small load, over linear", exact_strain / linear)


def square_plate(n: int, pressure: float, strain: Literal["exact", "linear"]) -> Result:
    """Simply supported square plate of n x n elements under a uniform force per area along -z."""
    system = lm.System()
    section = lm.Laminate(lm.Isotropic(E=E, nu=0.3, rho=2700), thickness=H)
    plate = system.add(lm.Plate("plate", (SIDE, SIDE), (n, n), section, strain=strain))
    plate.marker("centre", SIDE / 2, SIDE / 2)
    for side in ("x-", "x+", "y-", "y+"):
        system.add(lm.EdgeSupport(side, plate.edge(side), axes="z"))
    system.add(lm.PointSupport("pin", plate.corner("x-y-"), axes="xy"))
    system.add(lm.PointSupport("line", plate.corner("x+y-"), axes="y"))
    system.add(lm.SurfaceForce("load", plate, (0.0, 0.0, -pressure)))
    return lm.equilibrium(system, newton=PRECISE)


def navier() -> tuple[float, float]:
    """Deflection of the centre [m] and strain energy [J]: w_mn = 16 q / (pi^6 D m n ((m/a)^2 + (n/a)^2)^2), m and n odd."""
    D = E * H**3 / (12 * (1 - 0.3**2))
    w = energy = 0.0
    for m, n in product(range(1, 400, 2), repeat=2):
        amplitude = 16 * PRESSURE * SIDE**4 / (np.pi**6 * D * m * n * (m * m + n * n) ** 2)
        w += amplitude * (-1) ** ((m + n - 2) // 2)
        energy += 0.5 * amplitude * PRESSURE * 4 * SIDE**2 / (np.pi**2 * m * n)
    return w, energy


def strips(references: References) -> Iterator[Check]:
    """Cantilever strip with nu = 0 under a small force and a small moment at its end."""
    D, force, moment = E * WIDTH * H**3 / 12, 1e-6, 1e-6
    bent_by_force = strip(force=force)
    yield references.check(
        "cantilever strip: deflection by a force over F L^3 / 3 EI", bent_by_force / (force * LENGTH**3 / (3 * D))
    )
    bent_by_moment = strip(moment=moment)
    yield references.check(
        "cantilever strip: deflection by a moment over M L^2 / 2 EI", bent_by_moment / (moment * LENGTH**2 / (2 * D))
    )


def strip(force: float = 0.0, moment: float = 0.0) -> float:
    """Height of the tip [m] of a clamped strip of 3 x 1 elements."""
    system, plate = clamped_strip(3)
    if force:
        system.add(lm.EdgeForce("force", plate.edge("x+"), (0.0, 0.0, force / WIDTH)))
    if moment:
        system.add(lm.EdgeMoment("moment", plate.edge("x+"), bending=-moment / WIDTH))
    return float(lm.equilibrium(system, newton=PRECISE)["tip.position"][2])


def clamped_strip(n: int) -> tuple[lm.System, lm.Plate]:
    """A strip with nu = 0, clamped at x = 0."""
    system = lm.System()
    section = lm.Laminate(lm.Isotropic(E=E, nu=0.0, rho=2700), thickness=H)
    plate = system.add(lm.Plate("strip", (LENGTH, WIDTH), (n, 1), section))
    plate.marker("tip", LENGTH, WIDTH / 2)
    system.add(lm.Clamp("root", plate.edge("x-")))
    return system, plate


def column(references: References) -> Iterator[Evidence]:
    """The strip as a column: Euler's load from the vanishing of the lowest frequency, and the post-buckling path."""
    euler = np.pi**2 * E * WIDTH * H**3 / 12 / (4 * LENGTH**2)
    shares, squares = (0.98, 1.02), []
    for share in shares:
        result = compressed(share * euler)
        lowest = lm.modes(result.model, 1, state=result.final).frequencies[0]
        squares.append(np.sign(lowest) * lowest**2)
    yield references.check("column: f^2 below the buckling load, over its size above", squares[0] / abs(squares[1]))
    root = shares[0] + (shares[1] - shares[0]) * squares[0] / (squares[0] - squares[1])
    yield references.check("column: load at which the lowest frequency vanishes, over Euler's load", root)
    paths = {}
    for degrees in (60, 100):
        path = buckled(load_over_euler(np.radians(degrees)) * euler)
        position = path["tip.position"].values[-1] / LENGTH
        yield references.check(f"column buckled to {degrees} degrees: height of the tip over L", position[0])
        yield references.check(f"column buckled to {degrees} degrees: sideways over L", position[2])
        factor, sideways = path["load_factor"].values, path["tip.position"].values[:, 2] / LENGTH
        paths[f"to {degrees}°"] = (sideways, factor * load_over_euler(np.radians(degrees)))
    ends = [references.value(f"column buckled to {degrees} degrees: sideways over L") for degrees in (60, 100)]
    loads = [load_over_euler(np.radians(degrees)) for degrees in (60, 100)]
    yield Curves("A column beyond buckling", "Sideways / L [–]", "Load / Euler's load [–]", paths, {"elastica": (ends, loads)})
    yield Shape("Buckled to 100 degrees", path, view=(0.3, 1.0, -0.3))


def compressed(load: float) -> Result:
    """The straight column under an axial end load [N]."""
    system, plate = clamped_strip(8)
    system.add(lm.EdgeForce("load", plate.edge("x+"), (-load / WIDTH, 0.0, 0.0)))
    return lm.equilibrium(system, newton=PRECISE)


def buckled(load: float) -> Result:
    """Path of a column beyond buckling, with 1e-4 of the load acting sideways."""
    system, plate = clamped_strip(16)
    system.add(lm.EdgeForce("load", plate.edge("x+"), (-load / WIDTH, 0.0, 1e-4 * load / WIDTH)))
    return lm.equilibrium_path(system, until=1.0)


def load_over_euler(angle: float) -> float:
    """Load over Euler's load for a tip angle [rad]: 4 K(k)^2 / pi^2 with k = sin(angle / 2), K the complete elliptic integral."""
    return float(4 * ellipk(np.sin(angle / 2) ** 2) ** 2 / np.pi**2)
