"""Plates that heat stretches, bends and buckles: free growth, curling, bimetal, laminates, a strip between walls."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

import lamella as lm
from lamella.result import Result
from lamella.roles import Floats
from lamella.verification import Check, Evidence, References, Shape

slow = False

ALPHA, DATA = 2e-5, {"k": 10.0, "c": 500.0}
NEWTON = lm.Newton(tolerance=1e-12, keep=0.0, line_search=True)
HOT, SMALL = 500.0, 1e-4
"""Rise of temperature [K] for what is exact at any strain, and for what is linear."""


def sheet(nu: float = 0.3, E: float = 70e9, alpha: float = ALPHA) -> lm.Isotropic:
    """A sheet of metal."""
    return lm.Isotropic(E=E, nu=nu, rho=2700.0, alpha=alpha, **DATA)


def run() -> Iterator[Evidence]:
    """Yield the checks and pictures of this case."""
    references = References.beside(__file__)
    yield from _growth(references)
    yield from _curvature(references)
    yield from _curl(references)
    yield from _bimetal(references)
    yield from _laminates(references)
    yield from _buckling(references)


def _growth(references: References) -> Iterator[Check]:
    """A hot panel on a hub that has turned: its length, and its strain energy beside that of one that may not grow."""
    system, ground = lm.System(), lm.Ground()
    system.add(ground)
    hub = system.add(lm.RigidBody("hub", mass=1.0, shape=lm.Box(size=(0.1, 0.1, 0.1))))
    panel = system.add(lm.Plate("panel", (1.0, 0.4), (3, 2), lm.Laminate(sheet(), thickness=5e-3), position=(0, -0.2, 0)))
    panel.marker("tip", 1.0, 0.2)
    pin = system.add(lm.RevoluteJoint("pin", ground.origin, hub.origin, axis=(0.0, 0.6, 0.8)))
    system.add(lm.FixedJoint("mount", hub.marker("face", 0.0, 0.0, 0.0), panel.edge("x-"), kind="sliding"))
    system.add(lm.AngleDrive("motor", pin, angle=lm.Constant(2.0)))
    _warm(system, panel, HOT)
    result = lm.equilibrium(system, newton=NEWTON, steps=4)
    kept = 0.5 * 70e9 / 0.7 * 2 * (ALPHA * HOT) ** 2 * 5e-3 * 0.4  # of the same strains in stress, E / (1 - nu) (alpha T)^2 h A
    yield references.check("stretch of the hot panel", float(np.linalg.norm(result["tip.position"])))
    yield references.check("strain energy of the hot panel", float(result["energy.strain"]) / kept)
    yield references.check("angle of the hub", float(result["pin.angle"]))


def _curvature(references: References) -> Iterator[Check]:
    """A free plate under a gradient through the thickness."""
    middle = _middle(_free(lm.Laminate(sheet(), thickness=5e-3), 0.0, 1.0))
    for label, component in (("kap_x", 3), ("kap_y", 4)):
        yield references.check(f"{label} for T_M = 1", middle[component] / ALPHA)


def _curl(references: References) -> Iterator[Evidence]:
    """A strip that grows along itself only rolls up to a quarter of a circle: alpha T_M L = pi / 2."""
    ply = lm.Lamina(E1=70e9, E2=70e9, G12=35e9, nu12=0.0, rho=2700.0, alpha1=ALPHA, k1=10.0, k2=10.0, c=500.0)
    system = lm.System()
    strip = system.add(lm.Plate("strip", (1.0, 0.1), (8, 1), lm.Laminate(ply, thickness=1e-3)))
    strip.marker("tip", 1.0, 0.05)
    system.add(lm.Clamp("root", strip.edge("x-"), kind="restrained"))
    _warm(system, strip, 0.0, 0.5 * np.pi / ALPHA)
    result = lm.equilibrium(system, newton=NEWTON, steps=10)
    tip = result["tip.position"].values
    yield Shape("A gradient rolls a strip up to a quarter of a circle", result, view=(0.3, 1.0, -0.3))
    yield references.check("x of the tip of the quarter circle", tip[0])
    yield references.check("z of the tip of the quarter circle", tip[2])


def _bimetal(references: References) -> Iterator[Check]:
    """A strip of two metals, the one that grows more at the bottom."""
    for nu in (0.0, 0.3):
        bottom = lm.Ply(sheet(nu), thickness=1e-3)
        top = lm.Ply(sheet(nu, E=200e9, alpha=1e-5), thickness=2e-3)
        middle = _middle(_free(lm.Laminate(plies=(bottom, top)), SMALL, 0.0))
        yield references.check(f"curvature of the bimetal, nu = {nu:g}", middle[3] / SMALL)


def _laminates(references: References) -> Iterator[Evidence]:
    """Two plies crosswise bend; four that are symmetric do not."""
    ply = lm.Lamina(E1=181e9, E2=10.3e9, G12=7.17e9, nu12=0.28, rho=1600.0, alpha1=2e-8, alpha2=2.25e-5, k1=5.0, k2=0.7, c=900.0)
    for angles, name in (((0.0, 90.0), "[0/90]"), ((0.0, 90.0, 90.0, 0.0), "[0/90/90/0]")):
        warm = _free(lm.Laminate(ply, angles=angles, thickness=1e-3), SMALL, 0.0)
        middle = _middle(warm)
        if name == "[0/90]":
            yield Shape("[0/90] warmed by 1e-4 K, displacement × 1e5", warm, field="displacement.z", scale=1e5)
        for label, component in (("eps_x", 0), ("kap_x", 3), ("kap_y", 4)):
            yield references.check(f"{label} of {name}", middle[component] / SMALL)


def _buckling(references: References) -> Iterator[Check]:
    """The rise of temperature at which the lowest frequency of a strip between walls vanishes."""
    h, length = 2e-3, 0.5
    critical = np.pi**2 * h**2 / (3 * length**2 * ALPHA)
    squares = []
    for share in (0.97, 1.03):
        system = lm.System()
        strip = system.add(lm.Plate("strip", (length, 0.05), (8, 1), lm.Laminate(sheet(nu=0.0), thickness=h)))
        for side in ("x-", "x+"):
            system.add(lm.Clamp(side, strip.edge(side), kind="restrained"))
        _warm(system, strip, share * critical)
        found = lm.modes(system, 1, state=lm.equilibrium(system, newton=NEWTON).final).frequencies[0]
        squares.append(float(np.sign(found) * found**2))
    below, above = squares
    yield references.check("rise of temperature at buckling", 0.97 + 0.06 * below / (below - above))


def _free(laminate: lm.Laminate, mean: float, gradient: float) -> Result:
    """A plate on isostatic supports, warmed evenly."""
    system = lm.System()
    plate = system.add(lm.Plate("plate", (0.3, 0.2), (3, 2), laminate))
    system.add(lm.PointSupport("pin", plate.corner("x-y-")))
    system.add(lm.PointSupport("line", plate.corner("x+y-"), axes="yz"))
    system.add(lm.PointSupport("height", plate.corner("x-y+"), axes="z"))
    _warm(system, plate, mean, gradient)
    return lm.equilibrium(system, newton=NEWTON)


def _warm(system: lm.System, plate: lm.Plate, mean: float, gradient: float = 0.0) -> None:
    system.add(lm.TemperatureField("heat", plate, reference=300.0))
    system.add(lm.PrescribedTemperature("oven", plate, 300.0 + mean, gradient=gradient))


def _middle(result: Result) -> Floats:
    """(eps, kap) in the middle of the plate."""
    sample = result.model.plates[0].sample(result.final.q)
    return sample.strains[len(sample.y) // 2, len(sample.x) // 2]
