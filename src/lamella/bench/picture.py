"""Work-precision picture: error over CPU time, a line for each code."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from lamella.bench.row import Row
from lamella.viz.style import COLOURS, new_figure, place_legend, styled

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MARKERS = "osD^vPX"


@dataclass(frozen=True)
class Picture:
    """What the picture of a case says.

    Args:
        title: heading.
        numbers: what the numbers at the points are, the first words of the rows' ``what``.
        goal: error to reach, drawn as a line; None without one.
    """

    title: str
    numbers: str
    goal: float | None = None


def work_precision(rows: Sequence[Row], picture: Picture) -> Figure:
    """Error of each code over its CPU time, both logarithmic; ``rows`` are those of one case that have an error."""
    with styled():
        figure = new_figure(3.8)
        axes = figure.subplots()
        for number, code in enumerate(dict.fromkeys(row.code for row in rows)):
            own = [row for row in rows if row.code == code]
            look = {"color": COLOURS[number % len(COLOURS)], "marker": MARKERS[number % len(MARKERS)], "markersize": 5}
            axes.loglog([row.time for row in own], [100.0 * abs(row.error) for row in own], label=code, **look)
            for row in own:
                place = (row.time, 100.0 * abs(row.error))
                axes.annotate(row.what.split()[0], place, (4, 4), textcoords="offset points", fontsize=7.5, color=look["color"])
        if picture.goal is not None:
            axes.axhline(100.0 * picture.goal, color="#8a95a3", linewidth=0.9, linestyle="--", zorder=1)
        axes.set(title=picture.title, xlabel=f"CPU time [{rows[0].unit}]; numbers are {picture.numbers}", ylabel="Error [%]")
        place_legend(axes)
    return figure


def with_error(rows: Sequence[Row], case: str) -> list[Row]:
    """The rows of a case that a work-precision picture shows."""
    return [row for row in rows if row.case == case and not math.isnan(row.error)]
