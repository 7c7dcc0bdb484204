"""A strip drawn over a fixed cylinder."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

import lamella as lm
from lamella.result import Result
from lamella.roles import Floats
from lamella.surface.base import Surface, SurfacePoints
from lamella.verification import Check, Curves, Evidence

slow = False

R, H, WIDTH, FREE, MU = 0.1, 5e-4, 0.05, 0.15, 0.3
RADIUS, WRAP, HELD, SPEED, END = R + 0.5 * H, 0.5 * np.pi, 20.0, 0.1, 0.25
ARC = RADIUS * WRAP
N_FREE, N_ARC = 5, 10
RISE = 0.05  # s, in which the strip is stretched; then it is drawn


class Wrapped(Surface):
    """The strip: up along z, a quarter of a circle about the axis y, and along x; the parts meet where elements do."""

    @property
    def size(self) -> tuple[float, float]:
        return 2 * FREE + ARC, WIDTH

    def at(self, x: Floats, y: Floats) -> SurfacePoints:
        s = x - FREE
        angle = np.clip(s, 0.0, ARC) / RADIUS
        before, after = np.minimum(s, 0.0), np.maximum(s - ARC, 0.0)
        c, d, zero = np.cos(angle), np.sin(angle), np.zeros_like(s)
        r = np.stack([after - RADIUS * c, y, before + RADIUS * d], axis=1)
        return SurfacePoints(r, np.stack([d, zero, c], axis=1), np.stack([zero, zero + 1, zero], axis=1), np.zeros_like(r))


def drawn() -> Result:
    """The strip's upper end drawn along x."""
    system, ground = lm.System(), lm.Ground()
    laminate = lm.Laminate(lm.Isotropic(E=1e9, nu=0.0, rho=1200), thickness=H)
    strip = lm.Shell("strip", Wrapped(), (2 * N_FREE + N_ARC, 1), laminate, damping=1e-3)
    friction = lm.RegularisedFriction(velocity=5e-4)
    law = {"stiffness": 1e10, "damping": 0.05, "mu": MU, "friction": friction}
    drum = lm.CylinderContact("drum", strip, ground.origin, R, 0.2, (0.0, 1.0, 0.0), **law)  # type: ignore[arg-type]
    back = lm.EdgeForce("back", strip.edge("x-"), (0.0, 0.0, -HELD / WIDTH), profile=lm.SmoothStep(t_end=RISE, end=1.0))
    drawing = lm.Integral(lm.SmoothStep(t_start=RISE, t_end=2 * RISE, end=SPEED))
    draw = lm.EdgeSupport("draw", strip.edge("x+"), motion={"x": drawing})
    for item in (ground, strip, drum, back, draw):
        system.add(item)
    return lm.simulate(system, END, lm.GeneralizedAlpha(dt=1e-3, rho_inf=0.5))


def run() -> Iterator[Evidence]:
    """Yield the checks and pictures of this case."""
    result = drawn()
    tension = result["draw.force"].values[:, 0]
    late = result.at > END - 0.1
    ratio = tension[late].mean() / HELD
    why = "rows of points that enter and leave in turn let the tension ripple; its mean over 10 mm of travel"
    yield Check("ratio of tensions", ratio, np.exp(MU * WRAP), 0.01, source="Euler 1769, Eytelwein 1808", reason=why)
    force = result["drum.force"].values[late].mean(axis=0)
    why = "balance of the strip; the mean of its inertia over the time is small"
    yield Check("force on the drum along x", force[0], tension[late].mean(), 5e-3, source="equilibrium", unit="N", reason=why)
    yield Check("force on the drum along z", force[2], -HELD, 5e-3, source="equilibrium", unit="N", reason=why)
    heat = result["drum.friction_power"].values[late].mean()
    why = "as above; the strip is drawn at 0.1 m/s, and shrinks by 1e-3"
    yield Check("heat", heat, (np.exp(MU * WRAP) - 1) * HELD * SPEED, 0.03, source="(T_1 - T_2) v", unit="W", reason=why)
    limit = {"exp(mu theta)": ([2 * RISE, END], [np.exp(MU * WRAP)] * 2)}
    yield Curves("Tensions of a strip over a drum", "Time [s]", "T_1 / T_2 [–]", {"lamella": (result.at, tension / HELD)}, limit)
