"""A satellite's panel in the sun: how its root is clamped decides its shape; order of motion and heat solved together."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

import lamella as lm
from lamella.joint.clamped_edge import Clamping
from lamella.result import Result
from lamella.roles import Floats
from lamella.verification import Curves, Evidence, References, Shape

slow = False

LENGTH, WIDTH, H = 7.5, 0.5, 0.0103
GRADIENT = 150.0
SHEET = lm.Isotropic(E=1.93e9, nu=0.3, rho=36.8, alpha=2.3e-5, k=1.5, c=921.0)
END, STEPS = 4.0, (100, 200, 400)


def panel(kind: Clamping, mesh: tuple[int, int], damping: float = 0.0) -> tuple[lm.System, lm.Plate]:
    """The panel along x, clamped at its root."""
    system = lm.System()
    section = lm.Laminate(SHEET, thickness=H)
    plate = system.add(lm.Plate("panel", (LENGTH, WIDTH), mesh, section, position=(0.0, -0.5 * WIDTH, 0.0), damping=damping))
    plate.marker("corner", LENGTH, 0.0)
    plate.marker("middle", 0.5 * LENGTH, 0.5 * WIDTH)
    system.add(lm.Clamp("root", plate.edge("x-"), kind=kind))
    system.add(lm.TemperatureField("heat", plate))
    return system, plate


def run() -> Iterator[Evidence]:
    """Yield the checks and pictures of this case."""
    references = References.beside(__file__)
    computed, published = {}, {}
    for kind in ("restrained", "sliding"):
        name = f"corner of the panel, {kind}, T_N"
        found = deflections(kind, references.at(name))
        yield from references.checks(name, found)
        computed[kind], published[f"{kind}, another code"] = (references.at(name), found), references.points(name)
    yield Curves("Corner of the panel at T_M = 150 K/m", "T_N [K]", "z [m]", computed, published)
    cold, hot = deflections("sliding", (0.0, 400.0))
    yield references.check("sliding clamp, change of deflection by T_N = 400, share", hot / cold - 1)
    yield references.check("full clamp, deflection at T_N = 20 beside the sliding one", deflections("full", (20.0,))[0] / cold)
    yield from _order(references)


def deflections(kind: Clamping, means: Sequence[float], mesh: tuple[int, int] = (10, 1)) -> Floats:
    """Deflection of the free corner [m] under T_M = 150 K/m for each T_N."""
    found = []
    for mean in means:
        system, plate = panel(kind, mesh)
        system.add(lm.PrescribedTemperature("oven", plate, mean, gradient=GRADIENT))
        found.append(float(lm.equilibrium(system, steps=4)["corner.position"].values[2]))
    return np.array(found)


def in_the_sun(n: int) -> Result:
    """4 s of motion in n steps, in light that rises within 2 s and comes in at 65 degrees; the panel bends as it warms."""
    system, plate = panel("restrained", (4, 1), damping=0.01)
    light = (-np.sin(np.radians(65)), 0.0, -np.cos(np.radians(65)))
    system.add(lm.SolarFlux("sun", plate, light, 0.79, 13500.0, profile=lm.SmoothStep(t_end=2.0)))
    return lm.simulate(system, END, lm.GeneralizedAlpha(dt=END / n, rho_inf=0.8, newton=lm.Newton(tolerance=1e-11)))


def _order(references: References) -> Iterator[Evidence]:
    results = [in_the_sun(n) for n in STEPS]
    for name, signal in (("deflection", "corner.position"), ("T_N", "middle.T_N"), ("T_M", "middle.T_M")):
        coarse, fine, finest = (np.atleast_1d(result[signal].values[-1])[-1] for result in results)
        yield references.check(f"order in time of the {name}", float(np.log2(abs(coarse - fine) / abs(fine - finest))))
    view = float(results[-1]["sun.view"].values[-1])
    curves = {"corner": (results[-1].at, results[-1]["corner.position"].values[:, 2])}
    yield Curves("The panel bends as the sun rises", "Time [s]", "z [m]", curves)
    yield Shape("At 1 s, 2 s and 4 s", results[-1], at=(1.0, 2.0, 4.0), field="T_M")
    yield references.check("change of view as the panel bends", abs(view / np.cos(np.radians(65)) - 1))
