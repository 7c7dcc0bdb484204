"""Four rigid panels unfold under a drive, against the closed form of the one-degree-of-freedom mechanism."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

import lamella as lm
from lamella.examples import example
from lamella.io.model_file import read_model
from lamella.verification import Curves, Evidence, References, Shape
from lamella.verification.zigzag import driving_force

slow = False

EVEN = ((0.2, 2.4), (2.7, 4.85))
"""Times [s] of even acceleration without the twenty steps after a kink of the acceleration, in which the integrator settles."""
PANELS = ("p1", "p2", "p3", "p4")


def run() -> Iterator[Evidence]:
    """Yield the checks and pictures of this case."""
    references = References.beside(__file__)
    rigid = [f"system.{panel}.{setting}" for panel in PANELS for setting in ("strain=rigid", "mesh=[1, 1]")]
    model = read_model(example("solar-array").model, rigid)
    result = lm.simulate(model.system, 5.0, lm.GeneralizedAlpha(dt=5e-3, rho_inf=0.5))
    t = result.at[1:-1]
    expected = driving_force(t)
    force = sum(result[f"drive{k}.force"].values[1:-1, 0] for k in (1, 2))
    even = np.logical_or.reduce([(t > start) & (t < end) for start, end in EVEN])
    error = np.abs(force - expected) / np.abs(expected).max()
    yield references.check("driving force, largest error in even acceleration", error[even].max())
    computed = {"lamella": (t, force)}
    yield Curves("Driving force", "Time [s]", "Force [N]", computed, {"closed form": (t, expected)})
    yield Shape("The panels at 1 s, 2.5 s and 4 s", result, at=(1.0, 2.5, 4.0))
    yield references.check("driving force, mean error", abs(np.mean(force - expected)) / np.abs(expected).max())
    across = max(np.abs(result[f"node{k}.force"].values[:, 1]).max() for k in (1, 2))
    yield references.check("force along y over the largest driving force", across / np.abs(expected).max())
    work = result["work.supports"].values
    yield references.check("energy balance over the work", np.abs(result["energy.balance"].values).max() / np.abs(work).max())
