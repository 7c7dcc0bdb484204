"""The pictures of the study."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

from lamella.roles import Floats

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from lamella.examples.solar_array.study import Unfolding
    from lamella.study.study import Study

SHOWN = (0.0, 1.5, 2.5, 3.5, 5.0)
"""Times of the shaded pictures [s]."""


def show_all(study: Study, runs: Mapping[str, Unfolding], others: Mapping[str, Unfolding]) -> None:
    """Draw everything for the report page, the paper's figures first."""
    from lamella.viz.plots import plot_curves, plot_energy

    study.show(
        forces(runs, {"Corner 1": lambda run: run.y1, "Corner 2": lambda run: run.y2}, "Force along y [N]"),
        "force-y",
        "Forces of the guides on corners 1 and 2 along y, figure 9 of the paper.",
    )
    study.show(
        forces(runs, {"Both corners": lambda run: run.z}, "Force along z [N]"),
        "force-z",
        "Forces of the guides on both corners along z, figure 10 of the paper.",
    )
    study.show(
        forces(runs, {"Both corners": lambda run: run.drive}, "Driving force [N]"),
        "force-drive",
        "Driving force on both corners along x, figure 11 of the paper.",
    )
    kinds = {"rho_inf 0.9": "symmetric, 6x6", "rho_inf 0.6": "rho_inf 0.6", "structural damping": "structural damping"}
    curves = {label: (others[name].t, others[name].drive) for label, name in kinds.items()}
    figure = plot_curves(curves, "Time [s]", "Driving force [N]", title="What damping changes")
    study.show(figure, "damping", "Driving force with numerical and with structural damping (steps of 5 ms, symmetric layup).")
    study.show(
        plot_energy(runs["symmetric"].result, title="Energy, symmetric layup"),
        "energy",
        "Energies and the work of the drive, and below what their balance leaves over.",
    )
    shapes(study, runs["symmetric"])


def forces(runs: Mapping[str, Unfolding], parts: Mapping[str, Callable[[Unfolding], Floats]], label: str) -> Figure:
    """Histories of one force for the three models, a panel for each part."""
    from lamella.viz.style import COLOURS, INK, new_figure, styled

    with styled():
        figure = new_figure(0.6 + 2.3 * len(parts))
        panels = figure.subplots(len(parts), 1, sharex=True, squeeze=False)[:, 0]
        for axes, (title, values) in zip(panels, parts.items(), strict=True):
            for colour, width, (name, run) in zip((COLOURS[0], COLOURS[1]), (1.3, 0.9), list(runs.items())[1:], strict=True):
                axes.plot(run.t, values(run), color=colour, linewidth=width, label=name)
            axes.plot(runs["rigid"].t, values(runs["rigid"]), color=INK, linewidth=1.4, label="rigid")
            axes.set(title=title, ylabel=label)
            axes.margins(x=0.01)
        panels[-1].set_xlabel("Time [s]")
        handles, labels = panels[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=3)
    return figure


def shapes(study: Study, run: Unfolding) -> None:
    """Shaded pictures at several times, and the animation."""
    from lamella.examples.swing import animation_of
    from lamella.viz.scene import picture

    study.say("drawing the array")
    folder = study.folder / "pictures"
    shape = picture(run.result, folder / "unfolding.png", at=SHOWN, field="von_mises", title="Symmetric layup, true to scale")
    study.captions[shape] = "The array unfolding, coloured by the largest von Mises stress of all plies."
    study.files.append(shape)
    if moving := animation_of(study, "symmetric", "unfolding"):
        study.captions[moving] = "The unfolding."
