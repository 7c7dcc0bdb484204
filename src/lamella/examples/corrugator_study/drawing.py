"""The pictures of the study."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from lamella.sweep.table import StudyResult

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from lamella.study.study import Study

ROWS = (
    ("Drift [mm/s]", (("drift", "", 1e3),)),
    ("Tilt of roller 2 [mrad]", (("tilt", "", -1e3),)),
    ("Stress [MPa]", (("edge_a", "edge a", 1e-6 / 4e-3), ("edge_b", "edge b", 1e-6 / 4e-3))),
)
LABELS = {
    "difference": "Difference of forces [N]",
    "speed": "Speed [m/s]",
    "friction": "Friction",
    "misalignment": "Misalignment [mrad]",
}


def show_all(study: Study, result: StudyResult) -> None:
    """Draw drift, tilt and stress of the edges over each parameter."""
    study.show(
        effects_figure(result),
        "effects",
        "Drift towards end b, tilt of roller 2 (end b nearer), and stress along both edges over one parameter at a time; "
        "rings mark the base point.",
    )


def effects_figure(result: StudyResult) -> Figure:
    """A column for each parameter, with axes in common along a row."""
    from lamella.examples.corrugator_study.study import BASE, along
    from lamella.viz.style import COLOURS, new_figure, styled

    with styled():
        figure = new_figure(6.0)
        panels = figure.subplots(len(ROWS), len(LABELS), sharex="col", sharey="row")
        for column, (name, label) in enumerate(LABELS.items()):
            for axes, (quantity, outputs) in zip(panels[:, column], ROWS, strict=True):
                for colour, (output, words, factor) in zip(COLOURS, outputs, strict=False):
                    x, y = along(result, name, output)
                    kept = np.isfinite(y)
                    axes.plot(x[kept], factor * y[kept], "o-", color=colour, markersize=4, label=words or None)
                    base = np.isclose(x, BASE[name]) & kept
                    axes.plot(x[base], factor * y[base], "o", color=colour, markersize=9, markerfacecolor="none")
                if column == 0:
                    axes.set_ylabel(quantity)
                if column == 0 and len(outputs) > 1:
                    axes.legend(fontsize=8)
            panels[-1, column].set_xlabel(label)
    return figure
