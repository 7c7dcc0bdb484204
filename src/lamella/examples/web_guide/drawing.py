"""The pictures of the study."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from lamella.examples.web_guide.curves import angle, edge, even, tension
from lamella.result import Result
from lamella.roles import Floats

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from lamella.examples.web_guide.study import Models, Runs
    from lamella.study.study import Study

VIEW = (-0.35, -0.6, -1.0)
"""Direction in which the camera looks: along the rollers, from above."""
FACTOR = 20.0
"""By which sideways motions are drawn larger than they are."""


def show_all(study: Study, runs: Runs, models: Models) -> None:
    """Draw the step response, the disturbance, the tracking, and the machine."""
    study.show(
        step_figure(runs, models),
        "step",
        "Response of the edge to a step of the steering angle: shell, ideal web without a fit, web with two fitted factors.",
    )
    study.show(
        course_figure(runs.held, models.held, runs, models, misaligned=True),
        "disturbance",
        "Roller 1 gets out of parallel at 0.7 s: edge, with the controller and without; steering angle; tensions of both edges.",
    )
    study.show(
        course_figure(runs.tracked, models.tracked, runs, models, misaligned=False),
        "tracking",
        "The set-point moves by 3 mm at 0.7 s: edge, steering angle, and tensions of both edges.",
    )
    study.show(
        above_figure(runs),
        "above",
        f"The machine from above: edges of the belt's upper strand, their sideways motion {FACTOR:g} times as large.",
    )
    study.say("drawing the belt")
    shaded(study, runs.held)


def step_figure(runs: Runs, models: Models) -> Figure:
    """The step response beside the linear models."""
    from lamella.viz.style import COLOURS, new_figure, styled

    with styled():
        figure = new_figure(3.4)
        axes = figure.subplots()
        t, z = edge(runs.step)
        axes.plot(t, 1e3 * (z - runs.rest), color=COLOURS[0], label="shell")
        for model, name, colour, style in zip(
            models.step, ("ideal web", "fitted"), (COLOURS[1], COLOURS[2]), ("--", ":"), strict=True
        ):
            axes.plot(even(runs.step), 1e3 * (model - runs.rest), style, color=colour, label=name)
        axes.set(xlabel="Time [s]", ylabel="Edge [mm]", xlim=(t[0], t[-1]))
        axes.legend()
    return figure


def course_figure(run: Result, model: tuple[Floats, Floats], runs: Runs, models: Models, *, misaligned: bool) -> Figure:
    """Edge, steering angle and tensions over time, with the controller, without, and of the linear model."""
    from lamella.examples.web_guide.study import AFTER, SHIFT
    from lamella.viz.style import COLOURS, new_figure, styled

    with styled():
        figure = new_figure(6.4)
        top, middle, bottom = figure.subplots(3, 1, sharex=True)
        grid = even(run)
        t, z = edge(run)
        top.plot(t, 1e3 * (z - runs.rest), color=COLOURS[0], label="controlled")
        top.plot(grid, 1e3 * (model[0] - runs.rest), "--", color=COLOURS[1], label="linear model")
        if misaligned:
            free, z = edge(runs.open)
            top.plot(free, 1e3 * (z - runs.rest), color=COLOURS[3], label="without controller")
            top.plot(even(runs.open), 1e3 * (models.open - runs.rest), ":", color=COLOURS[3], label="its linear model")
        else:
            begin = t[0] + AFTER
            top.plot(
                [t[0], begin, begin + AFTER, t[-1]], [0.0, 0.0, 1e3 * SHIFT, 1e3 * SHIFT], color="#8a95a3", label="set-point"
            )
        top.set(ylabel="Edge [mm]")
        middle.plot(run.at, 1e3 * angle(run), color=COLOURS[0], label="shell")
        middle.plot(grid, 1e3 * model[1], "--", color=COLOURS[1], label="linear model, command")
        middle.set(ylabel="Steering angle [mrad]")
        for end, colour in zip("ab", (COLOURS[0], COLOURS[2]), strict=True):
            bottom.plot(run.at, 1e-3 * tension(run, end), color=colour, label=f"edge {end}")
        bottom.set(ylabel="Tension [kN/m]", xlabel="Time [s]", xlim=(t[0], t[-1]))
        for axes in (top, middle, bottom):
            axes.legend(loc="upper left", bbox_to_anchor=(1.01, 1.02), borderaxespad=0.0)
    return figure


def above_figure(runs: Runs) -> Figure:
    """The upper strand from above, at the end of the runs with a misaligned roller 1."""
    from lamella.viz.style import new_figure, styled

    with styled():
        figure = new_figure(3.2)
        panels = figure.subplots(1, 2, sharey=True)
        for axes, run, name in zip(panels, (runs.open, runs.held), ("without controller", "with controller"), strict=True):
            _from_above(axes, run, f"{name}, {run.frame_at[-1]:.1f} s")
        panels[0].set_ylabel(f"Z [m], sideways motion x {FACTOR:g}")
    return figure


def _from_above(axes: Axes, run: Result, name: str) -> None:
    """Rollers, the edges of the upper strand, and the place of the sensor."""
    from lamella.viz.style import COLOURS, INK

    r = run.plate("belt", None, 4).r
    for roller in (1, 2):
        x = float(run.samples(f"roller{roller}.position")[-1, 0])
        tilt = float(run.history(f"roller{roller}.rotation").sel(component="xz").values[-1])
        z = np.array([-0.2, 0.2])
        centre = x + FACTOR * tilt * z
        axes.fill_betweenx(z, centre - 0.099, centre + 0.099, color="#e3e8ee", linewidth=0)
        axes.plot(centre, z, color="#8a95a3", linewidth=0.8)
        axes.text(x, -0.235, f"roller {roller}", ha="center", va="center", fontsize=9, color=INK)
    for row, rest in ((0, -0.15), (-1, 0.15)):
        upper = r[row, :, 1] > 0.0
        order = np.argsort(r[row, upper, 0])
        x, z = r[row, upper, 0][order], r[row, upper, 2][order]
        axes.axhline(rest, color="#8a95a3", linewidth=0.8, linestyle=":")
        axes.plot(x, rest + FACTOR * (z - rest), color=COLOURS[0])
    axes.plot([0.3], [0.15], "o", color=COLOURS[1], markersize=5)
    axes.set(xlabel="X [m]", title=name, ylim=(-0.26, 0.36), xlim=(-0.14, 0.76), aspect="equal")


def shaded(study: Study, run: Result) -> None:
    """The belt on its rollers, coloured by strain, and its motion."""
    from lamella.viz.scene import animation, picture

    folder = study.folder / "pictures"
    field, label = "membrane_strain.xx", "Membrane strain along the belt [–]"
    shape = picture(run, folder / "belt.png", field=field, view=VIEW, per_element=8, label=label)
    study.captions[shape] = "The belt with roller 1 out of parallel, held by the controller, coloured by its strain."
    moving = animation(run, folder / "motion.gif", field=field, view=VIEW, frames=40, per_element=6)
    study.captions[moving] = "The motion while roller 1 gets out of parallel and roller 2 is steered."
    study.files += [shape, moving]
