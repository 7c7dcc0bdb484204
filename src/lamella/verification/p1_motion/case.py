"""Cantilever laminate under a suddenly applied force."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal

import numpy as np

import lamella as lm
from lamella.verification import Curves, Evidence, References, Shape

slow = True

LEVEL = -0.1117  # the static deflection: where the motion is fastest, so that a crossing is a sharp mark [m]


def cantilever(mesh: int, n_gauss: Literal[3, 4, 5] = 4, force: float = -10.0, mass_damping: float = 0.0) -> lm.System:
    """A [0/90/0] plate of 1.5 m x 2 m clamped along x = 0, with a force along z at C = (1.5, 1)."""
    ply = lm.Lamina(E1=181e9, E2=103e9, G12=7.7e9, nu12=0.28, rho=1560)
    layup = lm.Laminate(ply, angles=(0, 90, 0), thickness=1.5e-3)
    system = lm.System()
    given = {"n_gauss": n_gauss, "mass_damping": mass_damping}
    plate = system.add(lm.Plate("plate", size=(1.5, 2.0), mesh=(mesh, mesh), laminate=layup, **given))
    system.add(lm.Clamp("root", plate.edge("x-")))
    system.add(lm.PointForce("load", plate.marker("C", 1.5, 1.0), (0, 0, force)))
    return system


def crossings(t: np.ndarray, z: np.ndarray, level: float) -> np.ndarray:
    """Times at which z passes the level, by linear interpolation."""
    k = np.flatnonzero((z[:-1] - level) * (z[1:] - level) < 0)
    return t[k] + (level - z[k]) / (z[k + 1] - z[k]) * (t[k + 1] - t[k])


def run() -> Iterator[Evidence]:
    """Yield the checks and pictures of this case."""
    references = References.beside(__file__)
    result = lm.simulate(cantilever(6, n_gauss=5), 2.0, lm.GeneralizedAlpha(dt=1e-3, rho_inf=0.9))
    t, z = result.at, result["C.position"].values[:, 2]
    yield references.check("lowest z_C", z.min())
    yield references.check("time of the lowest z_C", t[z.argmin()])
    yield references.check("mean z_C", np.trapezoid(z, t) / t[-1])
    yield from references.checks("z_C", np.interp(references.at("z_C"), t, z))

    fine = lm.simulate(cantilever(12), 1.1, lm.GeneralizedAlpha(dt=1e-3, rho_inf=0.9))
    curves = {"mesh 6 x 6": (t, z)}
    t, z = fine.at, fine["C.position"].values[:, 2]
    times = crossings(t, z, LEVEL)
    yield references.check("first peak", z[t < 0.7].min())
    yield from references.checks("crossing", times[:3])
    yield references.check("period", times[2] - times[0])
    curves["mesh 12 x 12"] = (t, z)
    points = {
        "6 x 6, another code": references.points("z_C"),
        "crossings, four codes": (references.value("crossing"), [LEVEL] * 3),
    }
    yield Curves("Deflection after a sudden force", "Time [s]", "z_C [m]", curves, points)
    yield Shape("Mesh 12 x 12", fine, at=(0.2, 0.42, 1.1))
