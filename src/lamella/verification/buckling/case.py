"""Buckling of columns and plates with closed forms, and the path that leaves the bifurcation of a column."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.optimize import root_scalar
from scipy.special import ellipe, ellipk

import lamella as lm
from lamella.body.shell_body import EdgeName
from lamella.verification import Check, References

slow = True

E, H = 70e9, 1e-3
LENGTH, WIDTH = 0.4, 0.02
EULER = np.pi**2 * E * WIDTH * H**3 / 12 / LENGTH**2
SIDE = 0.5
PLY = lm.Lamina(E1=140e9, E2=10e9, G12=5e9, nu12=0.3, rho=1600)
END = 1.5


def run() -> Iterator[Check]:
    """Yield the checks of this case."""
    references = References.beside(__file__)
    for ends in ("clamped and free", "pinned", "clamped"):
        factors = lm.buckling(column(ends, 10)[0], 2).factors
        yield references.check(f"column, ends {ends}: load over pi^2 EI / L^2", factors[0] / EULER)
        if ends == "pinned":
            yield references.check("column, ends pinned: second load over the first", factors[1] / factors[0])
    yield from plates(references)
    yield from beyond(references)


def column(ends: str, n: int) -> tuple[lm.System, lm.Plate]:
    """A strip with nu = 0 pushed along x by a force of 1 N at its end x = L."""
    system = lm.System()
    section = lm.Laminate(lm.Isotropic(E=E, nu=0.0, rho=2700), thickness=H)
    plate = system.add(lm.Plate("strip", (LENGTH, WIDTH), (n, 1), section))
    plate.marker("tip", LENGTH, WIDTH / 2)
    if ends == "pinned":
        system.add(lm.EdgeSupport("left", plate.edge("x-")))
        system.add(lm.EdgeSupport("right", plate.edge("x+"), axes="yz"))
    else:
        system.add(lm.Clamp("left", plate.edge("x-"), kind="restrained"))
    if ends == "clamped":  # the middle of a symmetric column: it may move along x and does not turn
        slider = system.add(lm.RigidBody("slider", mass=1.0, inertia=(1.0, 1.0, 1.0), position=(LENGTH, WIDTH / 2, 0.0)))
        ground = system.add(lm.Ground())
        rail = ground.marker("rail", LENGTH, WIDTH / 2, 0.0)
        system.add(lm.PrismaticJoint("guide", rail, slider.origin, axis=(1.0, 0.0, 0.0)))
        system.add(lm.FixedJoint("right", slider.origin, plate.edge("x+"), kind="restrained"))
        system.add(lm.PointForce("load", slider.origin, (-1.0, 0.0, 0.0)))
    else:
        system.add(lm.EdgeForce("load", plate.edge("x+"), (-1.0 / WIDTH, 0.0, 0.0)))
    return system, plate


def plates(references: References) -> Iterator[Check]:
    """Simply supported plates under uniform resultants N, in units of pi^2 D / b^2."""
    section = lm.Laminate(lm.Isotropic(E=E, nu=0.3, rho=2700), thickness=H)
    unit = np.pi**2 * section.stiffness[3, 3] / SIDE**2
    pressed = lm.buckling(plate(section, (-1.0, 0.0, 0.0)), 2).factors / unit
    yield references.check("square plate pressed along x: k", pressed[0])
    yield references.check("square plate pressed along x, two half waves: k", pressed[1])
    yield references.check(
        "square plate pressed along x and y: k", lm.buckling(plate(section, (-1.0, -1.0, 0.0)), 1).factors[0] / unit
    )
    sheared = np.sort(np.abs(lm.buckling(plate(section, (0.0, 0.0, 1.0), n=8), 2).factors)) / unit
    yield references.check("square plate in shear: k", sheared[0])
    yield references.check("square plate in shear: both signs alike", sheared[1] / sheared[0])
    ply = lm.Laminate(PLY, angles=(0,), thickness=H)
    D = ply.stiffness[3:, 3:]
    closed = min(D[0, 0] * m**2 + 2 * (D[0, 1] + 2 * D[2, 2]) + D[1, 1] / m**2 for m in range(1, 6)) * np.pi**2 / SIDE**2
    yield references.check(
        "orthotropic square plate pressed along x: N over the closed form",
        lm.buckling(plate(ply, (-1.0, 0.0, 0.0)), 1).factors[0] / closed,
    )


def plate(section: lm.Laminate, N: tuple[float, float, float], n: int = 6) -> lm.System:
    """A square plate on supports along z, its edges loaded by resultants (N_x, N_y, N_xy) [N/m]."""
    system = lm.System()
    sheet = system.add(lm.Plate("plate", (SIDE, SIDE), (n, n), section))
    N_x, N_y, N_xy = N
    loads: tuple[tuple[EdgeName, tuple[float, float, float]], ...] = (
        ("x-", (-N_x, -N_xy, 0.0)),
        ("x+", (N_x, N_xy, 0.0)),
        ("y-", (-N_xy, -N_y, 0.0)),
        ("y+", (N_xy, N_y, 0.0)),
    )
    for side, force in loads:
        edge = sheet.edge(side)
        system.add(lm.EdgeSupport(f"on {side}", edge, axes="z"))
        system.add(lm.EdgeForce(f"load {side}", edge, force))
    system.add(lm.PointSupport("pin", sheet.corner("x-y-"), axes="xy"))
    system.add(lm.PointSupport("line", sheet.corner("x+y-"), axes="y"))
    return system


def beyond(references: References) -> Iterator[Check]:
    """The clamped-free column: the bifurcation on its straight path, and the branch that leaves it, against the elastica."""
    system, _ = column("clamped and free", 32)
    load = EULER / 4
    straight = lm.equilibrium_path(system, until=END * load)
    points = straight.critical_points
    yield references.check("column, path: number of critical points", float(len(points)))
    yield references.check("column, path: bifurcation over Euler's load", points[0].factor / load)
    yield references.check("column, path: bifurcations, as 1", float(points[0].kind == "bifurcation"))
    height, sideways = elastica(END)
    for name, path in (
        ("branch", lm.equilibrium_path(system, until=END * load, branch=points[0].branch(0.02 * LENGTH))),
        ("imperfect", lm.equilibrium_path(system, until=END * load, imperfection=points[0].imperfection(1e-5 * LENGTH))),
    ):
        tip = path["tip.position"].values[-1] / LENGTH
        yield references.check(f"column, {name}: height of the tip less that of the elastica, over L", tip[0] - height)
        yield references.check(
            f"column, {name}: way of the tip sideways less that of the elastica, over L", abs(tip[2]) - sideways
        )
    near = lm.equilibrium_path(system, until=1.01 * load, branch=points[0].branch(0.02 * LENGTH))
    slope = near["tip.position"].values[-1][2] ** 2 / LENGTH**2 / 0.01
    yield references.check(
        "column, begin of the branch: (w / L)^2 per relative load, over the elastica", slope / (elastica(1.01)[1] ** 2 / 0.01)
    )


def elastica(ratio: float) -> tuple[float, float]:
    """Height and way sideways of the tip over L at a multiple of Euler's load: ratio = 4 K(k)^2 / pi^2."""
    m = float(root_scalar(lambda m: 4 * ellipk(m) ** 2 / np.pi**2 - ratio, bracket=(1e-9, 0.99)).root)
    return float(2 * ellipe(m) / ellipk(m) - 1), float(2 * np.sqrt(m) / ellipk(m))
