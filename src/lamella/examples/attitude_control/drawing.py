"""The pictures of the study."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from lamella.examples.attitude_control.control import PERIOD, reference
from lamella.result import Result
from lamella.roles import Floats
from lamella.study.measures import component

if TYPE_CHECKING:
    from lamella.study.study import Study

MOMENTS = (0.0, 30.0, 60.0, 120.0)
"""Times of the shaded picture [s]."""


def tip(run: Result) -> Floats:
    """Deflection of the panel's tip across the hub's axis of the panel [m]."""
    theta = run.samples("bearing.angle")
    x, z = component(run, "P.position", "x")[1], component(run, "P.position", "z")[1]
    return x * np.sin(theta) + z * np.cos(theta)


def show_all(study: Study, runs: Mapping[str, Result]) -> None:
    """Draw attitude, torque, tip, gradient and pointing error, and the moving panel."""
    from lamella.viz.plots import plot_curves
    from lamella.viz.scene import picture

    sunny = {name: run for name, run in runs.items() if name != "no sun"}
    first = runs["bending known"]
    attitude = {name: (run.at, np.degrees(run.samples("bearing.angle"))) for name, run in sunny.items()}
    wanted = {"wanted": (first.at[::40], np.degrees(reference(first.at[::40])))}
    study.show(
        plot_curves(attitude, "Time [s]", "Attitude [deg]", points=wanted),
        "attitude",
        "Attitude of the hub. The differences are too small to be seen here.",
    )
    errors = {n: (r.at, 1e3 * (r.samples("bearing.angle") - reference(r.at))) for n, r in runs.items()}
    study.show(
        plot_curves(errors, "Time [s]", "Pointing error [mrad]"),
        "pointing-error",
        "Attitude less what is wanted: the sun rises from 10 to 20 s, the satellite turns from 40 to 80 s.",
    )
    study.show(
        plot_curves({n: (r.at, r.samples("pilot.output")) for n, r in sunny.items()}, "Time [s]", "Torque [N m]"),
        "torque",
        "Torque of the wheel.",
    )
    held = np.arange(0.5 * PERIOD, first.at[-1], PERIOD)  # in the middle of each sample, where the torques are constant
    known, unknown = (np.interp(held, run.at, run.samples("pilot.output")) for run in (first, runs["bending unknown"]))
    study.show(
        plot_curves({"known less unknown": (held, known - unknown)}, "Time [s]", "Torque [N m]"),
        "torque-difference",
        "What the controller that knows of the bending asks for besides.",
    )
    study.show(
        plot_curves({name: (run.at, tip(run)) for name, run in runs.items()}, "Time [s]", "Deflection [m]"),
        "tip",
        "Deflection of the panel's tip in the hub's frame.",
    )
    study.show(
        plot_curves({name: (run.at, run.samples("P.T_M")) for name, run in runs.items()}, "Time [s]", "T_M [K/m]"),
        "gradient",
        "Temperature gradient through the thickness at the tip.",
    )
    study.say("drawing the satellite")
    shape = picture(
        first,
        study.folder / "pictures" / "satellite.png",
        at=[t for t in MOMENTS if t <= first.at[-1]],
        field="temperature_top",
        title="True to scale, coloured by the temperature of the top side",
        label="Temperature of the top, above the start [K]",
    )
    study.captions[shape] = "The satellite before sunrise, in the sun, during the slew and after it."
    study.files.append(shape)
