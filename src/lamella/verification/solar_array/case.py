"""The unfolding of the flexible solar array, against another code's forces."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

import lamella as lm
from lamella.examples import example
from lamella.io.model_file import read_model
from lamella.verification import Check, References

slow = True

PHASES = {"accelerating": (0.0, 2.5), "decelerating": (2.5, 5.0)}
LAW = "profiles.unfold.cruise=1e-6"
"""The other code takes 0.1 s from each acceleration to zero, so that the change in the middle lasts 0.2 s."""
LAYUPS = {
    "symmetric": "[-45, 45, -45, 45, 90, 0, 0, 90, 45, -45, 45, -45]",
    "antisymmetric": "[-45, 45, -45, 45, 90, 0, 0, -90, -45, 45, -45, 45]",
}


def run() -> Iterator[Check]:
    """Yield the checks of this case."""
    references = References.beside(__file__)
    for name, angles in LAYUPS.items():
        model = read_model(example("solar-array").model, [f"laminates.panel.angles={angles}", LAW])
        result = lm.simulate(model.system, 5.0, lm.GeneralizedAlpha(dt=5e-3, rho_inf=0.9))
        drive = result["drive1.force"].values[:, 0] + result["drive2.force"].values[:, 0]
        y1, y2 = (result[f"node{k}.force"].values[:, 1] for k in (1, 2))
        z = result["node1.force"].values[:, 2] + result["node2.force"].values[:, 2]
        for phase, (start, end) in PHASES.items():
            part = (result.at > start) & (result.at < end)
            yield references.check(f"{name}, {phase}: mean drive", drive[part].mean())
            yield references.check(f"{name}, {phase}: spread of the drive", drive[part].std())
            yield references.check(f"{name}, {phase}: mean y force", y1[part].mean())
            yield references.check(f"{name}, {phase}: spread of the y force", y1[part].std())
            yield references.check(f"{name}, {phase}: mean z force", z[part].mean())
            unequal = np.abs(y1 + y2)[part].max() / np.abs(y1)[part].max()
            yield references.check(f"{phase}: largest unequal part of the y forces", unequal)
        work = np.abs(result["work.supports"].values).max()
        yield references.check("energy damped over the work", np.abs(result["energy.balance"].values[-1]) / work)
