"""The pictures of the study."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from lamella.result import Result
from lamella.roles import Floats
from lamella.study.measures import component

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from lamella.study.study import Study

VIEW = (0.0, -0.45, 1.0)
"""Direction in which the camera looks: along the rollers, from above; X points to the left."""
MOMENTS = (0.0, 0.07, 0.2, 0.45, 0.7, 1.0)
"""Times of the snapshots, as shares of the run."""


def show_all(study: Study, runs: Mapping[str, Result]) -> None:
    """Draw figures 7 to 12 of the paper."""
    from lamella.examples.corrugator.study import LENGTH, WIDTH, centre_von_mises, loop_mean, tilt, touching
    from lamella.viz.plots import plot_curves

    run = runs["unequal"]
    moved = {}
    for name, result in runs.items():
        x = component(result, "roller2.position", "x")[1]
        moved[name] = (result.at, 1e3 * (x - x[0]))
    study.show(
        plot_curves(moved, "Time [s]", "Displacement along X [mm]"),
        "roller2",
        "Figure 7: displacement of tension roller 2 along X.",
    )
    study.show(
        plot_curves({n: (tilt(r)[0], 1e3 * tilt(r)[1]) for n, r in runs.items()}, "Time [s]", "Tilt [mrad]"),
        "tilt",
        "Tilt of tension roller 2 about the vertical, positive where the end that is pulled less is nearer to roller 1.",
    )
    offset = {n: (r.frame_at, 1e3 * loop_mean(r)) for n, r in runs.items()}
    point = {"centre of the belt, unequal": (run.at, 1e3 * component(run, "centre.position", "z")[1])}
    study.show(
        plot_curves({**offset, **point}, "Time [s]", "Offset along Z [mm]"),
        "drift",
        "Figure 8: offset of the belt along Z, averaged around the loop; its centre moves to and fro in each turn.",
    )
    pressure, friction = touching(run, -1)
    study.show(
        contact_map(pressure, friction, LENGTH, WIDTH),
        "contact",
        "Figure 9: forces of contact on the unrolled belt at the end: a strip from each roller.",
    )
    study.show(
        plot_curves({"centre": (run.frame_at, 1e-6 * centre_von_mises(run))}, "Time [s]", "Von Mises stress [MPa]"),
        "stress",
        "Figure 10: von Mises stress at the belt's centre, on the side where it is larger.",
    )
    x, y = component(run, "centre.position", "x")[1], component(run, "centre.position", "y")[1]
    study.show(
        path(x, y, component(run, "centre.position", "z")[1]),
        "path",
        "Figure 12 (f): path of the belt's centre, from the side and from above.",
    )
    study.say("drawing the belt")
    shaded(study, run)


def show_meshes(study: Study, errors: Mapping[str, Mapping[int, float]]) -> None:
    """Errors of the displacement of roller 2 at rest, by strain model and number of elements."""
    from lamella.viz.style import COLOURS, new_figure, styled

    with styled():
        figure = new_figure(3.2)
        axes = figure.subplots()
        for (strain, found), colour in zip(errors.items(), COLOURS, strict=False):
            axes.loglog(list(found), [1e3 * abs(error) for error in found.values()], "o-", color=colour, label=strain)
        axes.set(xlabel="Elements around the belt", ylabel="Error of the displacement [mm]")
        axes.legend()
    study.show(figure, "small-deformation", "Belt pulled by two rollers, at rest: error of roller 2's displacement by the mesh.")


def contact_map(pressure: Floats, friction: Floats, length: float, width: float) -> Figure:
    """Normal force and friction per area over the unrolled belt."""
    from lamella.viz.style import COLOUR_MAP, new_figure, styled

    with styled():
        figure = new_figure(4.2)
        panels = figure.subplots(2, 1, sharex=True)
        for axes, values, name in zip(panels, (pressure, friction), ("Pressure [kPa]", "Friction [kPa]"), strict=True):
            drawn = axes.imshow(
                1e-3 * values, extent=(0.0, length, -0.5 * width, 0.5 * width), origin="lower", aspect="auto", cmap=COLOUR_MAP
            )
            axes.grid(visible=False)
            axes.set_ylabel("Across [m]")
            figure.colorbar(drawn, ax=axes, label=name)
        panels[-1].set_xlabel("Along the belt [m]")
    return figure


def path(x: Floats, y: Floats, z: Floats) -> Figure:
    """The path of a point, projected on the planes X Y and X Z."""
    from lamella.viz.style import COLOURS, new_figure, styled

    with styled():
        figure = new_figure(5.0)
        side, above = figure.subplots(2, 1, height_ratios=(2, 1))
        side.plot(x, y, color=COLOURS[0], linewidth=0.7)
        side.set(ylabel="Y [m]", aspect="equal")
        above.plot(x, 1e3 * z, color=COLOURS[0], linewidth=0.7)
        above.set(xlabel="X [m]", ylabel="Z [mm]")
    return figure


def shaded(study: Study, run: Result) -> None:
    """The belt's deformation, coloured by stress (figures 11 and 12), and its membrane strain at the end."""
    from lamella.viz.scene import animation, picture

    folder = study.folder / "pictures"
    at = [float(share * run.frame_at[-1]) for share in MOMENTS]
    for name, times, field, caption in (
        ("snapshots", at, "von_mises", f"Figure 12: the belt at {', '.join(f'{t:.3g}' for t in at)} s."),
        ("stress-map", [at[-1]], "von_mises", "Figure 11: von Mises stress at full speed."),
        ("strain-map", [at[-1]], "membrane_strain.xx", "Membrane strain along the belt at full speed."),
    ):
        shape = picture(run, folder / f"{name}.png", at=times, field=field, view=VIEW)
        study.captions[shape] = caption
        study.files.append(shape)
    moving = animation(run, folder / "motion.gif", field="von_mises", view=VIEW, frames=24)
    study.captions[moving] = "The belt's motion, coloured by von Mises stress."
    study.files.append(moving)
