"""What a shell's reference and section bring with them: bent and stretched references, tapered thickness, ply directions."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import ArrayLike

import lamella as lm
from lamella.result import Result
from lamella.roles import Floats
from lamella.verification import Curves, Evidence, References, Shape

slow = True

E, NU, RHO, H = 70e9, 0.3, 2700.0, 1e-3
PRECISE = lm.Newton(tolerance=1e-12, keep=0.0)
LENGTH, WIDTH = 1.2, 0.2


def section(nu: float = 0.0, thickness: float = H) -> lm.Laminate:
    """One isotropic ply."""
    return lm.Laminate(lm.Isotropic(E=E, nu=nu, rho=RHO), thickness=thickness)


def run() -> Iterator[Evidence]:
    """Yield the checks and pictures of this case."""
    references = References.beside(__file__)
    yield from bent_sheets(references)
    yield from stretched_sheets(references)
    yield from tapered(references)
    yield from ply_directions(references)


# --- a flat sheet that was bent -------------------------------------------------------------------


def flat(length: float) -> lm.FunctionSurface:
    """A flat strip."""
    return lm.FunctionSurface(lambda x, y: np.stack([x, y, np.zeros_like(x)], axis=1), (length, WIDTH))


def bent_sheets(references: References) -> Iterator[Evidence]:
    """A strip closed to a circle keeps its energy; a piece that is let go becomes flat again."""
    radius = LENGTH / (2 * np.pi)
    system = lm.System()
    hoop = lm.Shell("hoop", lm.BeltSurface(LENGTH, WIDTH), (32, 2), section(NU), stress_free=flat(LENGTH))
    system.add(hoop)
    model = system.compile()
    (shell,) = model.forces
    stiffness = E * H**3 / (12 * (1 - NU**2))
    yield references.check(
        "strip closed to a circle: energy over D L b/(2 R^2)",
        shell.energy(0.0, model.q0) / (0.5 * stiffness / radius**2 * LENGTH * WIDTH),
    )
    moments = model.plates[0].sample(model.q0).section_forces()[..., 3:5].mean(axis=(0, 1)) * radius / stiffness
    yield references.check("strip closed to a circle: moment around over D/R", moments[0])
    yield references.check("strip closed to a circle: moment across over D/R", moments[1])
    arc = lm.CylinderSurface(radius, WIDTH, angle=(0.0, 1.0))
    system = lm.System()
    leaf = system.add(lm.Shell("leaf", arc, (8, 1), section(), stress_free=flat(radius)))
    leaf.marker("end", radius, 0.0)
    system.add(lm.Clamp("root", leaf.edge("x-")))
    sprung = lm.equilibrium(system, newton=lm.Newton(tolerance=1e-12, keep=0.0, line_search=True))
    end = np.array([radius, radius, 0.0])  # straight ahead from the root, which looks along y
    yield references.check(
        "piece let go: distance of the end from the flat strip's", float(np.linalg.norm(sprung["end.position"].values - end))
    )
    yield references.check(
        "piece let go: energy left over that at the start",
        sprung.model.forces[0].energy(0.0, sprung.final.q) / sprung.model.forces[0].energy(0.0, sprung.model.q0),
    )


# --- prestrain ------------------------------------------------------------------------------------


def stretched_sheets(references: References) -> Iterator[Evidence]:
    """Frequencies of a strip and of a rectangle that are stretched at rest, simply supported."""
    counts, strains = np.arange(1, 4), (0.0, 1e-6, 1e-5, 1e-4, 1e-3)
    found = []
    for strain in strains:
        system = lm.System()
        plate = system.add(lm.Plate("strip", (LENGTH, WIDTH / 10), (12, 1), section(), prestrain=(strain, 0.0, 0.0)))
        for side in ("x-", "x+"):
            system.add(lm.EdgeSupport(side, plate.edge(side)))
        found.append(beam_modes(lm.modes(system, 10))[:3])
        yield from references.checks(
            f"strip stretched by {strain:g}: frequency over the beam's", found[-1] / string(strain, counts)
        )
    many = np.geomspace(1e-6, 1e-3, 31)
    yield Curves(
        "A stretched strip",
        "Prestrain [–]",
        "Frequency [Hz]",
        {f"closed form, mode {n}": (many, [string(strain, n) for strain in many]) for n in counts},
        {f"lamella, mode {n}": (strains[1:], [f[n - 1] for f in found[1:]]) for n in counts},
        log="xy",
    )
    sides, strain = np.array([1.0, 0.7]), 2e-4
    system = lm.System()
    plate = system.add(lm.Plate("membrane", (1.0, 0.7), (8, 6), section(NU), prestrain=(strain, strain, 0.0)))
    for side in ("x-", "x+", "y-", "y+"):
        system.add(lm.EdgeSupport(side, plate.edge(side)))
    k2 = np.sort([np.pi**2 * np.sum((np.array(mn) / sides) ** 2) for mn in np.ndindex(6, 6) if min(mn) > 0])[:4]
    force = E * H * strain / (1 - NU)
    exact = np.sqrt((E * H**3 / (12 * (1 - NU**2)) * k2**2 + force * k2) / (RHO * H)) / (2 * np.pi)
    yield from references.checks("stretched rectangle: frequency over the closed form", lm.modes(system, 4).frequencies / exact)


def string(strain: float, n: ArrayLike) -> Floats:
    """Frequencies [Hz] of the simply supported beam under the tension E A strain."""
    k = np.asarray(n) * np.pi / LENGTH
    return k * np.sqrt(E * strain / RHO + E * H**2 / (12 * RHO) * k**2) / (2 * np.pi)


def beam_modes(modes: lm.Modes) -> Floats:
    """Frequencies of the modes whose long edges move up and down alike; others twist the strip or bend it in its plane."""
    mesh, alike = modes.model.plates[0], []
    for frequency, shape in zip(modes.frequencies, modes.shapes.T, strict=True):
        lower, upper = (modes.model.vectors(shape)[[mesh.vector(int(k), "r") for k in mesh.edge_nodes(s)]] for s in ("y-", "y+"))
        whole = np.linalg.norm(lower) + np.linalg.norm(upper)
        if np.linalg.norm(lower[:, 2] + upper[:, 2]) > 0.9 * whole:
            alike.append(frequency)
    return np.array(alike)


# --- tapered thickness ----------------------------------------------------------------------------


def tapered(references: References) -> Iterator[Evidence]:
    """A cantilever whose thickness falls from element to element, under a force at its end."""
    n, force = 10, 1e-5
    factors = np.linspace(1.4, 0.5, n)
    system = lm.System()
    plate = system.add(lm.Plate("leaf", (LENGTH, WIDTH), (n, 1), section(), thickness_factors=(tuple(factors),)))
    for k in range(1, n + 1):
        plate.marker(f"x{k}", k * LENGTH / n, 0.0)
    system.add(lm.Clamp("root", plate.edge("x-")))
    system.add(lm.EdgeForce("load", plate.edge("x+"), (0.0, 0.0, force / WIDTH)))
    result = lm.equilibrium(system, newton=PRECISE)
    x = np.linspace(0.0, LENGTH, n + 1)
    found = [float(result[f"x{k}.position"].values[2]) for k in range(1, n + 1)]
    exact = bent_by(force, x, factors)[1:]
    yield references.check("tapered cantilever: deflection of the end over the beam's", found[-1] / exact[-1])
    yield references.check("tapered cantilever: deflection of the middle over the beam's", found[n // 2 - 1] / exact[n // 2 - 1])
    weight = result.model.plates[0]
    uniform = np.zeros(result.model.n_q)
    uniform[2::3] = weight.is_position
    mass = RHO * WIDTH * H * float(factors.mean()) * LENGTH
    yield references.check("tapered cantilever: mass", float(uniform @ (result.model.mass @ uniform)) / mass)
    stress = result.plate("leaf").stress(0, "top")[..., 0].mean(axis=0)
    at = result.plate("leaf").x
    inside = np.arange(2, len(at), 4)  # middles of elements
    moment = -force * (LENGTH - at[inside])
    exact_stress = moment * 6 / (WIDTH * (H * factors) ** 2)
    yield references.check(
        "tapered cantilever: stress on the top, largest error over the largest",
        float(np.abs(stress[inside] - exact_stress).max() / np.abs(exact_stress).max()),
    )
    yield Curves(
        "Tapered cantilever", "Length [m]", "Deflection [m]", {"lamella": (x[1:], found)}, {"beam, integrated": (x[1:], exact)}
    )


def bent_by(force: float, x: Floats, factors: Floats) -> Floats:
    """Deflection w at the ends of pieces of constant thickness: w'' = F (L - x)/(E I), integrated piece by piece."""
    w, slope = [0.0], 0.0
    for a, b, factor in zip(x[:-1], x[1:], factors, strict=True):
        rigidity, s = E * WIDTH * (H * factor) ** 3 / 12, b - a
        w.append(w[-1] + slope * s + force / rigidity * ((LENGTH - a) * s**2 / 2 - s**3 / 6))
        slope += force / rigidity * ((LENGTH - a) * s - s**2 / 2)
    return np.array(w)


# --- ply directions -------------------------------------------------------------------------------


def ply_directions(references: References) -> Iterator[Evidence]:
    """A tube of plies at +-45 deg, by angles to the circumference and by angles to its axis, under pressure and pull."""
    around = wound((45.0, -45.0), None)
    along = wound((-45.0, -135.0), (0.0, 0.0, 1.0))
    u, other = (r.final.q - r.model.q0 for r in (around, along))
    yield references.check(
        "tube of plies at 45 deg, two ways: distance of the coordinates", float(np.linalg.norm(other - u) / np.linalg.norm(u))
    )
    wrong = wound((45.0, -45.0), (0.0, 0.0, 1.0))
    v = wrong.final.q - wrong.model.q0
    yield references.check(
        "the same angles from the other direction: distance of the coordinates", float(np.linalg.norm(v - u) / np.linalg.norm(u))
    )
    yield Shape("Tube of two plies at 45 deg under pressure and pull", around, scale=50.0)


def wound(angles: tuple[float, ...], direction: tuple[float, float, float] | None) -> Result:
    """A tube of two plies, clamped at one end."""
    ply = lm.Lamina(E1=140e9, E2=10e9, nu12=0.3, G12=5e9, rho=1600.0)
    system = lm.System()
    layup = lm.Laminate(ply, angles=angles, thickness=2e-3)
    shell = system.add(lm.Shell("tube", lm.CylinderSurface(0.3, 0.8, closed=True), (16, 4), layup, ply_direction=direction))
    system.add(lm.Clamp("root", shell.edge("y-")))
    system.add(lm.Pressure("inside", shell, -2e4))
    system.add(lm.EdgeForce("pull", shell.edge("y+"), (0.0, 0.0, 1e4)))
    return lm.equilibrium(system, newton=PRECISE)
