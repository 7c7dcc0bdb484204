"""Hinged cylindrical roofs under a load at the middle: snap-through and snap-back, and the bifurcation of the whole roof."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.optimize import root_scalar

import lamella as lm
from lamella.body.base import Marker
from lamella.critical import CriticalPoint
from lamella.result import Result
from lamella.roles import Floats
from lamella.verification import Check, Curves, Evidence, References, Shape
from lamella.verification.diagram import distances

slow = True

RADIUS, LENGTH, HALF_ANGLE = 2.54, 0.508, 0.1
METAL = lm.Isotropic(E=3102.75e6, nu=0.3, rho=1000.0)
PLY = lm.Lamina(E1=3300e6, E2=1100e6, G12=660e6, nu12=0.25, rho=1000.0)
LAYUPS: dict[str, tuple[float, ...] | None] = {"isotropic": None, "[0/90/0]": (0, 90, 0), "[90/0/90]": (90, 0, 90)}
LAST = {12.7: 3000.0, 6.35: 1000.0}
"""Load at the end of the path [N] by the thickness [mm]."""
LOOPED = (6.35, "[0/90/0]")
"""The roof whose published point lies behind its limit point."""
CROWN, UPRIGHT = np.pi / 2, (np.pi / 2, 0.0, 0.0)
"""Angle of the crown on the cylinder about the body's z, and the rotation that lays this axis along -y, the crown at the top."""
Element = Literal["plate48", "plate36"]


def run() -> Iterator[Evidence]:
    """Yield the checks and pictures of this case."""
    references = References.beside(__file__)
    for h in LAST:
        results, published = {layup: path(h, layup) for layup in LAYUPS}, {}
        for layup, result in results.items():
            yield from compared(references, h, layup, result)
            published[f"{layup}, published"] = published_path(references, h, layup)
        lines = {layup: (sinking(result), load(result, h)) for layup, result in results.items()}
        yield Curves(f"h = {h} mm", "Displacement of C [mm]", "Load [N]", lines, published)
        shown = results["[90/0/90]"]
        at = [*(round(point.at) for point in shown.critical_points), len(shown.at) - 1]
        yield Shape(f"h = {h} mm, [90/0/90]: a quarter, at its limit points and at the end", shown, at)
    yield from converging(references)
    yield from whole_roof(references)


def path(h: float, layup: str) -> Result:
    """The path of a quarter on 8 x 8 elements to the last load."""
    return lm.equilibrium_path(quarter(h, layup, 8)[0], arc=lm.ArcLength(first=0.05, largest=0.002))


def compared(references: References, h: float, layup: str, result: Result) -> Iterator[Check]:
    """A path against the published point nearest to its first limit point, and against the balance of energy."""
    roof = f"h = {h}, {layup}"
    limits = limit_loads(result, h)
    yield references.check(f"{roof}: limit load", limits[0])
    name = f"{roof}: load at the published displacement"
    (published_w,) = references.at(name)
    begin = pressed(h, layup, 8, to=1.1 * published_w, steps=16)
    along = CubicSpline(sinking(begin), load(begin, h))
    yield from references.checks(name, [float(along(published_w))])
    if (h, layup) == LOOPED:
        name = f"{roof}: displacement at the published load"
        published_load = references.value(f"{roof}: limit load")
        root = root_scalar(lambda w: along(w) - published_load, bracket=(published_w - 1.5, published_w + 1.0)).root
        yield references.check(name, float(root))
    points = np.array(published_path(references, h, layup))
    curve = np.stack([sinking(result), load(result, h)])
    scale = np.abs(curve).max(axis=1, keepdims=True)
    yield references.check(f"{roof}: distance of the published path", distances(points / scale, curve / scale).max())
    yield references.check(f"{roof}: number of limit points", len(limits))
    yield references.check(
        f"{roof}: work of the load over strain energy", 1e-3 * work(result, h) / (4 * result["energy.strain"].values[-1])
    )
    w = sinking(result)
    yield references.check(f"{roof}: way by which C turns back", np.max(np.maximum.accumulate(w) - w))


def published_path(references: References, h: float, layup: str) -> tuple[list[float], list[float]]:
    """Displacements of C [mm] and loads [N] of the published table, as far as the path is computed."""
    w, P = references.points(f"h = {h}, {layup}: published path")
    kept = [k for k, value in enumerate(P) if value <= LAST[h]]
    return [w[k] for k in kept], [P[k] for k in kept]


def converging(references: References) -> Iterator[Check]:
    """Limit loads on several meshes over that on 16 x 16 elements."""
    for h, layup in ((12.7, "isotropic"), LOOPED):
        fine = first_limit(h, layup, 16, "plate48")
        for element in ("plate48", "plate36"):
            name = f"h = {h}, {layup}: limit load on n x n {element} over 16 x 16 plate48"
            yield from references.checks(name, [first_limit(h, layup, int(n), element) / fine for n in references.at(name)])


def whole_roof(references: References) -> Iterator[Evidence]:
    """The thin isotropic roof without planes of symmetry: it leaves its path before the limit point."""
    h, layup, arc = 6.35, "isotropic", lm.ArcLength(first=0.1, largest=0.003)
    half = first_limit(h, layup, 4, "plate48", to=14.0)
    system, middle = roof(h, layup, 8)
    perfect = lm.equilibrium_path(system, control=lm.DisplacementControl(middle, "z", to=-0.014, steps=14))
    bifurcation, limit = perfect.critical_points[:2]
    yield references.check("whole roof: limit load over that of the quarter", limit.factor * LAST[h] / half)
    yield references.check("whole roof: bifurcation over limit load", bifurcation.factor / limit.factor)
    yield references.check("whole roof: symmetric part of the bifurcation's shape", symmetric_part(perfect, bifurcation))
    falls = [bifurcation.factor - beside(system, bifurcation, amplitude) for amplitude in (1e-4, 2e-4)]
    yield references.check(
        "whole roof: power of the amplitude by which the load falls on the branch", np.log2(falls[1] / falls[0])
    )
    branch = lm.equilibrium_path(system, until=0.0, branch=bifurcation.branch(5e-4), arc=arc)
    results = {"perfect, symmetric": perfect, "branch": branch}
    name = "whole roof: limit load with an imperfection, over bifurcation"
    shares = references.at(name)
    for share in shares:
        crooked = bifurcation.imperfection(1e-3 * share * h)
        results[f"imperfection of {share:g} h"] = lm.equilibrium_path(system, until=0.7, imperfection=crooked, arc=arc)
    yield from references.checks(
        name, [results[f"imperfection of {a:g} h"].critical_points[0].factor / bifurcation.factor for a in shares]
    )
    lines = {label: (sinking(result), load(result, h)) for label, result in results.items()}
    yield Curves("Whole roof, h = 6.35 mm, isotropic", "Displacement of C [mm]", "Load [N]", lines)
    last = len(branch.at) - 1
    yield Shape("On the branch that leaves the bifurcation", branch, [0, last // 3, last])


def laminate(h: float, layup: str) -> lm.Laminate:
    """The section; 0 deg is the direction of the axis."""
    angles = LAYUPS[layup]
    return lm.Laminate(METAL, thickness=1e-3 * h) if angles is None else lm.Laminate(PLY, angles=angles, thickness=1e-3 * h)


def quarter(h: float, layup: str, n: int, element: Element = "plate48") -> tuple[lm.System, Marker]:
    """A quarter of the roof on n x n elements under a quarter of the last load, and its corner C, the middle of the roof."""
    surface = lm.CylinderSurface(RADIUS, LENGTH / 2, angle=(CROWN - HALF_ANGLE, CROWN))
    system = lm.System()
    shell = system.add(
        lm.Shell("roof", surface, (n, n), laminate(h, layup), rotation=UPRIGHT, ply_direction=(0, 0, 1), element=element)
    )
    middle = shell.marker("C", RADIUS * HALF_ANGLE, 0.0)
    system.add(lm.EdgeSupport("hinge", shell.edge("x-")))
    system.add(lm.Symmetry("crown", shell.edge("x+"), normal="x"))
    system.add(lm.Symmetry("middle", shell.edge("y-"), normal="y"))
    system.add(lm.PointForce("P", middle, (0.0, 0.0, -LAST[h] / 4)))
    return system, middle


def roof(h: float, layup: str, n: int) -> tuple[lm.System, Marker]:
    """The whole roof on n x n elements under the last load, and its middle C."""
    surface = lm.CylinderSurface(RADIUS, LENGTH, angle=(CROWN - HALF_ANGLE, CROWN + HALF_ANGLE))
    system = lm.System()
    shell = system.add(lm.Shell("roof", surface, (n, n), laminate(h, layup), rotation=UPRIGHT, ply_direction=(0, 0, 1)))
    middle = shell.marker("C", RADIUS * HALF_ANGLE, LENGTH / 2)
    system.add(lm.EdgeSupport("right", shell.edge("x-")))
    system.add(lm.EdgeSupport("left", shell.edge("x+")))
    system.add(lm.PointForce("P", middle, (0.0, 0.0, -LAST[h])))
    return system, middle


def pressed(h: float, layup: str, n: int, element: Element = "plate48", *, to: float, steps: int) -> Result:
    """The begin of the path of a quarter, by steps of the displacement of C [mm]."""
    system, middle = quarter(h, layup, n, element)
    return lm.equilibrium_path(system, control=lm.DisplacementControl(middle, "z", to=-1e-3 * to, steps=steps))


def first_limit(h: float, layup: str, n: int, element: Element, to: float = 12.0) -> float:
    """Load of the first limit point [N], which lies before the displacement ``to`` [mm] of C."""
    return limit_loads(pressed(h, layup, n, element, to=to, steps=6), h)[0]


def limit_loads(result: Result, h: float) -> list[float]:
    """Loads of the limit points [N]."""
    return [point.factor * LAST[h] for point in result.critical_points if point.kind == "limit point"]


def load(result: Result, h: float) -> Floats:
    """Load P along the path [N]."""
    return LAST[h] * result["load_factor"].values


def sinking(result: Result) -> Floats:
    """Downward displacement of C along the path [mm]."""
    return 1e3 * (RADIUS - result["C.position"].values[:, 2])


def work(result: Result, h: float) -> float:
    """Work of the load along the path [N mm]: the integral of P dw, from cubic splines over the length in the diagram."""
    P, w = load(result, h), sinking(result)
    length = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(P) / np.ptp(P), np.diff(w) / np.ptp(w)))])
    fine = np.linspace(0.0, length[-1], 50 * len(w))
    return float(np.trapezoid(CubicSpline(length, P)(fine) * CubicSpline(length, w)(fine, 1), fine))


def symmetric_part(result: Result, point: CriticalPoint) -> float:
    """Largest sum of the vertical displacements of a shape at two nodes that are mirror images, over its largest displacement."""
    mesh = result.model.plates[0]
    i, j = np.meshgrid(np.arange(mesh.nodes_x), np.arange(mesh.nodes_y))
    rows = np.array([mesh.vector(int(node), "r") for node in mesh.node(i, j).ravel()]).reshape(i.shape)
    vertical = point.shape.reshape(-1, 3)[rows, 2]
    return float(np.abs(vertical + vertical[:, ::-1]).max())


def beside(system: lm.System, point: CriticalPoint, amplitude: float) -> float:
    """Load factor of the branch at an amplitude [m] of the bifurcation's shape."""
    arc = lm.ArcLength(largest=1e-3, max_steps=1)
    found = lm.equilibrium_path(system, until=0.0, branch=point.branch(amplitude), arc=arc, on_failure="return")
    return float(found["load_factor"].values[1])
