"""Shells on curved surfaces: rigid motion, the same shell by other parameters, and membrane states."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

import lamella as lm
from lamella.body.shell_body import EdgeName
from lamella.math.rotation import matrix_from_vector
from lamella.result import Result
from lamella.roles import Floats
from lamella.surface.base import Surface
from lamella.verification import Evidence, References, Shape

slow = True

E, NU, RHO = 70e9, 0.3, 2700.0
PRECISE = lm.Newton(tolerance=1e-12, keep=0.0)
CIRCLE = 2 * np.pi * np.arange(16) / 16


def section(thickness: float, nu: float = NU, angles: tuple[float, ...] = ()) -> lm.Laminate:
    """One isotropic ply, or plies of an orthotropic material at angles [deg]."""
    if not angles:
        return lm.Laminate(lm.Isotropic(E=E, nu=nu, rho=RHO), thickness=thickness)
    return lm.Laminate(lm.Lamina(E1=E, E2=E / 7, nu12=NU, G12=E / 14, rho=RHO), angles=angles, thickness=thickness)


def run() -> Iterator[Evidence]:
    """Yield the checks and pictures of this case."""
    references = References.beside(__file__)
    for name, surface in surfaces().items():
        force, energy = after_rigid_motion(surface)
        yield references.check(f"rigid motion, {name}: force over that of a dilation", force)
        yield references.check(f"rigid motion, {name}: energy over that of a dilation", energy)
    yield from other_parameters(references)
    yield from membrane_states(references)


# --- rigid motion ---------------------------------------------------------------------------------


def surfaces() -> dict[str, Surface]:
    """One surface of each kind."""
    return {
        "cylinder": lm.CylinderSurface(radius=0.7, length=1.2, angle=(0.2, 1.9)),
        "belt": lm.BeltSurface(length=2.5, width=0.8),
        "cone": lm.ConeSurface(radii=(0.5, 0.9), height=1.1, closed=True),
        "sphere": lm.SphereSurface(radius=1.3, latitude=(-0.3, 1.1), angle=(0.0, 2.0)),
        "annulus": lm.AnnulusSurface(radii=(0.6, 1.0), closed=True),
        "points": lm.PointSurface(
            tuple(tuple((np.cos(a) * (1 + 0.2 * z), np.sin(a), z) for a in CIRCLE) for z in (0.0, 0.4, 0.8, 1.2)), closed="x"
        ),
        "function": lm.FunctionSurface(twisted, lengths=(1.5, 1.0)),
    }


def twisted(x: Floats, y: Floats) -> Floats:
    """A skewed, twisted and wavy surface."""
    return np.stack([1.1 * x + 0.3 * y, 0.9 * y - 0.1 * x * y, 0.4 * x * y + 0.1 * np.sin(3 * x) * np.cos(2 * y)], axis=1)


def after_rigid_motion(surface: Surface) -> tuple[float, float]:
    """Largest force, and energy, of a shell turned and moved, over those when it is dilated by 1e-3."""
    system = lm.System()
    system.add(lm.Shell("shell", surface, (8, 4), section(0.01), rotation=(0.3, -0.5, 0.2), position=(1.0, 2.0, -1.0)))
    model = system.compile()
    (shell,) = model.forces
    turn = np.array([[0.36, 0.48, -0.8], [-0.8, 0.6, 0.0], [0.48, 0.64, 0.6]])  # by rational numbers
    moved = model.vectors(model.q0) @ turn.T
    moved[model.is_position] += (0.3, -2.0, 1.0)
    states = (moved.reshape(-1), 1.001 * model.q0)
    force = np.empty((2, len(shell.f_coords)))
    for f, q in zip(force, states, strict=True):
        shell.force(0.0, q, model.v0, f)
    largest, energies = np.abs(force).max(axis=1), [shell.energy(0.0, q) for q in states]
    return float(largest[0] / largest[1]), energies[0] / energies[1]


# --- the same shell by other parameters -----------------------------------------------------------


def other_parameters(references: References) -> Iterator[Evidence]:
    """Deflections of one shell given in several ways, as the distance between them over their size."""
    for n in (8, 16):
        u = displacement(deflected(lm.Shell("shell", SPHERE, (n, n), section(0.01))), (0.5, 1.0))
        for name, (surface, at) in same_sphere().items():
            other = displacement(deflected(lm.Shell("shell", surface, (n, n), section(0.01))), at)
            yield references.check(f"sphere {name}, mesh {n} x {n}: distance of the end", distance(other, u))
    layup, axis = section(0.02, angles=(0.0, 30.0)), (0.0, 0.0, 1.0)
    u = displacement(deflected(lm.Shell("shell", CYLINDER, (5, 4), layup, ply_direction=axis)), (1.0, 1.2))
    exchanged = lm.FunctionSurface(lambda x, y: np.stack([np.cos(1.2 - y), np.sin(1.2 - y), x], axis=1), (1.2, 1.0))
    other = deflected(lm.Shell("shell", exchanged, (4, 5), layup, ply_direction=axis), "x-")
    yield references.check("cylinder, x and y exchanged: distance of the end", distance(displacement(other, (1.2, 0.0)), u))
    turned = lm.Shell("shell", CYLINDER, (5, 4), layup, ply_direction=axis, rotation=TURN, position=(0.5, -1.0, 2.0))
    R = matrix_from_vector(np.array(TURN))
    other = displacement(deflected(turned, force=R @ FORCE), (1.0, 1.2))
    yield references.check("cylinder, turned in space: distance of the end", distance(R.T @ other, u))
    yield from flat_square(references, layup)


def flat_square(references: References, layup: lm.Laminate) -> Iterator[Evidence]:
    """A plate, and the same as a shell with parameters that are skew inside."""
    errors = []
    for n in (4, 8, 16):
        flat = displacement(deflected(lm.Plate("shell", (1.0, 1.0), (n, n), layup)), (1.0, 1.0))
        skewed = lm.Shell("shell", lm.FunctionSurface(skew, (0.8, 0.6)), (n, n), layup, ply_direction=(1.0, 0.0, 0.0))
        result = deflected(skewed)
        errors.append(distance(displacement(result, (0.8, 0.6)), flat))
        yield references.check(f"flat square, skew parameters, mesh {n} x {n}: distance of the end", errors[-1])
    yield references.check("flat square, skew parameters: order of the distance", float(np.log2(errors[1] / errors[2])))
    yield Shape("A flat square with skew parameters", result)


SPHERE = lm.SphereSurface(radius=1.0, latitude=(-0.4, 0.6), angle=(0.0, 1.0))
CYLINDER = lm.CylinderSurface(radius=1.0, length=1.2, angle=(0.2, 1.2))
TURN = (0.4, -0.7, 1.1)
FORCE = np.array((300.0, -200.0, -500.0))
"""Force per area of the deflected shells [Pa]."""


def same_sphere() -> dict[str, tuple[Surface, tuple[float, float]]]:
    """The part of the sphere by a function, by uneven parameters, and by a table of points, and where its end is."""

    def function(x: Floats, y: Floats) -> Floats:
        return np.stack([np.cos(y - 0.4) * np.cos(x), np.cos(y - 0.4) * np.sin(x), np.sin(y - 0.4)], axis=1)

    def uneven(x: Floats, y: Floats) -> Floats:
        return function(x + 0.03 * np.sin(2 * np.pi * x), 0.5 * y + 0.02 * np.sin(np.pi * y) * np.sin(np.pi * x))

    lines = np.linspace(0.0, 1.0, 17)
    table = lm.PointSurface(tuple(tuple(map(tuple, function(lines, np.full(17, y)))) for y in lines))
    l_x, l_y = table.size
    return {
        "by a function": (lm.FunctionSurface(function, (1.0, 1.0)), (0.5, 1.0)),
        "by uneven parameters": (lm.FunctionSurface(uneven, (1.0, 2.0)), (0.5, 2.0)),
        "by 17 x 17 points": (table, (0.5 * l_x, l_y)),
    }


def skew(x: Floats, y: Floats) -> Floats:
    """The unit square; inside it the parameters are neither orthogonal nor even."""
    x, y = x / 0.8, y / 0.6
    bump = np.sin(np.pi * x) * np.sin(np.pi * y)
    return np.stack([x + 0.08 * bump + 0.03 * np.sin(2 * np.pi * x), y - 0.06 * bump, np.zeros_like(x)], axis=1)


def deflected(shell: lm.Shell | lm.Plate, root: EdgeName = "y-", force: Floats = FORCE) -> Result:
    """A shell clamped at an edge under a force per area."""
    system = lm.System()
    system.add(shell)
    system.add(lm.Clamp("root", shell.edge(root), kind="restrained"))  # a slope held in full would act on other strains
    system.add(lm.SurfaceForce("load", shell, (force[0], force[1], force[2])))
    return lm.equilibrium(system, newton=PRECISE)


def displacement(result: Result, at: tuple[float, float]) -> Floats:
    """Of the point with the parameters ``at`` [m]."""
    model = result.model
    rows = model.plates[0].locate(at)
    return rows.at(model.vectors(result.final.q)) - rows.at(model.vectors(model.q0))


def distance(u: Floats, other: Floats) -> float:
    """Of two displacements, over the size of the second."""
    return float(np.linalg.norm(u - other) / np.linalg.norm(other))


# --- membrane states ------------------------------------------------------------------------------

PRESSURE, RADIUS, THIN = 1e5, 1.0, 1e-3


def membrane_states(references: References) -> Iterator[Evidence]:
    """Section forces where theory has no bending."""
    hoop, axial, exact = tube()
    yield references.check("cylinder under pressure: hoop force over p R times the axial stretch", hoop / exact)
    yield references.check("cylinder under pressure: axial force over the hoop force", axial / hoop)
    result, forces = balloon()
    yield references.check("sphere under pressure: force along x over p R/2 times the stretch", forces[0])
    yield references.check("sphere under pressure: force along y over p R/2 times the stretch", forces[1])
    result, forces = pulled_cone()
    yield references.check("cone under an axial force: meridional force over F/(2 pi r cos a)", forces[0])
    yield references.check("cone under an axial force: hoop force over the meridional one", forces[1] / forces[0])
    yield Shape("Cone under an axial force", result, field="displacement", scale=200.0)


def tube() -> tuple[float, float, float]:
    """A closed cylinder with free ends under pressure inside: mean hoop and axial force, and p R times the axial stretch."""
    system = lm.System()
    shell = system.add(lm.Shell("tube", lm.CylinderSurface(RADIUS, 0.5, closed=True), (32, 2), section(THIN)))
    for k, axes in enumerate(("yz", "xz", "yz")):  # as many as hold it, where the growing circle does not move that way
        system.add(lm.PointSupport(f"hold {k}", shell.marker(f"held {k}", k * np.pi / 2 * RADIUS, 0.0), axes))
    system.add(lm.Pressure("inside", shell, -PRESSURE))
    result = lm.equilibrium(system, newton=PRECISE)
    sample = result.plate("tube")
    hoop, axial = sample.section_forces()[:, :-1, :2].mean(axis=(0, 1))
    return float(hoop), float(axial), PRESSURE * RADIUS * np.sqrt(1 + 2 * sample.strains[..., 1].mean())


def balloon() -> tuple[Result, Floats]:
    """The sixth of a sphere that a cube's face sees, its edges held in their planes of symmetry: N_x, N_y over p R lambda/2."""
    quarter = np.pi / 4

    def face(x: Floats, y: Floats) -> Floats:
        r = np.stack([np.tan(x / RADIUS - quarter), np.tan(y / RADIUS - quarter), np.ones_like(x)], axis=1)
        return RADIUS * r / np.linalg.norm(r, axis=1, keepdims=True)

    system = lm.System()
    shell = system.add(
        lm.Shell("face", lm.FunctionSurface(face, (2 * quarter * RADIUS, 2 * quarter * RADIUS)), (12, 12), section(THIN))
    )
    held: tuple[tuple[EdgeName, str, tuple[int, int, int]], ...] = (
        ("x-", "x", (0, -1, 0)),
        ("x+", "x", (0, 1, 0)),
        ("y-", "y", (1, 0, 0)),
        ("y+", "y", (-1, 0, 0)),
    )
    for side, axis, turn in held:
        x, y, z = (quarter * k for k in turn)
        system.add(lm.EdgeSupport(side, shell.edge(side), axis, rotation=(x, y, z)))
    system.add(lm.Pressure("inside", shell, -PRESSURE))
    result = lm.equilibrium(system, newton=PRECISE)
    sample = result.plate("face", per_element=4)
    middle = len(sample.x) // 2
    stretch = np.linalg.norm(sample.r[middle, middle]) / RADIUS
    return result, sample.section_forces()[middle, middle, :2] / (0.5 * PRESSURE * RADIUS * stretch)


def pulled_cone() -> tuple[Result, Floats]:
    """A truncated cone, its lower edge held along the axis, under a force along it: mean N_s, N_phi at half its height over
    F / (2 pi r cos a).
    """
    radii, height, thickness, force = (1.0, 0.6), 1.5, 5e-3, 1e4
    slant = np.hypot(radii[1] - radii[0], height)
    system = lm.System()
    shell = system.add(lm.Shell("cone", lm.ConeSurface(radii, height, closed=True), (32, 24), section(thickness)))
    system.add(lm.EdgeSupport("foot", shell.edge("y-"), "xyz"))
    system.add(lm.EdgeForce("pull", shell.edge("y+"), (0.0, 0.0, force / (2 * np.pi * radii[1]))))
    result = lm.equilibrium(system, newton=PRECISE)
    sample = result.plate("cone")
    ring = sample.section_forces()[len(sample.y) // 2, :-1]
    exact = force / (2 * np.pi * 0.5 * (radii[0] + radii[1]) * height / slant)
    return result, ring.mean(axis=0)[[1, 0]] / exact
