"""A panel that leaves the shadow: snap, flutter and decay against the closed forms of its first mode."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from scipy.optimize import least_squares

from lamella.errors import DeclarationError
from lamella.examples.swing import Numbers, excess, rounded
from lamella.examples.thermal_flutter import drawing
from lamella.examples.thermal_flutter.theory import FirstMode, first_mode
from lamella.result import Result
from lamella.roles import Floats
from lamella.study.findings import Finding
from lamella.study.measures import component
from lamella.system import System
from lamella.thermal.solar import SolarFlux

if TYPE_CHECKING:
    from lamella.study.study import Study

LOWEST = 0.5
"""Damping of the snap and of the run from the side of the tip [% of critical]."""
DAMPINGS = {8: (0.7, 2.0), 10: (LOWEST, 1.4, 2.1, 3.0), 16: (0.3, 1.4)}
"""Thickness [mm] and the damping ratios [%] of the runs with light from the side of the root."""
BASE = 10
SETTLED = 3.0
"""Periods after which gradient and higher modes have come to rest: the light's first effect on T_M has left less than 2e-3."""
OWN = ("laminates.panel.thickness", "system.panel.damping", "system.sun.model")
"""Values of the model that tell the variants apart."""
FINER = ("system.panel.mesh=[12, 1]", "analysis.flight.integrator.dt=50 ms")


@dataclass(frozen=True)
class Vibration:
    """``mean + amplitude exp(growth t) cos(frequency t + phase)``, fitted to a signal; t counts from the light.

    Args:
        growth: rate [1/s].
        frequency: angular [1/s].
        amplitude: at the time of the light [m].
        mean: [m].
    """

    growth: float
    frequency: float
    amplitude: float
    mean: float


@dataclass(frozen=True)
class Flight:
    """A variant's motion and its closed form.

    Args:
        thickness: of the panel [mm].
        zeta: damping ratio of the first mode.
        theory: the first mode.
        t: times since the light [s].
        z: of the tip [m].
        result: the motion.
        vibration: what the tip does when the snap is over.
    """

    thickness: int
    zeta: float
    theory: FirstMode
    t: Floats
    z: Floats
    result: Result
    vibration: Vibration


def study(study: Study) -> Iterator[Finding]:
    """Run the variants, draw the pictures, and yield the findings.

    Raises:
        DeclarationError: the user has replaced a value that tells the variants apart.
    """
    for text in study.overrides:
        if text.startswith(OWN):
            accepted = (
                "the study sets thickness, damping and the sun's model itself; accepted are other values, or the model file alone"
            )
            raise DeclarationError("thermal-flutter", f"the value {text} was given for all variants", accepted)
    base = study.read().system
    theory = {thickness: first_mode(study.read([thick(thickness)]).system) for thickness in DAMPINGS}
    snaps = [fly(study, f"snap-{h}mm", h, LOWEST, mode.uncoupled, ["system.sun.model=uncoupled"]) for h, mode in theory.items()]
    flights = [
        fly(study, f"root-{h}mm-damping-{zeta}", h, zeta, theory[h]) for h, dampings in DAMPINGS.items() for zeta in dampings
    ]
    away = fly(study, f"tip-{BASE}mm-damping-{LOWEST}", BASE, LOWEST, theory[BASE].mirrored, [mirrored(base)])
    first = next(flight for flight in flights if flight.thickness == BASE)
    finer = None if study.overrides else fly(study, "finer", BASE, LOWEST, theory[BASE], FINER)
    if study.draw:
        drawing.show_all(study, snaps, flights, away)
    yield snap(snaps)
    yield growth(flights)
    yield boundary(flights)
    yield side(first, away)
    if finer is not None:
        yield resolution(first, finer)


def thick(thickness: int) -> str:
    """The override for a thickness [mm]."""
    return f"laminates.panel.thickness={thickness} mm"


def mirrored(system: System) -> str:
    """The override for light from the other end."""
    x, y, z = next(item for item in system.declarations if isinstance(item, SolarFlux)).direction
    return f"system.sun.direction=[{-x}, {y}, {z}]"


def fly(study: Study, name: str, thickness: int, zeta: float, theory: FirstMode, more: Sequence[str] = ()) -> Flight:
    """Run a variant.

    Args:
        study: runs it.
        name: of the variant.
        thickness: of the panel [mm].
        zeta: damping ratio of the first mode [%].
        theory: its first mode.
        more: further overrides.
    """
    damping = f"system.panel.damping={0.02 * zeta / theory.omega:.12g} s"
    overrides = [thick(thickness), damping, *more]
    result = study.run(name, overrides)["flight"]
    assert isinstance(result, Result)
    t, z = component(result, "tip.position", "z")
    t = t - result.model.breakpoints[0]  # the light
    return Flight(thickness, zeta / 100, theory, t, z, result, free_vibration(t, z, theory.omega))


def free_vibration(t: Floats, z: Floats, omega: float) -> Vibration:
    """Fit a vibration to what is left of a signal after some periods, by least squares.

    Args:
        t: times since the light [s].
        z: signal.
        omega: angular frequency to start from [1/s].
    """
    kept = t > SETTLED * 2 * np.pi / omega
    t, z = t[kept], z[kept]

    def fitted(growth: float, frequency: float) -> tuple[Floats, Floats]:
        """Mean, cosine and sine for this growth and frequency, and what they leave over."""
        swing = np.exp(growth * t)
        columns = np.stack([np.ones_like(t), swing * np.cos(frequency * t), swing * np.sin(frequency * t)], axis=1)
        parts = np.asarray(np.linalg.lstsq(columns, z, rcond=None)[0], float)
        return parts, (columns @ parts - z) / np.ptp(z)

    found = least_squares(lambda x: fitted(*x)[1], [0.0, omega], x_scale=0.01 * omega, xtol=1e-12, ftol=1e-12).x
    mean, cosine, sine = fitted(*found)[0]
    return Vibration(float(found[0]), float(found[1]), float(np.hypot(cosine, sine)), float(mean))


def snap(snaps: Sequence[Flight]) -> Finding:
    """Sudden heat makes the panel swing with Boley's ratio."""
    numbers: Numbers = {}
    worst = 0.0
    for flight in snaps:
        theory, found = flight.theory, flight.vibration
        expected, name = theory.amplitude(flight.zeta), f"{flight.thickness} mm"
        off = excess(found.amplitude, expected)
        peak = float(theory.response(flight.zeta, flight.t).min())
        worst = max(worst, abs(off), abs(excess(float(flight.z.min()), peak)))
        numbers |= {
            f"omega tau, {name}": theory.delay,
            f"amplitude of the vibration, {name} [m]": found.amplitude,
            f"closed form, {name} [m]": expected,
            f"difference, {name} [%]": off,
            f"largest over quasi-static deflection, {name}": float(flight.z.min()) / -theory.rest,
            f"closed form with damping and the first mode's share, {name}": peak / -theory.rest,
            f"Boley 1 + 1 / sqrt(1 + (omega tau)^2), {name}": 1 + 1 / float(np.hypot(1, theory.delay)),
        }
    first = snaps[0].theory
    numbers |= {
        "quasi-static deflection of the tip [m]": -first.rest,
        "share of the first mode in it [%]": 100 * first.push / first.rest,
    }
    return Finding(
        "Sudden sunlight makes the panel swing about its quasi-static deflection, the less the slower its temperature follows: "
        "in one mode by 1 / sqrt(1 + (omega tau)^2) of it (Boley 1956).",
        worst < 3.0,
        rounded(numbers),
        "Boley's ratio takes the whole deflection for the first mode's and leaves out damping: it is an upper bound here. The "
        "other modes follow the temperature almost at rest.",
    )


def growth(flights: Sequence[Flight]) -> Finding:
    """Vibration grows and decays as the root of the cubic says."""
    numbers: Numbers = {"gain": flights[0].theory.gain}
    agrees = True
    for flight in flights:
        theory, found, zeta = flight.theory, flight.vibration, flight.zeta
        one, four = theory.pole(zeta), theory.pole_of_four(zeta)
        name = f"{flight.thickness} mm, {100 * zeta:.1f} %"
        agrees &= abs(found.growth - four.real) < 0.03 * theory.omega * theory.critical_damping()
        agrees &= abs(excess(found.frequency, four.imag)) < 1.0
        numbers |= {
            f"growth, {name} [1/s]": found.growth,
            f"root of the cubic, {name} [1/s]": one.real,
            f"with four modes, {name} [1/s]": four.real,
            f"angular frequency, {name} [1/s]": found.frequency,
            f"imaginary part of the root, {name} [1/s]": one.imag,
        }
    return Finding(
        "Where heat follows the slope, the vibration grows or decays with the rate of the third-order system of mode and heat "
        "(Thornton and Kim 1993).",
        agrees,
        rounded(numbers),
        "Agreement is asked to 3 % of the damping at the boundary, with four modes heated: the next ones bend with the heat that "
        "the first one causes, turn with it, and add to its growth.",
    )


def boundary(flights: Sequence[Flight]) -> Finding:
    """The damping that divides growth from decay is that of Routh and Hurwitz."""
    numbers: Numbers = {}
    agrees = all((flight.vibration.growth > 0) == (flight.zeta < flight.theory.critical_damping()) for flight in flights)
    for thickness in DAMPINGS:
        group = [flight for flight in flights if flight.thickness == thickness]
        theory, name = group[0].theory, f"{thickness} mm"
        found, routh = crossing([(flight.zeta, flight.vibration.growth) for flight in group]), theory.critical_damping()
        agrees &= not abs(excess(found, routh)) > 5.0  # NaN when all runs lie on one side
        numbers |= {
            f"omega tau, {name}": theory.delay,
            f"damping at the boundary, {name} [%]": 100 * found,
            f"Routh-Hurwitz, {name} [%]": 100 * routh,
            f"with four modes, {name} [%]": 100 * theory.critical_damping_of_four(),
        }
    return Finding(
        "Vibration grows where the damping ratio is below the limit of the Routh-Hurwitz criterion, about gain omega tau / "
        "(2 (1 + (omega tau)^2)): most at omega tau = 1.",
        agrees,
        rounded(numbers),
        "Found where the rates of growth of runs on either side pass zero.",
    )


def crossing(points: Sequence[tuple[float, float]]) -> float:
    """Where a line through neighbouring points (x, y) passes y = 0; NaN when none does."""
    for (x0, y0), (x1, y1) in pairwise(points):
        if y0 * y1 < 0:
            return x0 - y0 * (x1 - x0) / (y1 - y0)
    return float("nan")


def side(root: Flight, tip: Flight) -> Finding:
    """Light from the side of the root drives the vibration, light from the side of the tip damps it."""
    without = root.theory.uncoupled.pole(root.zeta).real
    drives, damps = root.vibration.growth - without, without - tip.vibration.growth
    return Finding(
        "Light that travels from root to tip drives the vibration, light that travels from tip to root damps it as much.",
        drives > 0 and abs(excess(damps, drives)) < 10.0,
        rounded(
            {
                "growth, light from the side of the root [1/s]": root.vibration.growth,
                "growth, light from the side of the tip [1/s]": tip.vibration.growth,
                "root of the cubic, light from the side of the tip [1/s]": tip.theory.pole(tip.zeta).real,
                "with four modes, light from the side of the tip [1/s]": tip.theory.pole_of_four(tip.zeta).real,
                "growth that structural damping alone would give [1/s]": without,
            }
        ),
        "A panel that bends away from light from the side of the root turns its face from it: the loss of heat pushes it back, "
        "but late, and what pushes back late is partly in phase with the velocity.",
    )


def resolution(first: Flight, finer: Flight) -> Finding:
    """Mesh and step are fine enough."""
    change = finer.vibration.growth - first.vibration.growth
    part = 100 * change / (first.theory.omega * first.theory.critical_damping())
    frequency = excess(finer.vibration.frequency, first.vibration.frequency)
    last = first.result.samples("tip.T_N")[-1]
    return Finding(
        "Check of our own: mesh and step are fine enough, and the mean temperature stays out of it.",
        abs(part) < 2.0 and abs(frequency) < 1.0,
        rounded(
            {
                "change of growth on a finer mesh, of the damping at the boundary [%]": part,
                "change of frequency on a finer mesh [%]": frequency,
                "amplitude at the start, change on a finer mesh [%]": excess(
                    finer.vibration.amplitude, first.vibration.amplitude
                ),
                "T_N of the tip at the end [K]": float(last),
            }
        ),
        "12x1 elements and steps of 50 ms against 8x1 and 80 ms.",
    )
