"""The unfolding of the flexible solar array, against another code's forces."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

import lamella as lm
from lamella.examples import example
from lamella.io.model_file import read_model
from lamella.roles import Floats
from lamella.verification import Curves, Evidence, References, Shape
from lamella.verification.zigzag import driving_force

slow = True

SAMPLES = np.linspace(0.0, 5.0, 501)
PHASES = {"accelerating": slice(0, 251), "decelerating": slice(250, 501)}
"""The other code's statistics are of every second step, with both ends of a phase."""
LAYUPS = {
    "symmetric": "[-45, 45, -45, 45, 90, 0, 0, 90, 45, -45, 45, -45]",
    "antisymmetric": "[-45, 45, -45, 45, 90, 0, 0, -90, -45, 45, -45, 45]",
}


def run() -> Iterator[Evidence]:
    """Yield the checks and pictures of this case."""
    references = References.beside(__file__)
    for name, angles in LAYUPS.items():
        model = read_model(example("solar-array").model, [f"laminates.panel.angles={angles}"])
        result = lm.simulate(model.system, 5.0, lm.GeneralizedAlpha(dt=5e-3, rho_inf=0.9))

        def force(place: str, k: int, result: lm.Result = result) -> Floats:
            return np.interp(SAMPLES, result.at, result[f"{place}.force"].values[:, k])

        drive = force("drive1", 0) + force("drive2", 0)
        vibration = drive - driving_force(SAMPLES)
        y1, y2 = force("node1", 1), force("node2", 1)
        z = force("node1", 2) + force("node2", 2)
        for phase, part in PHASES.items():
            yield references.check(f"{name}, {phase}: mean drive", drive[part].mean())
            yield references.check(f"{name}, {phase}: spread of the drive about the rigid one", vibration[part].std())
            yield references.check(f"{name}, {phase}: mean y force", y1[part].mean())
            yield references.check(f"{name}, {phase}: spread of the y force", y1[part].std())
            yield references.check(f"{name}, {phase}: largest sum of the y forces", np.abs(y1 + y2)[part].max())
            yield references.check(f"{name}, {phase}: mean z force", z[part].mean())
        computed = {"driving force": (SAMPLES, drive), "y force at one hinge": (SAMPLES, y1)}
        yield Curves(
            f"Forces, {name} layup", "Time [s]", "Force [N]", computed, {"drive, rigid": (SAMPLES, driving_force(SAMPLES))}
        )
        yield Shape(f"The {name} layup at 1 s, 2.5 s and 4 s", result, at=(1.0, 2.5, 4.0), field="curvature.xx")
        work = np.abs(result["work.supports"].values).max()
        yield references.check("energy damped over the work", np.abs(result["energy.balance"].values[-1]) / work)
