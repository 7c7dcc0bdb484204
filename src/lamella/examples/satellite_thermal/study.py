"""A panel in the sun on a turning satellite: the paper's coupled, uncoupled and linear models, and how the root is clamped."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from lamella.examples.satellite_thermal import drawing
from lamella.examples.swing import Numbers, rounded
from lamella.result import Result
from lamella.roles import Floats
from lamella.study.findings import Finding
from lamella.study.measures import component, dominant_frequency
from lamella.study.study import Study

LENGTH, H, K, ALPHA = 7.5, 0.0103, 1.5, 2.3e-5
FLUX = 0.79 * 1350.0
INCIDENCE = np.radians(65.0)
COASTING, RESTING = (30.0, 175.0), (210.0, 250.0)
LINEAR = ("system.panel.strain=floating", "system.panel.frame_at=x-")
VARIANTS: Mapping[str, tuple[str, ...]] = {
    "coupled": (),
    "uncoupled": ("system.sun.model=uncoupled",),
    "linear": LINEAR,
    "sliding": ("system.root.kind=sliding",),
}
Runs = Mapping[str, Result]


def study(study: Study) -> Iterator[Finding]:
    """Run the models, draw the paper's figures 4 to 8, and yield the findings."""
    runs: dict[str, Result] = {}
    for name, overrides in VARIANTS.items():
        result = study.run(name, overrides, pictures=name == "coupled")["flight"]
        assert isinstance(result, Result)
        runs[name] = result
    if study.draw:
        drawing.show_all(study, runs)
    yield angle(runs)
    yield gradient(runs)
    yield tip(runs)
    yield nonlinear(runs)
    yield growth(runs)
    yield clamp(runs)


def deflections(run: Result) -> tuple[Floats, Floats, Floats]:
    """Time [s] and the deflection of P [m] along and across the undeformed panel, which turns with the hub."""
    theta = run.samples("bearing.angle")
    x, z = component(run, "P.position", "x")[1], component(run, "P.position", "z")[1]
    return run.at, x * np.cos(theta) - z * np.sin(theta) - LENGTH, x * np.sin(theta) + z * np.cos(theta)


def during(t: Floats, values: Floats, span: tuple[float, float]) -> Floats:
    """The values within a span of time [s]."""
    return values[(t >= span[0]) & (t <= span[1])]


def angle(runs: Runs) -> Finding:
    """The hub turns alike in all models."""
    ends = {name: float(run.samples("bearing.angle")[-1]) for name, run in runs.items()}
    numbers: Numbers = {f"angle of the hub at the end, {name} [rad]": value for name, value in ends.items()}
    spread = max(ends.values()) - min(ends.values())
    numbers["largest difference [%]"] = 100.0 * spread / ends["coupled"]
    return Finding(
        "The hub's angle is nearly the same with and without coupling, and in the linear model.",
        spread < 0.01 * ends["coupled"],
        rounded(numbers),
    )


def gradient(runs: Runs) -> Finding:
    """T_M follows the turning panel when coupled, and is constant when not."""
    numbers: Numbers = {}
    t, T_M = runs["coupled"].at, runs["coupled"].samples("P.T_M")
    turning = during(t, T_M, COASTING)
    rate = (component(runs["coupled"], "hub.angular_velocity", "y")[1])[np.searchsorted(t, 100.0)]
    times = during(t, t, COASTING)
    even = np.linspace(times[0], times[-1], len(times))
    numbers["coupled, coasting: smallest T_M [K/m]"] = float(turning.min())
    numbers["coupled, coasting: largest T_M [K/m]"] = float(turning.max())
    numbers["largest steady T_M of light at right angles, alpha S / (2 k) [K/m]"] = FLUX / (2.0 * K)
    numbers["coupled, coasting: main period of T_M [s]"] = 1.0 / dominant_frequency(even, np.interp(even, times, turning))
    numbers["time of one turn [s]"] = float(2.0 * np.pi / rate)
    resting = during(t, T_M, RESTING)
    numbers["coupled, at rest: T_M, mean [K/m]"] = float(resting.mean())
    numbers["coupled, at rest: T_M, standard deviation [K/m]"] = float(resting.std())
    fixed = during(runs["uncoupled"].at, runs["uncoupled"].samples("P.T_M"), (5.0, 250.0))
    numbers["uncoupled, from 5 s: T_M, mean [K/m]"] = float(fixed.mean())
    numbers["uncoupled, from 5 s: range of T_M [K/m]"] = float(np.ptp(fixed))
    numbers["steady T_M at 65 deg, alpha S cos 65 / (2 k) [K/m]"] = float(FLUX * np.cos(INCIDENCE) / (2.0 * K))
    agrees = np.ptp(turning) > 600.0 and resting.std() < 5.0 and np.ptp(fixed) < 0.01
    return Finding(
        "Coupled, the temperature gradient is periodic while the satellite turns and constant after; uncoupled, it is constant.",
        bool(agrees),
        rounded(numbers),
        "The panel settles in 0.2 s (rho c h^2 / 12 k). At rest it still vibrates, and the gradient with it.",
    )


def tip(runs: Runs) -> Finding:
    """The tip moves slowly with the gradient and fast with its first bending mode."""
    t, _, across = deflections(runs["coupled"])
    times, moved = during(t, t, COASTING), during(t, across, COASTING)
    T_M = during(t, runs["coupled"].samples("P.T_M"), COASTING)
    slow = np.polyval(np.polyfit(T_M, moved, 1), T_M)
    even = np.linspace(times[0], times[-1], len(times))
    fast = dominant_frequency(even, np.interp(even, times, moved - slow))
    numbers: Numbers = {
        "coasting: smallest deflection of P [m]": float(moved.min()),
        "coasting: largest deflection of P [m]": float(moved.max()),
        "share of the deflection's variance that follows T_M": float(1.0 - np.var(moved - slow) / np.var(moved)),
        "frequency of the rest [Hz]": float(fast),
        "first bending frequency of the cold panel, beam theory [Hz]": float(
            1.8751**2 / (2 * np.pi * LENGTH**2) * np.sqrt(1.93e9 / (1 - 0.3**2) * H**2 / 12 / 36.8)
        ),
    }
    agrees = float(numbers["share of the deflection's variance that follows T_M"]) > 0.9 and 0.1 < fast < 0.4
    return Finding(
        "The tip's deflection is a slow oscillation at the frequency of the temperature gradient plus a fast one.",
        agrees,
        rounded(numbers),
    )


def resting_mean(run: Result) -> float:
    """Mean deflection of P at rest [m]."""
    t, _, across = deflections(run)
    return float(during(t, across, RESTING).mean())


def nonlinear(runs: Runs) -> Finding:
    """The heated, axially strained panel bends more than linear theory says."""
    means = {name: resting_mean(run) for name, run in runs.items()}
    numbers: Numbers = {f"at rest: mean deflection of P, {name} [m]": value for name, value in means.items()}
    numbers["coupled over linear"] = means["coupled"] / means["linear"]
    numbers["beam theory, alpha T_M L^2 / 2 with the mean T_M [m]"] = float(
        -0.5 * ALPHA * LENGTH**2 * during(runs["coupled"].at, runs["coupled"].samples("P.T_M"), RESTING).mean()
    )
    return Finding(
        "At rest the mean deflection of the nonlinear model is larger than that of the linear one.",
        abs(means["coupled"]) > 1.01 * abs(means["linear"]),
        rounded(numbers),
        "The excess is the work of the restrained root, which holds back the growth across the panel: with a root that slides, "
        "it is gone. Its size depends on clamp and mesh; the paper gives no number.",
    )


def growth(runs: Runs) -> Finding:
    """The panel grows with its mean temperature, in ripples."""
    t, along, _ = deflections(runs["coupled"])
    T_N = runs["coupled"].samples("P.T_N")
    numbers: Numbers = {
        "axial growth of P at the end, coupled [m]": float(along[-1]),
        "alpha T_N L at the end [m]": float(ALPHA * T_N[-1] * LENGTH),
        "T_N at the end, coupled [K]": float(T_N[-1]),
        "axial growth of P at the end, uncoupled [m]": float(deflections(runs["uncoupled"])[1][-1]),
    }
    rate = np.diff(along[(t > 30.0) & (t < 175.0)])
    numbers["coasting: share of steps in which P draws back"] = float(np.mean(rate < 0.0))
    smooth = np.polyval(np.polyfit(t, along, 3), t)
    numbers["ripples about a smooth curve, standard deviation [m]"] = float(np.std(along - smooth))
    return Finding(
        "The panel's axial growth rises slowly with periodic ripples.",
        bool(along[-1] > 0.05 and np.std(along - smooth) > 1e-4),
        rounded(numbers),
        "Nothing cools the panel in the paper's example, so its temperature rises as long as the sun shines.",
    )


def clamp(runs: Runs) -> Finding:
    """What the clamp decides."""
    numbers: Numbers = {f"at rest: mean deflection of P, {name} [m]": resting_mean(runs[name]) for name in ("coupled", "sliding")}
    ratio = float(numbers["at rest: mean deflection of P, coupled [m]"]) / float(
        numbers["at rest: mean deflection of P, sliding [m]"]
    )
    numbers["restrained over sliding"] = ratio
    return Finding(
        "Check of our own: a root that may grow along itself bends as linear theory says; a restrained one bends further.",
        1.02 < ratio < 1.5,
        rounded(numbers),
        "A root whose slopes are held entirely (kind: full) would buckle by heat in its first element, which is no physics: "
        "see the page on heat.",
    )
