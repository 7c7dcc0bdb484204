"""Load-displacement curves of static solutions (matplotlib)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from lamella.arguments import TEXT, accepts, instance, optional, sequence
from lamella.errors import DeclarationError
from lamella.result import Result
from lamella.viz.plots import AXIS_LABEL, LOAD_FACTOR, POSITION, SMALLEST_SPAN, columns_of, note_outcome, signal_of
from lamella.viz.style import COLOURS, COMPONENT_COLOURS, INK, new_figure, styled

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MARKERS = {"limit point": "o", "bifurcation": "D"}
"""Signs of the kinds of critical points."""


@accepts(result=instance("a result", Result), names=optional(sequence(TEXT, least=1)))
def plot_path(result: Result, names: Sequence[str] | None = None, *, title: str = "") -> Figure:
    """Load-displacement curves: the load factor over the displacement of each position; a row for each, a column a component.

    Critical points are marked.

    Args:
        result: of a static solution.
        names: positions, or single components such as ``tip.position.z``; by default all positions.
        title: heading of the figure.

    Raises:
        DeclarationError: no such signal, no position is recorded, or the result has no load factor.
    """
    names = [name for name in result.signals if name.endswith(POSITION)] if names is None else names
    if not names or LOAD_FACTOR not in result:
        raise DeclarationError(
            "path plot", "the result has no load factor or no position", f"recorded are {', '.join(result.signals)}"
        )
    with styled():
        figure = new_figure(0.7 + 2.2 * len(names))
        if title:
            figure.suptitle(title, x=0.01, ha="left", fontsize=11.5, fontweight="bold")
        grid = figure.add_gridspec(len(names), 1)
        for row, name in enumerate(names):
            axes = [figure.add_subplot(cell) for cell in grid[row].subgridspec(1, len(columns_of(result, name)))]
            _draw_row(axes, result, name)
            for axis in axes if row == len(names) - 1 else ():
                axis.set_xlabel("Displacement [m]")
            if row == 0 and result.critical_points:
                axes[-1].legend(loc="best")
        note_outcome(figure, [result])
    return figure


def _draw_row(axes: Sequence[Axes], result: Result, name: str) -> None:
    factors = result.samples(LOAD_FACTOR)
    moved = {component: values - values[0] for component, values in columns_of(result, name).items()}
    smallest = SMALLEST_SPAN * max(float(np.ptp(values)) for values in moved.values())
    for number, (axis, (component, values)) in enumerate(zip(axes, moved.items(), strict=True)):
        axis.plot(values, factors, ".-", color=COMPONENT_COLOURS.get(component, COLOURS[0]), markersize=3.5)
        for kind, sign in MARKERS.items():
            found = [point for point in result.critical_points if point.kind == kind]
            if found:
                at = np.interp([point.at for point in found], result.at, values)
                axis.plot(at, [point.factor for point in found], sign, color=INK, fillstyle="none", label=f"{kind}s")
        if np.ptp(values) < smallest:  # rounding errors are not blown up to the width of the axes
            middle = 0.5 * float(values.min() + values.max())
            axis.set_xlim(middle - smallest, middle + smallest)
        axis.tick_params(labelleft=number == 0)
        axis.set_title(component)
    stem = signal_of(result, name)[0].removesuffix(POSITION)
    axes[0].set_title(f"{stem} {next(iter(moved))}".strip())
    axes[0].set_ylabel(AXIS_LABEL[LOAD_FACTOR])
