"""The pictures of the study."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from lamella.result import Result
from lamella.study.measures import component

if TYPE_CHECKING:
    from lamella.study.study import Study

SHOWN = ("coupled", "uncoupled", "linear")
"""The models of the paper's figures."""
MOMENTS = (0.0, 40.0, 80.0, 125.0, 250.0)
"""Times of the shaded picture [s]."""


def show_all(study: Study, runs: Mapping[str, Result]) -> None:
    """Draw figures 4 to 8 of the paper and the moving panel."""
    from lamella.examples.satellite_thermal.study import deflections
    from lamella.viz.plots import plot_curves
    from lamella.viz.scene import picture

    chosen = {name: runs[name] for name in SHOWN}
    study.show(
        plot_curves({n: (r.at, r.samples("bearing.angle")) for n, r in chosen.items()}, "Time [s]", "Angle [rad]"),
        "hub-angle",
        "Figure 4: angle of the hub.",
    )
    speed = {n: (r.at, component(r, "hub.angular_velocity", "y")[1]) for n, r in chosen.items()}
    study.show(
        plot_curves(speed, "Time [s]", "Angular velocity [rad/s]"),
        "hub-speed",
        "Figure 5: angular velocity of the hub; it vibrates with the panel.",
    )
    study.show(
        plot_curves({n: (r.at, r.samples("P.T_M")) for n, r in chosen.items()}, "Time [s]", "T_M [K/m]"),
        "gradient",
        "Figure 6: temperature gradient through the thickness at P.",
    )
    parts = {name: deflections(run) for name, run in chosen.items()}
    study.show(
        plot_curves({n: (t, along) for n, (t, along, _) in parts.items()}, "Time [s]", "Growth [m]"),
        "along",
        "Figure 7: displacement of P along the panel.",
    )
    study.show(
        plot_curves({n: (t, across) for n, (t, _, across) in parts.items()}, "Time [s]", "Deflection [m]"),
        "across",
        "Figure 8: displacement of P across the panel.",
    )
    study.say("drawing the satellite")
    shape = picture(
        runs["coupled"],
        study.folder / "pictures" / "satellite.png",
        at=MOMENTS,
        field="temperature_top",
        title="True to scale, coloured by the temperature of the top side",
    )
    study.captions[shape] = f"The satellite at {', '.join(f'{t:g}' for t in np.asarray(MOMENTS))} s."
    study.files.append(shape)
