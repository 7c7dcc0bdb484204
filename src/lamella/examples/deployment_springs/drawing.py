"""The pictures of the study."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from lamella.result import Result
from lamella.roles import Floats
from lamella.study.measures import component

if TYPE_CHECKING:
    from lamella.study.study import Study

SHOWN = (0.0, 5.0, 8.0, 10.0, 20.0)
"""Times of the shaded pictures [s]."""


def show_all(study: Study, runs: Mapping[str, Result], momenta: Mapping[str, tuple[Floats, Floats]]) -> None:
    """Draw everything for the report page."""
    from lamella.examples.swing import animation_of
    from lamella.viz.plots import plot_curves, plot_energy
    from lamella.viz.scene import picture

    flexible = runs["flexible"]
    angles = {f"hinge {k}": (flexible.at, np.degrees(flexible.samples(f"hinge{k}.angle"))) for k in range(4)}
    study.show(
        plot_curves(angles, "Time [s]", "Angle [deg]", title="Hinge angles, flexible panels"),
        "hinges",
        "Angles of the hinges: cable loops keep them in step, 1 to 3 turning twice as far as 0, until the latches lock them.",
    )
    pitch = {name: (run.at, np.degrees(component(run, "satellite.euler", "pitch")[1])) for name, run in runs.items()}
    study.show(
        plot_curves(pitch, "Time [s]", "Angle about y [deg]", title="Attitude of the satellite"),
        "attitude",
        "The satellite turns against the unfolding array, and swings with it after latching.",
    )
    torque = {name: (run.at, run.samples("latch0.torque")) for name, run in runs.items()}
    study.show(
        plot_curves(torque, "Time [s]", "Torque [N m]", title="Latch at the root"),
        "latch",
        "Torque of the latch between yoke and first panel: the shock of locking, and the vibration that follows.",
    )
    speed = {}
    for name, (linear, angular) in momenta.items():
        at = runs[name].frame_at
        speed[f"linear [kg m/s], {name}"] = (at, np.linalg.norm(linear, axis=1))
        speed[f"angular [kg m²/s], {name}"] = (at, np.linalg.norm(angular, axis=1))
    study.show(
        plot_curves(speed, "Time [s]", "Momentum", title="Momenta of the whole system"),
        "momentum",
        "Linear and angular momentum, zero but for the integrator's error.",
    )
    study.show(plot_energy(flexible, title="Energy, flexible panels"), "energy", "Energies, and what their balance leaves over.")
    study.say("drawing the satellite")
    shape = picture(flexible, study.folder / "pictures" / "deployment.png", at=SHOWN, field="von_mises", title="True to scale")
    study.captions[shape] = "The deployment, coloured by the largest von Mises stress of all plies."
    study.files.append(shape)
    if moving := animation_of(study, "flexible", "deployment"):
        study.captions[moving] = "The deployment, without its outer frame of reference moving along."
