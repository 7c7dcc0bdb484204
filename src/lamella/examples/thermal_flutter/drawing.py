"""The pictures of the study."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from lamella.examples.thermal_flutter.study import Flight
    from lamella.study.study import Study


def show_all(study: Study, snaps: Sequence[Flight], flights: Sequence[Flight], away: Flight) -> None:
    """Draw everything for the report page."""
    study.show(
        tips(snaps, flights, away),
        "tip",
        "Deflection of the tip after sudden sunlight, 10 mm. Above: the heat stays what the undeformed panel absorbs; below: it "
        "follows the slope, and the vibration grows or decays with the side from which the light comes and with damping.",
    )
    study.show(
        stability(flights),
        "stability",
        "Damping that stability needs over the ratio of the times of heat and vibration: the criterion of Routh and Hurwitz for "
        "the first mode (line), and runs of panels of 8, 10 and 16 mm.",
    )
    study.show(
        boley(snaps),
        "snap",
        "The snap of panels of three thicknesses, all with the same quasi-static deflection: the vibration left over is the "
        "smaller the slower the temperature follows.",
    )


def tips(snaps: Sequence[Flight], flights: Sequence[Flight], away: Flight) -> Figure:
    """Tip over time: quasi-static and dynamic, uncoupled and coupled, stable and unstable."""
    from lamella.viz.style import COLOURS, DASHES, new_figure, styled

    snap = next(flight for flight in snaps if flight.thickness == away.thickness)
    group = [flight for flight in flights if flight.thickness == away.thickness]
    still = -snap.theory.rest * -np.expm1(-np.maximum(snap.t, 0.0) / snap.theory.tau)
    with styled():
        figure = new_figure(5.6)
        upper, lower = figure.subplots(2, 1, sharex=True, sharey=True)
        upper.plot(snap.t, still, color=COLOURS[1], linestyle=DASHES[1], label="quasi-static")
        upper.plot(snap.t, snap.z, color=COLOURS[0], label=f"run, damping {100 * snap.zeta:.1f} %")
        _mark_closed_form(upper, snap)
        upper.set(title="(a) uncoupled: the snap", ylabel="Tip [m]")
        for number, flight in enumerate((group[0], group[-1], away)):
            label = f"from the {'tip' if flight is away else 'root'}, {100 * flight.zeta:.1f} %"
            lower.plot(flight.t, flight.z, color=COLOURS[(1, 0, 2)[number]], linestyle=DASHES[number], label=label)
        lower.set(
            title="(b) coupled: heat follows the slope; side of the light, and damping",
            ylabel="Tip [m]",
            xlabel="Time since the light [s]",
        )
        for axes in (upper, lower):
            axes.margins(x=0.01)
            axes.legend(loc="lower left", ncols=3, columnspacing=1.2)
        low, high = lower.get_ylim()
        lower.set_ylim(low - 0.2 * (high - low), high)
    return figure


def _mark_closed_form(axes: Axes, flight: Flight) -> None:
    from lamella.viz.style import INK

    t = np.linspace(0.0, float(flight.t[-1]), 100)
    z = flight.theory.response(flight.zeta, t)
    axes.plot(t, z, "o", markerfacecolor="white", markeredgecolor=INK, markersize=3.5, label="closed form", zorder=3)


def stability(flights: Sequence[Flight]) -> Figure:
    """Damping at the boundary over omega tau, and the runs."""
    from dataclasses import replace

    from lamella.viz.style import COLOURS, FAINT, INK, new_figure, styled

    some = flights[0].theory
    delay = np.geomspace(0.1, 10.0, 200)
    limit = np.array([replace(some, tau=p / some.omega).critical_damping() for p in delay])
    with styled():
        figure = new_figure(3.6)
        axes = figure.subplots()
        axes.fill_between(delay, 100 * limit, color=FAINT, alpha=0.6, linewidth=0)
        axes.plot(delay, 100 * limit, color=INK, label="Routh and Hurwitz, first mode")
        for grows, marker, colour, label in (
            (True, "^", COLOURS[1], "run that grows"),
            (False, "v", COLOURS[0], "run that decays"),
        ):
            chosen = [flight for flight in flights if (flight.vibration.growth > 0) == grows]
            places = [flight.theory.delay for flight in chosen], [100 * flight.zeta for flight in chosen]
            axes.plot(*places, marker, color=colour, markersize=7, label=label)
        for thickness in sorted({flight.thickness for flight in flights}):
            of_it = [flight for flight in flights if flight.thickness == thickness]
            top = max(of_it, key=lambda flight: flight.zeta)
            place = top.theory.delay, 100 * top.zeta
            axes.annotate(f"{thickness} mm", place, (0, 7), textcoords="offset points", fontsize=8.5, ha="center")
        axes.text(1.0, 0.15, "flutter", ha="center", color=INK)
        axes.set(xscale="log", xlabel="Time constant of heat times angular frequency [–]", ylabel="Damping ratio [%]")
        axes.set_title(f"Stability, light almost edge-on from the side of the root, gain {some.gain:.3f}")
        axes.set_xticks([0.1, 0.3, 1, 3, 10], ["0.1", "0.3", "1", "3", "10"])
        axes.set_xlim(0.1, 10.0)
        axes.set_ylim(0.0, 3.6)
        axes.legend(loc="upper left")
    return figure


def boley(snaps: Sequence[Flight]) -> Figure:
    """The first periods of the snap over the quasi-static deflection, and the amplitude over omega tau."""
    from lamella.viz.style import COLOURS, DASHES, INK, new_figure, styled

    delay = np.geomspace(0.1, 10.0, 200)
    with styled():
        figure = new_figure(3.4)
        left, right = figure.subplots(1, 2, width_ratios=(3, 2))
        for number, flight in enumerate(snaps):
            shown = (flight.t > -1.0) & (flight.t < 14.0)
            label = f"{flight.thickness} mm, $\\omega\\tau$ = {flight.theory.delay:.2f}"
            share = -flight.z[shown] / flight.theory.rest
            left.plot(flight.t[shown], share, color=COLOURS[number], linestyle=DASHES[number], label=label)
            ratio = flight.vibration.amplitude / flight.theory.push
            right.plot(flight.theory.delay, ratio, "os^"[number], color=COLOURS[number], markersize=6, zorder=3)
        left.axhline(1.0, color=INK, linewidth=0.8)
        left.set(title="Tip over quasi-static deflection", xlabel="Time since the light [s]", ylabel="[–]")
        left.set_ylim(top=2.6)
        left.margins(x=0.01)
        left.legend(loc="upper right")
        right.plot(delay, 1 / np.hypot(1.0, delay), color=INK, label="$1/\\sqrt{1 + (\\omega\\tau)^2}$")
        right.set(xscale="log", xlabel="$\\omega\\tau$ [–]", ylabel="Amplitude over static [–]", title="First mode")
        right.set_xticks([0.1, 1, 10], ["0.1", "1", "10"])
        right.set_ylim(0.0, 1.1)
        right.legend(loc="lower left")
    return figure
