"""Sunlight on plates that turn and bend: view, lit side, eclipse, and the gradient that follows."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

import lamella as lm
from lamella.result import Result
from lamella.roles import Floats
from lamella.verification import Check, Curves, Evidence, References, Shape

slow = False

RHO, C, K, H, ALPHA = 2000.0, 900.0, 1.5, 0.01, 2e-5
SIZE, SUN = (0.2, 0.1), 1350.0
TURN = 0.05
"""Angular velocity [rad/s]; with the time constant rho c h^2 / (12 k) = 10 s of the gradient, its lag is half a radian."""
TOP, BOTTOM = 0.7, 0.2


def run() -> Iterator[Evidence]:
    """Yield the checks and pictures of this case."""
    references = References.beside(__file__)
    yield from _turning(references)
    yield from _eclipse(references)
    yield from _bent(references)
    yield from _oblique(references)


def turning(absorptivity: float | tuple[float, float], n: int = 32, **options: Any) -> Result:
    """A rigid plate that a drive turns once about y, in light along -z."""
    system, ground = lm.System(), lm.Ground()
    system.add(ground)
    plate = _plate(system, "rigid")
    pin = system.add(
        lm.RevoluteJoint("pin", ground.marker("pivot", 0.0, 0.05, 0.0), plate.marker("root", 0.0, 0.05), axis=(0, 1, 0))
    )
    system.add(lm.AngleDrive("motor", pin, angle=lm.Integral(lm.Constant(TURN))))
    system.add(lm.SolarFlux("sun", plate, (0, 0, -2.0), absorptivity, SUN, **options))
    return _solved(system, 2 * np.pi / TURN, n)


def _turning(references: References) -> Iterator[Evidence]:
    """Each side in its turn, and the gradient's answer to cos(omega t)."""
    result = turning(0.7, 120)
    angle = TURN * result.at
    tau = RHO * C * H**2 / (12 * K)
    lag = 1 + (TURN * tau) ** 2
    exact = (np.cos(angle) + TURN * tau * np.sin(angle) - np.exp(-result.at / tau)) / lag
    yield references.check("view of the turning plate", _largest(result["sun.view"].values - np.cos(angle)))
    gradient = result["root.T_M"].values * 2 * K / (0.7 * SUN)
    yield references.check("T_M of the turning plate", _largest(gradient - exact))
    computed = {"view": (angle, result["sun.view"].values), "T_M": (angle, gradient)}
    closed = {"cos(ωt)": (angle, np.cos(angle)), "answer of T_M": (angle, exact)}
    yield Curves("A plate that turns in the light", "ω t [rad]", "View, T_M / (α S / 2k) [–]", computed, closed)
    sides = turning((TOP, BOTTOM))
    cosine = np.cos(TURN * sides.at)
    absorbed = np.where(cosine > 0, TOP * cosine, -BOTTOM * cosine)
    found = sides["sun.heat"].values / (SUN * SIZE[0] * SIZE[1])
    shares = {"lamella": (TURN * sides.at, found)}, {"each side by itself": (TURN * sides.at, absorbed)}
    yield Curves("Heat that a top of 0.7 and a bottom of 0.2 absorb", "ω t [rad]", "Share of the light [–]", *shares)
    yield references.check("heat that each side absorbs in its turn", _largest(found - absorbed))
    fixed = turning(0.7, model="uncoupled")
    yield references.check("view in the uncoupled model", _largest(fixed["sun.view"].values - 1.0))
    still = turning(0.7, model="uncoupled", turning=(0.0, TURN, 0.0))
    yield references.check("view of light that turns", _largest(still["sun.view"].values - np.cos(TURN * still.at)))


def _eclipse(references: References) -> Iterator[Evidence]:
    """The light is cut off between 30 s and 70 s: the gradient relaxes, the mean temperature waits."""
    shadow = lm.Table(times=(0.0, 29.0, 30.0, 70.0, 71.0, 100.0), values=(1.0, 1.0, 0.0, 0.0, 1.0, 1.0))
    system = lm.System()
    plate = _plate(system, "rigid")
    system.add(lm.Clamp("root", plate.edge("x-")))
    system.add(lm.SolarFlux("sun", plate, (0, 0, -1.0), 0.7, SUN, profile=shadow))
    result = _solved(system, 100.0, 400)
    at, gradient, mean = result.at, result["root.T_M"].values, result["root.T_N"].values
    begin, end = np.searchsorted(at, (30.0 - 1e-6, 70.0 - 1e-6))
    dark = slice(begin, end + 1)
    shares = {
        "T_N ρ c h / (α S) [s]": (at, mean * RHO * C * H / (0.7 * SUN)),
        "20 T_M / (α S / 2k) [–]": (at, 20 * gradient * 2 * K / (0.7 * SUN)),
    }
    yield Curves("An eclipse from 30 s to 70 s", "Time [s]", "Scaled temperature", shares)
    yield references.check("heat in the shadow", _largest(result["sun.heat"].values[dark]))
    yield references.check("T_N gained in the shadow", float(mean[end] - mean[begin]))
    yield references.check("T_M after 40 s of shadow, share", float(gradient[end] / gradient[begin]))
    yield references.check("T_N gained in all", mean[-1] * RHO * C * H / (0.7 * SUN))


def _bent(references: References) -> Iterator[Evidence]:
    """A strip that a gradient bends to a quarter of a circle: the mean of cos over the angle."""
    system = lm.System()
    strip = _plate(system, "exact")
    system.add(lm.Clamp("root", strip.edge("x-"), kind="restrained"))
    system.add(lm.PrescribedTemperature("oven", strip, 0.0, gradient=0.5 * np.pi / (ALPHA * SIZE[0])))
    for model in ("coupled", "uncoupled"):
        system.add(lm.SolarFlux(model, strip, (0, 0, -1.0), 1.0, SUN, model=model))
    result = lm.equilibrium(system, steps=10)
    yield references.check("view of a quarter of a circle", float(result["coupled.view"]))
    yield Shape("Bent by a gradient, light from above", result, view=(0.3, 1.0, -0.3))
    yield references.check("view of its flat reference", float(result["uncoupled.view"]))


def _oblique(references: References) -> Iterator[Check]:
    """Light at 65 degrees to the normal of a plate that is placed askew, from below."""
    turn = (0.3, -0.5, 0.2)
    system = lm.System()
    plate = _plate(system, "rigid", turn)
    system.add(lm.Clamp("root", plate.edge("x-")))
    angle = np.radians(65)
    x, y, z = (3.0 * _rotated(np.array(turn), np.array([np.sin(angle), 0.0, np.cos(angle)]))).tolist()
    system.add(lm.SolarFlux("sun", plate, (x, y, z), (TOP, BOTTOM), SUN))
    system.add(lm.Film("air", plate, 10.0, 0.0))
    result = lm.equilibrium(system)
    yield references.check("view of oblique light from below", float(result["sun.view"]))
    yield references.check("heat of oblique light from below", float(result["sun.heat"]))
    yield references.check("heat taken by the air", float(result["air.heat"] / result["sun.heat"]))


def _plate(system: lm.System, strain: Any, rotation: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> lm.Plate:
    """A plate that grows along x only, with its temperatures."""
    data = {"alpha1": ALPHA, "k1": K, "k2": K, "c": C}
    ply = lm.Lamina(E1=1e9, E2=1e9, G12=5e8, nu12=0.0, rho=RHO, **data)
    section = lm.Laminate(ply, thickness=H)
    plate = system.add(lm.Plate("plate", SIZE, (1 if strain == "rigid" else 8, 1), section, rotation=rotation, strain=strain))
    plate.marker("root", 0.0, 0.05)
    system.add(lm.TemperatureField("heat", plate))
    return plate


def _rotated(axis: Floats, vector: Floats) -> Floats:
    """Rodrigues' formula."""
    angle = float(np.linalg.norm(axis))
    e = axis / angle
    return np.cos(angle) * vector + np.sin(angle) * np.cross(e, vector) + (1 - np.cos(angle)) * (e @ vector) * e


def _solved(system: lm.System, t_end: float, n: int) -> Result:
    return lm.simulate(system, t_end, lm.GeneralizedAlpha(dt=t_end / n, heat="central_difference"))


def _largest(x: Floats) -> float:
    return float(np.abs(x).max())
