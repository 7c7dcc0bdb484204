"""A belt stretched around two rollers, at rest."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

import lamella as lm
from lamella.contact.block import ContactBlock
from lamella.material.recovery import Surface
from lamella.result import Result
from lamella.roles import Floats
from lamella.verification import Check, Curves, Evidence, Shape
from lamella.verification.belt import E_X, E_Y, G_XY, LENGTH, RADIUS, RHO, WIDTH
from lamella.verification.belt_beam import BeltBeam, belt_beam

slow = True

R, K, NU, ENDS = 0.15, 1e10, 0.3, 7000.0
TENSION = 0.5 * ENDS
N_AROUND, N_POINTS = 80, 7
DIP = 1e-4  # m, by which the rollers touch the circle at the start: they hold it before there is any load
ROW = LENGTH / (N_AROUND * N_POINTS)


@dataclass(frozen=True)
class Belt:
    """A belt of the thickness h, with the moduli of ``verification/belt.py`` times a factor, its beam, and its equilibrium."""

    h: float
    factor: float

    @property
    def Q_11(self) -> float:
        """Stiffness along a wide belt, which cannot bend across [Pa]."""
        return self.factor * E_X / (1.0 - NU**2 * E_Y / E_X)

    @property
    def EA(self) -> float:
        """[N]; strands are free to contract across."""
        return self.factor * E_X * WIDTH * self.h

    @property
    def EI(self) -> float:
        """[N m^2]."""
        return self.Q_11 * WIDTH * self.h**3 / 12.0

    @property
    def reach(self) -> float:
        """Of the middle surface from the axis of a roller that it touches [m]."""
        return R + 0.5 * self.h

    def beam(self) -> BeltBeam:
        """The belt as an elastica on rollers of the same stiffness."""
        return belt_beam(TENSION, self.EA, self.EI, LENGTH, self.reach, WIDTH * K)

    def stretched(self) -> Result:
        """Equilibrium of the shell: roller 1 is fixed, roller 2 slides along x and is pulled."""
        system, ground, c = lm.System(), lm.Ground(), RADIUS - self.reach + DIP
        ply = lm.Lamina(E1=self.factor * E_X, E2=self.factor * E_Y, nu12=NU, G12=self.factor * G_XY, rho=RHO)
        laminate = lm.Laminate(ply, angles=(0,), thickness=self.h)
        place = (0.0, 0.0, -0.5 * WIDTH)
        belt = lm.Shell("belt", lm.BeltSurface(length=LENGTH, width=WIDTH), (N_AROUND, 1), laminate, position=place)
        shape = lm.Cylinder(radius=0.9 * R, length=1.5 * WIDTH)
        roller = lm.RigidBody("roller", mass=60.0, shape=shape, position=(c, 0.0, 0.0))
        law = {"radius": R, "length": 1.5 * WIDTH, "stiffness": K, "points": N_POINTS}
        for item in (
            ground,
            belt,
            roller,
            lm.PrismaticJoint("rail", ground.marker("guide", c, 0.0, 0.0), roller.origin, axis=(1.0, 0.0, 0.0)),
            lm.CylinderContact("touch1", belt, ground.marker("axis", -c, 0.0, 0.0), **law),  # type: ignore[arg-type]
            lm.CylinderContact("touch2", belt, roller.origin, **law),  # type: ignore[arg-type]
            lm.PointForce("pull", roller.origin, (ENDS, 0.0, 0.0)),
            lm.PointSupport("hold", belt.marker("apex", 0.5 * LENGTH, 0.5 * WIDTH), axes="yz"),  # bears nothing, by symmetry
        ):
            system.add(item)
        steps = (1.0 / ENDS, 10.0 / ENDS, 1e-2, 0.1, 1.0)
        return lm.equilibrium(system, steps=steps, newton=lm.Newton(keep=0.0, max_iterations=40))


def strand_tension(result: Result, beam: BeltBeam) -> Floats:
    """Force along the belt in the upper strand, away from the rollers by one and a half elements or more [N]."""
    sample = result.plate("belt", None, 4)
    N = np.asarray(np.trapezoid(sample.section_forces()[..., 0], dx=WIDTH / (len(sample.r) - 1), axis=0))
    s = np.linspace(0.0, LENGTH, len(N))
    margin = beam.contact + 1.5 * LENGTH / N_AROUND
    return N[(s > margin) & (s < 0.5 * LENGTH - margin)]


def rows(result: Result, name: str) -> Floats:
    """Normal force of each row of points across the belt, from its beginning [N]."""
    (block,) = (block for block in result.model.forces if isinstance(block, ContactBlock) and block.name == name)
    field = block.field(result.final.q, result.final.v)
    force = field.pressure * block.sheet.area.reshape(field.pressure.shape)
    return force.reshape(-1, N_POINTS, N_POINTS).sum(axis=1).reshape(-1)


def run() -> Iterator[Evidence]:
    """Yield the checks and pictures of this case."""
    thick, thin = Belt(4e-3, 1.0), Belt(1e-3, 4.0)
    result, beam = thick.stretched(), thick.beam()
    yield from forces(thick, result, beam)
    yield from bending(thick, result, beam)
    yield from centres(thick, result, beam)
    yield from centres(thin, thin.stretched(), thin.beam())
    force = np.roll(rows(result, "touch2"), N_AROUND * N_POINTS // 2) / ROW
    s = (np.arange(len(force)) + 0.5) * ROW - 0.5 * LENGTH
    near = np.abs(s) < 0.3
    both = np.concatenate([-beam.s[:0:-20], beam.s[::20]]), np.concatenate([beam.line_force[:0:-20], beam.line_force[::20]])
    yield Curves(
        "Force of the belt on roller 2", "Place along the belt [m]", "Force per length [N/m]",
        {"rows of points": (s[near], force[near])}, {"elastica": both},
    )  # fmt: skip
    yield Shape("Stretched by 7000 N", result, field="von_mises", view=(0.0, -0.45, 1.0))


def forces(belt: Belt, result: Result, beam: BeltBeam) -> Iterator[Evidence]:
    """Equilibrium, tension and the sum of the normal forces."""
    for name, sign in (("touch1", 1.0), ("touch2", -1.0)):
        yield Check(
            f"force of the belt on roller {name[-1]} along x", result[f"{name}.force"].values[0], sign * ENDS, 1e-6,
            source="equilibrium", unit="N", reason="exact where Newton's method has converged",
        )  # fmt: skip
    N = strand_tension(result, beam)
    yield Check(
        "tension of a strand, mean", N.mean(), TENSION, 5e-3, source="equilibrium", unit="N",
        reason="the balance holds for nodal forces; stress at points is of lower order, and the trapezoidal sum of five of them",
    )  # fmt: skip
    found = float(result["touch2.normal"])
    turn = 2.0 * np.arcsin(0.5 * np.sqrt(belt.EI / TENSION) / belt.reach)
    sharp = TENSION * (2.0 * np.sin(turn) + (np.pi - 2.0 * turn) * np.cos(turn))
    yield Check(
        "sum of the normal forces on roller 2", found, beam.normal, 1e-3, source="elastica on a soft roller", unit="N",
        reason="the belt bends as a wide one but within sqrt(R h) of its edges, 2 x 25 of 800 mm: 4 % of 3.6 % less EI, of which "
        "2.4 % of the sum depend; the rest is for the mesh",
    )  # fmt: skip
    yield Check(
        "sum of the normal forces on roller 2, hard roller", found, sharp, 5e-3, unit="N",
        source="T (2 sin a + (pi - 2 a) cos a)",
        reason="2.4 % less than pi T; a fifth of that for the roller, which spreads the force at the end over half of sqrt(EI/T)",
    )  # fmt: skip
    plateau = rows(result, "touch2").reshape(-1, N_POINTS)[:2].mean()
    yield Check(
        "force of a row of points near the middle of the contact", plateau, beam.line_force[0] * ROW, 0.02,
        source="elastica on a soft roller", unit="N", reason="mean over two elements of 31 mm, which ripples with the mesh",
    )  # fmt: skip


def bending(belt: Belt, result: Result, beam: BeltBeam) -> Iterator[Evidence]:
    """Curvature and stress in the middle of the contact with roller 2."""
    sample = result.plate("belt", None, 2)
    kappa = -float(sample.strains[1, 1, 3])
    hard = 1.0 / belt.reach - 1.0 / RADIUS
    yield Check(
        "change of curvature on roller 2", kappa, hard, 0.01, source="1/(R + h/2) - 1/R_0", unit="1/m",
        reason="per length of the stress-free belt, twice stretched by 0.1 %; the depth of 0.2 mm makes the radius smaller",
    )  # fmt: skip
    yield Check(
        "change of curvature on roller 2, soft", kappa, beam.bending, 5e-3, source="elastica", unit="1/m", reason="as above"
    )
    bent = 1e-6 * belt.Q_11 * 0.5 * belt.h * beam.bending
    stretched = 1e-6 * beam.tension / (WIDTH * belt.h)
    top, bottom = (1e-6 * float(sample.stress(0, side)[1, 1, 0]) for side in ("top", "bottom"))
    yield Check(
        "bending stress on roller 2", 0.5 * (top - bottom), bent, 5e-3, unit="MPa",
        source="Q_11 h/2 times the change", reason="as the change of curvature",
    )  # fmt: skip
    across = NU * E_Y / E_X  # stress across the belt that keeps it from bending so
    sides: tuple[tuple[Surface, str, float], ...] = (("top", "outside", 1.0), ("bottom", "inside", -1.0))
    for side, name, sign in sides:
        along, other = stretched + sign * bent, sign * across * bent
        yield Check(
            f"von Mises stress on roller 2, {name}", 1e-6 * float(sample.von_mises(0, side)[1, 1]),
            np.sqrt(along**2 - along * other + other**2), 0.02, source="N / (w h) and bending", unit="MPa",
            reason="membrane stress of a point, a tenth of it, is 10 % off where the belt's mesh locks",
        )  # fmt: skip


def centres(belt: Belt, result: Result, beam: BeltBeam) -> Iterator[Evidence]:
    """Distance of the rollers."""
    found = float(result["roller.position"].values[0]) + RADIUS - belt.reach + DIP
    name = f"distance of the rollers, belt of {1e3 * belt.h:g} mm"
    depth = (TENSION / (K * WIDTH * belt.reach)) ** (2 / 3)
    limp = 0.5 * LENGTH * (1.0 + TENSION / belt.EA) - np.pi * (belt.reach - depth)
    yield Check(
        name, found, beam.centres, 1e-4, source="elastica on a soft roller", unit="m",
        reason="stretch is T / EA = 1.1e-3 of half the length 1.25 m, known to 1 % of itself where tension is",
    )  # fmt: skip
    if belt.h < 2e-3:
        yield Check(
            f"{name}, limp", found, limp, 1e-4, source="L (1 + T/EA) / 2 - pi (R + h/2 - depth)", unit="m", reason="as above",
        )  # fmt: skip
