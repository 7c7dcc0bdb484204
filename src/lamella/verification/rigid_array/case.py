"""Four rigid panels unfold under a drive, against the closed form of the one-degree-of-freedom mechanism."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

import lamella as lm
from lamella.examples import example
from lamella.io.model_file import read_model
from lamella.roles import Floats
from lamella.verification import Check, References

slow = False

LENGTH, MASS = 1.5, 1560 * 1.5 * 2.0 * 1.5e-3
EVEN = ((0.2, 2.4), (2.7, 4.85))
"""Times [s] of even acceleration without the twenty steps after a kink of the acceleration, in which the integrator settles."""
PANELS = ("p1", "p2", "p3", "p4")


def closed_form(t: Floats, x: Floats, v: Floats, a: Floats) -> Floats:
    """Driving force [N] at times at which corner 1 stands at x with speed v and acceleration a.

    With X = 4 L cos(phi), the kinetic energy of four panels is T = 1/2 m L^2 phi'^2 g, g = 21 sin^2 phi + cos^2 phi + 1/3, and
    the drive's power F X' is dT/dt.
    """
    phi = np.arccos(x / (4 * LENGTH))
    sine, cosine = np.sin(phi), np.cos(phi)
    rate = -v / (4 * LENGTH * sine)
    second = -(a / (4 * LENGTH) + cosine * rate**2) / sine
    g, slope = 21 * sine**2 + cosine**2 + 1 / 3, 40 * sine * cosine
    return -MASS * LENGTH * (g * second + 0.5 * slope * rate**2) / (4 * sine)


def run() -> Iterator[Check]:
    """Yield the checks of this case."""
    references = References.beside(__file__)
    rigid = [f"system.{panel}.{setting}" for panel in PANELS for setting in ("strain=rigid", "mesh=[1, 1]")]
    model = read_model(example("solar-array").model, rigid)
    result = lm.simulate(model.system, 5.0, lm.GeneralizedAlpha(dt=5e-3, rho_inf=0.5))
    law = lm.TrapezoidalSpeed(t_end=5.0, ramp=0.1, end=4 * LENGTH * (np.cos(np.radians(10)) - np.cos(np.radians(75))))
    t = result.at[1:-1]
    x = 4 * LENGTH * np.cos(np.radians(75)) + np.array([law.value(time) for time in t])
    v, a = (np.array([f(time) for time in t]) for f in (law.rate, law.acceleration))
    expected = closed_form(t, x, v, a)
    force = sum(result[f"drive{k}.force"].values[1:-1, 0] for k in (1, 2))
    even = np.logical_or.reduce([(t > start) & (t < end) for start, end in EVEN])
    error = np.abs(force - expected) / np.abs(expected).max()
    yield references.check("driving force, largest error in even acceleration", error[even].max())
    yield references.check("driving force, mean error", abs(np.mean(force - expected)) / np.abs(expected).max())
    across = max(np.abs(result[f"node{k}.force"].values[:, 1]).max() for k in (1, 2))
    yield references.check("force along y over the largest driving force", across / np.abs(expected).max())
    work = result["work.supports"].values
    yield references.check("energy balance over the work", np.abs(result["energy.balance"].values).max() / np.abs(work).max())
