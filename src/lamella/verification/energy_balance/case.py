"""What numerical damping takes from the cantilever laminate."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

import lamella as lm
from lamella.verification import Curves, Evidence, References
from lamella.verification.p1_motion.case import cantilever

slow = True


def run() -> Iterator[Evidence]:
    """Yield the checks and pictures of this case."""
    references = References.beside(__file__)
    curves = {}
    for name, dt in (("energy lost with 1 ms", 1e-3), ("energy lost with 0.5 ms", 5e-4)):
        result = lm.simulate(cantilever(6, n_gauss=5), 2.0, lm.GeneralizedAlpha(dt=dt, rho_inf=0.9))
        balance = result["energy.balance"].values
        yield references.check(name, -balance[-1])
        curves[f"{dt * 1e3:g} ms"] = (result.at, balance)
        yield references.check(f"energy gained with {dt * 1e3:g} ms", balance.max())
        if dt == 5e-4:
            name = "z_C with 0.5 ms"
            z = result["C.position"].values[:, 2]
            yield from references.checks(name, np.interp(references.at(name), result.at, z))
    yield Curves("Energy taken by numerical damping", "Time [s]", "Balance of energy [J]", curves)
