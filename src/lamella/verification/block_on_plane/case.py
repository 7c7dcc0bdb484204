"""A rigid plate that slides, sticks and bounces on a plane."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.optimize import brentq

import lamella as lm
from lamella.result import Result
from lamella.verification import Check, Curves, Evidence

slow = False

SIDE, HEIGHT, RHO = 0.2, 0.02, 8000.0  # m, m, kg/m^3
MASS, AREA, G = SIDE**2 * HEIGHT * RHO, SIDE**2, 9.81
K, MU, TANGENTIAL, V_D = 1e9, 0.3, 2.5e7, 1e-3
THROW, FALL, ALPHA = 1.0, 0.5, 0.4
SINK = (MASS * G / (K * AREA)) ** (2 / 3)
BRISTLES = lm.BristleFriction(stiffness=TANGENTIAL, damping=1e5)
NEWTON = lm.Newton(tolerance=1e-9, max_iterations=50, keep=0.5)


def moved(
    t_end: float,
    dt: float,
    *,
    speed: tuple[float, float] = (0.0, 0.0),
    pull: float = 0.0,
    gravity: bool = True,
    **law: object,
) -> Result:
    """The block in motion; it starts where the plane bears its weight, or where it touches, with a speed along x and along z."""
    system, ground = lm.System(), lm.Ground()
    laminate = lm.Laminate(lm.Isotropic(E=200e9, nu=0.3, rho=RHO), thickness=HEIGHT)
    z = 0.5 * HEIGHT - (SINK if gravity else 0.0)
    place = {"position": (0.0, 0.0, z), "velocity": (speed[0], 0.0, speed[1])}
    block = lm.Plate("block", (SIDE, SIDE), (1, 1), laminate, strain="rigid", **place)  # type: ignore[arg-type]
    middle = block.marker("middle", 0.5 * SIDE, 0.5 * SIDE)
    floor = lm.PlaneContact("floor", block, ground.origin, stiffness=K, **law)  # type: ignore[arg-type]
    for item in (
        ground,
        block,
        floor,
        lm.PointForce("pull", middle, (pull, 0.0, 0.0), profile=lm.SmoothStep(t_end=0.1, end=1.0)),
    ):
        system.add(item)
    if gravity:
        system.add(lm.Gravity("weight", (0.0, 0.0, -G)))
    return lm.simulate(system, t_end, lm.GeneralizedAlpha(dt=dt, rho_inf=0.8, newton=NEWTON))


def rebound(alpha: float) -> float:
    """Speed after the blow (Hunt and Crossley 1975)."""

    def f(v: float) -> float:
        return v / alpha - np.log1p(alpha * v) / alpha**2

    return float(brentq(lambda v: f(-v) - f(FALL), 1e-6, FALL)) if alpha else FALL  # type: ignore[arg-type]


def slides() -> Iterator[Evidence]:
    """Stopping distance with both laws of friction."""
    distance, source = THROW**2 / (2 * MU * G), "v_0^2 / (2 mu g)"
    curves = {}
    for name, friction in (("regularised", lm.RegularisedFriction(velocity=V_D)), ("bristles", BRISTLES)):
        result = moved(0.45, 5e-4, speed=(THROW, 0.0), mu=MU, friction=friction)
        x = result["middle.position"].values[:, 0] - 0.5 * SIDE
        why = "steps of 0.5 ms and a tail v_d^2 / (mu g)^2 of the speed: 2e-3 v_d; stretch of the bristles"
        yield Check(f"stopping distance, {name}", x[-1], distance, 5e-4, source=source, unit="m", reason=why)
        lost = result["energy.balance"].values[-1] / (0.5 * MASS * THROW**2)
        why = "the power of friction jumps once, in one step of 0.5 ms of 0.34 s"
        yield Check(f"energy unaccounted for, {name}", lost, 0.0, 2e-3, "absolute", "conservation of energy", reason=why)
        curves[name] = (result.at, x)
    t = np.linspace(0.0, THROW / (MU * G), 12)
    yield Curves(
        "A block thrown on a plane", "Time [s]", "Place [m]", curves, {"v t - mu g t^2 / 2": (t, THROW * t - 0.5 * MU * G * t**2)}
    )


def sticks() -> Iterator[Evidence]:
    """Rest and creep below mu N, acceleration above."""
    below, stretch = 0.9 * MU * MASS * G, 0.9 * MU * MASS * G / (TANGENTIAL * AREA)
    held = moved(0.3, 5e-4, pull=below, mu=MU, friction=BRISTLES)
    x = held["middle.position"].values[:, 0] - 0.5 * SIDE
    yield Check(
        "stretch under 0.9 mu m g, bristles", x[-1], stretch, 1e-6, source="T / (k_t A)", unit="m", reason="exact at rest"
    )
    half = len(x) // 2
    why = "rounding: the ringing has decayed by exp(-c_t A t / (2 m))"
    yield Check("creep in 0.15 s, bristles", abs(x[-1] - x[half]), 0.0, 1e-11, "absolute", "rest", "m", reason=why)
    creeping = moved(0.3, 5e-4, pull=below, mu=MU, friction=lm.RegularisedFriction(velocity=V_D))
    u = creeping["middle.velocity"].values[-1, 0]
    expected = V_D * 0.9 / np.sqrt(1 - 0.9**2)
    yield Check(
        "creep under 0.9 mu m g, regularised",
        u,
        expected,
        1e-6,
        source="u / sqrt(u^2 + v_d^2) = T / (mu N)",
        unit="m/s",
        reason="steady",
    )
    slid = moved(0.3, 5e-4, pull=1.5 * MU * MASS * G, mu=MU, friction=BRISTLES)
    v = slid["middle.velocity"].values[:, 0]
    rate = (v[-1] - v[half]) / (slid.at[-1] - slid.at[half])
    yield Check(
        "acceleration under 1.5 mu m g, bristles",
        rate,
        0.5 * MU * G,
        1e-6,
        source="(T - mu m g) / m",
        unit="m/s^2",
        reason="steady",
    )
    curves = {
        "bristles": (held.at, 1e6 * x),
        "regularised": (creeping.at, 1e6 * (creeping["middle.position"].values[:, 0] - 0.5 * SIDE)),
    }
    yield Curves("Pulled with 0.9 of what friction can hold", "Time [s]", "Displacement [µm]", curves)


def bounces() -> Iterator[Evidence]:
    """Depth, duration and speed of a blow."""
    depth = (5 * MASS * FALL**2 / (4 * K * AREA)) ** 0.4
    curves = {}
    for alpha in (0.0, ALPHA):
        result = moved(0.008, 2e-6 * 5, speed=(0.0, -FALL), gravity=False, damping=alpha)
        speed = result["middle.velocity"].values[:, 2]
        why = "second order: some hundred steps in the time of contact"
        name = f"alpha = {alpha:g} s/m"
        yield Check(
            f"speed after the blow, {name}",
            speed[-1],
            rebound(alpha),
            2e-4,
            source="Hunt and Crossley 1975",
            unit="m/s",
            reason=why,
        )
        curves[name] = (1e3 * result.at, speed)
        if alpha == 0.0:
            deepest, touching = result["floor.depth"].values, result.at[result["floor.points"].values > 0]
            yield Check("depth", deepest.max(), depth, 2e-4, source="m v_0^2 / 2 = 2/5 k A depth^(5/2)", unit="m", reason=why)
            duration, expected = touching[-1] - touching[0], 2.9432 * depth / FALL
            why = "two steps of 10 us at its ends"
            yield Check("duration", duration, expected, 2e-5, "absolute", "Hertz 1882: 2.9432 depth / v_0", "s", reason=why)
    reference = {f"Hunt and Crossley, alpha = {a:g} s/m": ([1e3 * 0.008], [rebound(a)]) for a in (0.0, ALPHA)}
    yield Curves("A block bounces", "Time [ms]", "Speed [m/s]", curves, reference)


def run() -> Iterator[Evidence]:
    """Yield the checks and pictures of this case."""
    yield from slides()
    yield from sticks()
    yield from bounces()
