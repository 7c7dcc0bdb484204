"""The pictures of the study."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from lamella.examples.swing import Swing, animation_of
from lamella.roles import Floats

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from lamella.study.study import Study

Traces = Mapping[str, tuple[Sequence[float], Sequence[float]]]
LENGTH = 1.5
SHOWN = (0.1, 0.2, 0.3, 0.4)
"""Times of the shaded pictures [s]."""


def show_all(
    study: Study,
    exact: Mapping[int, Swing],
    linear: Mapping[int, Swing],
    finer: Swing | None,
    statics: tuple[Floats, Mapping[str, Floats]],
    traces: Traces,
) -> None:
    """Draw everything for the report page, the paper's figure first."""
    from lamella.viz.plots import plot_curves, plot_energy

    study.show(
        deflections(exact, linear, traces),
        "deflection",
        "Deflection of C over time, figure 4 of the paper: exact strains against the theory of small deformation. Thin dashed "
        "lines are the static deflections, about which the plate swings.",
    )
    study.show(
        load_deflection(*statics),
        "static",
        "Left: static deflection over the force. Right: by how much the theory of small deformation overrates it.",
    )
    study.show(same_period(exact, linear), "period", "Deflection over static deflection: the period hardly depends on the force.")
    if finer is not None:
        curves = {"6x6 elements": (exact[10].t, exact[10].z), "8x8 elements": (finer.t, finer.z)}
        figure = plot_curves(curves, "Time [s]", "Deflection of C [m]", title="Mesh check, 10 N")
        study.show(figure, "mesh", "The motion under 10 N on two meshes; the finer one is followed for one second.")
    study.show(
        plot_energy(exact[10].result, title="Energy, 10 N"),
        "energy",
        "Energies and work under 10 N, and below what their balance leaves over: what the integrator has damped.",
    )
    shapes(study, exact[20])


def deflections(exact: Mapping[int, Swing], linear: Mapping[int, Swing], traces: Traces) -> Figure:
    """Figure 4 of the paper: one panel for each force."""
    from lamella.viz.style import INK, new_figure, styled

    with styled():
        figure = new_figure(5.6)
        panels = figure.subplots(len(exact), 1, sharex=True)
        for axes, letter, force in zip(panels, "ab", exact, strict=True):
            _draw_models(axes, exact[force], linear[force])
            for (name, (t, z)), marker in zip(traces.items() if force == 10 else (), "so", strict=False):
                axes.plot(t, z, marker, markerfacecolor="white", markeredgecolor=INK, markersize=5, label=name, zorder=3)
            axes.set(title=f"({letter}) {force} N", ylabel="Deflection of C [m]")
            axes.margins(x=0.01)
        panels[-1].set_xlabel("Time [s]")
        handles, labels = panels[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=3)
    return figure


def _draw_models(axes: Axes, exact: Swing, linear: Swing) -> None:
    from lamella.viz.style import COLOURS, DASHES

    for swing, colour, dash, name in (
        (exact, COLOURS[0], DASHES[0], "exact strains"),
        (linear, COLOURS[1], DASHES[3], "small deformation"),
    ):
        axes.plot(swing.t, swing.z, color=colour, linestyle=dash, label=name)
        axes.axhline(swing.still, color=colour, linestyle=DASHES[1], linewidth=0.8, label=f"static, {name}")


def load_deflection(forces: Floats, curve: Mapping[str, Floats]) -> Figure:
    """Static deflection over the force, and the error of the linear theory over the deflection."""
    from lamella.examples.cantilever_plate.study import overrating
    from lamella.viz.style import COLOURS, DASHES, INK, new_figure, styled

    with styled():
        figure = new_figure(3.2)
        left, right = figure.subplots(1, 2)
        left.plot(forces, -curve["exact"], color=COLOURS[0], label="exact strains")
        left.plot(forces, -curve["linear"], color=COLOURS[1], linestyle=DASHES[3], label="small deformation")
        left.set(title="Static deflection of C", xlabel="Force [N]", ylabel="Deflection, downwards [m]")
        left.legend(loc="upper left")
        right.plot(*overrating(curve), color=INK)
        right.axvline(10.0, color=COLOURS[1], linestyle=DASHES[1], linewidth=1.0)
        right.annotate(
            "a tenth of\nthe length", (10.0, 0.0), (-5, 6), textcoords="offset points", color=COLOURS[1], fontsize=8.5, ha="right"
        )
        right.set(title="Small-deformation theory", xlabel="Static deflection over length [%]", ylabel="Too large by [%]")
        right.set_xlim(left=0.0)
        right.set_ylim(bottom=0.0)
    return figure


def same_period(exact: Mapping[int, Swing], linear: Mapping[int, Swing]) -> Figure:
    """Motions divided by their static deflections."""
    from lamella.viz.plots import plot_curves

    curves = {f"exact, {force} N": (swing.t, swing.z / swing.still) for force, swing in exact.items()}
    first = next(iter(linear.values()))
    curves["small deformation"] = (first.t, first.z / first.still)
    return plot_curves(curves, "Time [s]", "Deflection over static one [–]", title="The period under both forces")


def shapes(study: Study, swing: Swing) -> None:
    """Shaded pictures at several times and the animation, coloured by the stress."""
    from lamella.viz.scene import picture

    study.say("drawing the deformed plate")
    folder, title = study.folder / "pictures", "Under 20 N, true to scale"
    shape = picture(swing.result, folder / "shape.png", at=SHOWN, field="von_mises", title=title)
    study.captions[shape] = "The plate under 20 N in its first half swing, coloured by the largest von Mises stress of all plies."
    study.files.append(shape)
    if moving := animation_of(study, "20N"):
        study.captions[moving] = "The motion under 20 N, slowed down."
