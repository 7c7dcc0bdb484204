"""Laminate pinned at its corners under a suddenly applied force."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

import lamella as lm
from lamella.verification import Curves, Evidence, References, Shape

slow = True


def pinned(mesh: int, force: float = -2.0) -> lm.System:
    """A [0/90/0] plate of 1.5 m x 2 m with its corners pinned and a force along z at the centre."""
    ply = lm.Lamina(E1=181e9, E2=103e9, G12=7.7e9, nu12=0.28, rho=1560)
    layup = lm.Laminate(ply, angles=(0, 90, 0), thickness=1.5e-3)
    system = lm.System()
    plate = system.add(lm.Plate("plate", size=(1.5, 2.0), mesh=(mesh, mesh), laminate=layup))
    for corner in ("x-y-", "x+y-", "x+y+", "x-y+"):
        system.add(lm.PointSupport(f"pin {corner}", plate.corner(corner)))
    system.add(lm.PointForce("load", plate.marker("C", 0.75, 1.0), (0, 0, force)))
    return system


def run() -> Iterator[Evidence]:
    """Yield the checks and pictures of this case."""
    references = References.beside(__file__)
    result = lm.simulate(pinned(6), 1.0, lm.GeneralizedAlpha(dt=2.5e-4, rho_inf=0.9))
    t, z = result.at, result["C.position"].values[:, 2]
    yield references.check("lowest z_C", z.min())
    yield references.check("time of the lowest z_C", t[z.argmin()])
    yield references.check("mean z_C", np.trapezoid(z, t) / t[-1])
    yield from references.checks("z_C", np.interp(references.at("z_C"), t, z))

    curves = {"mesh 6 x 6": (t, z)}
    fine = lm.simulate(pinned(8), 0.2, lm.GeneralizedAlpha(dt=2.5e-4, rho_inf=0.9))
    t, z = fine.at, fine["C.position"].values[:, 2]
    yield references.check("first peak", z.min())
    yield references.check("time of the first peak", t[z.argmin()])
    curves["mesh 8 x 8"] = (t, z)
    peak = ([references.value("time of the first peak")], [references.value("first peak")])
    points = {"6 x 6, another code": references.points("z_C"), "first peak, four codes": peak}
    yield Curves("Deflection after a sudden force", "Time [s]", "z_C [m]", curves, points)
    yield Shape("At 0.163 s, displacement × 50", fine, at=0.163, scale=50.0)
