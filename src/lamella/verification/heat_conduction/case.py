"""Heat in a plate: through its thickness, along a strip, radiated to space, and the balance of what is stored and supplied."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal

import numpy as np

import lamella as lm
from lamella.result import Result
from lamella.verification import Check, Curves, Evidence, Orders, References

slow = False

RHO, C, K, H = 2000.0, 900.0, 1.5, 0.01
AREA_CAPACITY, RELAXATION = RHO * C * H, RHO * C * H**2 / (12 * K)  # [J/(m^2 K)], [s]
FLUX, AMBIENT, START = 300.0, 330.0, 280.0
SIZE, LENGTH = (0.2, 0.1), 0.2
EMISSIVITY, SPACE = 0.8, 3.0
Rule = Literal["generalized_alpha", "central_difference"]


def panel(mesh: tuple[int, int] = (1, 1)) -> tuple[lm.System, lm.Plate]:
    """A rigid plate at 280 K that nothing moves, so that heat is all there is."""
    sheet = lm.Laminate(lm.Isotropic(E=1e9, nu=0.3, rho=RHO, k=K, c=C), thickness=H)
    system = lm.System()
    plate = system.add(lm.Plate("plate", SIZE, mesh, sheet, strain="rigid"))
    plate.marker("middle", 0.5 * LENGTH, 0.5 * SIZE[1])
    system.add(lm.Clamp("root", plate.edge("x-")))
    system.add(lm.TemperatureField("heat", plate, reference=START))
    return system, plate


def run() -> Iterator[Evidence]:
    """Yield the checks and pictures of this case."""
    references = References.beside(__file__)
    yield from _flux(references)
    yield from _film(references)
    yield from _strip(references)
    yield from _space(references)
    yield from _balance(references)
    yield from _orders(references)


def _flux(references: References) -> Iterator[Evidence]:
    """A flux into the top of a slab whose bottom is insulated."""
    system, plate = panel()
    system.add(lm.HeatFlux("lamp", plate, "top", FLUX))
    result = _solved(system, RELAXATION * 4, 200)
    at = np.searchsorted(result.at, RELAXATION * np.array([1.0, 2.0, 4.0]) * (1 - 1e-9))
    gradient = result["middle.T_M"].values[at]
    steady = FLUX / (2 * K)
    yield references.check("T_N under flux", result["middle.T_N"].values[-1] * AREA_CAPACITY / (FLUX * result.at[-1]))
    yield from references.checks("T_M under flux, share of q / 2k", gradient / steady)
    yield from references.checks("T_M under flux beside the series, share of q / 2k", gradient / steady)
    names = {"two equations": "T_M under flux, share of q / 2k", "series": "T_M under flux beside the series, share of q / 2k"}
    curve = {"lamella": (result.at / RELAXATION, result["middle.T_M"].values / steady)}
    points = {label: references.points(name) for label, name in names.items()}
    yield Curves("Gradient under a flux into one side", "t / τ [–]", "T_M / (q / 2k) [–]", curve, points)


def _film(references: References) -> Iterator[Evidence]:
    """A film of Bi = h_c h / k = 0.2 warms the top of a slab; Fo = k t / (rho c h^2)."""
    system, plate = panel()
    system.add(lm.Film("air", plate, 0.2 * K / H, AMBIENT, sides="top"))
    fourier = np.array(references.at("mean beside the series"))
    unit = RHO * C * H**2 / K
    result = _solved(system, unit * fourier[-1], 400)
    at = np.searchsorted(result.at, unit * fourier * (1 - 1e-9))
    left = 1.0 - (result["heat.mean"].values[at] - START) / (AMBIENT - START)
    yield from references.checks("mean by the two equations", left)
    yield from references.checks("mean beside the series", left)
    names = {"two equations": "mean by the two equations", "series": "mean beside the series"}
    curve = {"lamella": (result.at / unit, 1.0 - (result["heat.mean"].values - START) / (AMBIENT - START))}
    points = {label: references.points(name) for label, name in names.items()}
    yield Curves("Mean temperature beside a film, Bi = 0.2", "Fo [–]", "(T_air − T) / (T_air − T_0) [–]", curve, points)


def _strip(references: References) -> Iterator[Evidence]:
    """Heat arises evenly in a strip whose ends are held cold: T = Q/2k (x (L - x) - series)."""
    found = []
    time = 0.1 * LENGTH**2 * RHO * C / K
    for n in (4, 8, 16):
        system, plate = panel((n, 1))
        system.add(lm.HeatSource("heater", plate, 1e5))
        for side in ("x-", "x+"):
            system.add(lm.PrescribedTemperature(side, plate.edge(side), START))
        found.append(float(_solved(system, time, 100)["middle.T_N"].values[-1]) * 8 * K / (1e5 * LENGTH**2))
    exact = references.value("middle of the strip, share of Q L^2 / 8k")
    yield references.check("middle of the strip, share of Q L^2 / 8k", found[-1])
    for coarse, fine, name in ((0, 1, "4 and 8"), (1, 2, "8 and 16")):
        order = float(np.log2((found[coarse] - exact) / (found[fine] - exact)))
        yield references.check(f"order in the mesh, {name} elements", order)
    errors = {"middle of the strip": (LENGTH / np.array([4, 8, 16]), np.abs(np.array(found) / exact - 1))}
    yield Orders("A source in a strip with cold ends", "Element [m]", errors, (2,))


def _space(references: References) -> Iterator[Check]:
    """A plate between a heater and cold space, and one in the sun."""
    system, plate = panel()
    system.add(lm.HeatSource("heater", plate, 2e4))
    system.add(lm.Radiation("space", plate, EMISSIVITY, SPACE))
    yield references.check("temperature of a heated plate in space", float(lm.equilibrium(system)["heat.mean"]))
    system, plate = panel()
    system.add(lm.SolarFlux("sun", plate, (0, 0, -1), 0.7, 1350.0))
    system.add(lm.Radiation("space", plate, EMISSIVITY, SPACE))
    result = lm.equilibrium(system)
    mean, half = float(result["heat.mean"]), 0.5 * H * float(result["middle.T_M"])
    yield references.check("temperature of the lit side", mean + half)
    yield references.check("temperature of the dark side", mean - half)


def _exchange(n: int, rule: Rule) -> Result:
    """Radiation, a film and a flux that changes, over 1000 s in n steps."""
    system, plate = panel((2, 1))
    system.add(lm.HeatFlux("lamp", plate, "top", 3e3, profile=lm.Harmonic(1.0, 1 / 700.0, mean=1.0)))
    system.add(lm.Radiation("space", plate, EMISSIVITY, SPACE))
    system.add(lm.Film("air", plate, 5.0, AMBIENT, sides="bottom"))
    return _solved(system, 1000.0, n, rule)


def _balance(references: References) -> Iterator[Check]:
    """What the trapezoidal rule stores is the trapezoidal sum of what is supplied."""
    result = _exchange(100, "central_difference")
    supplied = sum(np.trapezoid(result[f"{name}.heat"].values, result.at) for name in ("lamp", "space", "air"))
    yield references.check("stored less supplied, share of the stored", result["heat.heat"].values[-1] / supplied - 1)


def _orders(references: References) -> Iterator[Check]:
    rules: tuple[Rule, ...] = ("generalized_alpha", "central_difference")
    for rule in rules:
        coarse, fine, finest = (_exchange(n, rule).final.q[-4:] for n in (50, 100, 200))
        order = float(np.log2(np.abs(coarse - fine).max() / np.abs(fine - finest).max()))
        yield references.check(f"order in time, {rule}", order)


def _solved(system: lm.System, t_end: float, n: int, rule: Rule = "central_difference") -> Result:
    newton = lm.Newton(tolerance=1e-11)
    return lm.simulate(system, t_end, lm.GeneralizedAlpha(dt=t_end / n, rho_inf=0.8, heat=rule, newton=newton))
