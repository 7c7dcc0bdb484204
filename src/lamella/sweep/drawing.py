"""Pictures of a study: lines over one parameter, heat maps over a grid of two, a matrix of points over more, sensitivities."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from lamella.sweep.designs import GridDesign
from lamella.sweep.sensitivity import Sensitivity
from lamella.sweep.table import StudyResult
from lamella.viz.style import COLOUR_MAP, COLOURS, WIDTH, new_figure, place_legend, styled

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


NOT_IN_FILES = re.compile(r"[^\w .,+=()-]")
"""What a name may have and that of a file should not."""
LONGEST = 80
"""Letters of a name in that of a file."""


def study_figures(result: StudyResult) -> dict[str, tuple[Figure, str]]:
    """The pictures that suit a design, by file name, each with its caption; none when no run gave anything."""
    names = list(result.parameters)
    if not result.ok.any():
        return {}
    if len(names) == 1:
        return {"outputs": (line_figure(result), f"Outputs over {names[0]}")}
    if len(names) == 2 and isinstance(result.study.design, GridDesign):
        figures: dict[str, tuple[Figure, str]] = {}
        for name in result.units:
            file = f"map-{NOT_IN_FILES.sub('_', name)[:LONGEST]}"
            while file in figures:
                file += "_"
            figures[file] = map_figure(result, name), f"{name} over {names[0]} and {names[1]}"
        return figures
    return {"outputs": (matrix_figure(result), "Each output over each parameter, a point for each run")}


def line_figure(result: StudyResult) -> Figure:
    """Each output over the one parameter."""
    (name,) = result.parameters
    with styled():
        figure = new_figure(0.4 + 2.2 * len(result.units))
        for row, output in enumerate(result.units):
            axes = figure.add_subplot(len(result.units), 1, row + 1)
            x, kept = _abscissa(axes, result, name), result.ok
            order = np.argsort(x[kept], kind="stable")
            axes.plot(x[kept][order], result[output][kept][order], "o-", color=COLOURS[0], markersize=4)
            axes.set_ylabel(result.label(output))
            if row == len(result.units) - 1:
                axes.set_xlabel(result.label(name))
    return figure


def map_figure(result: StudyResult, output: str) -> Figure:
    """An output over a grid of two parameters; failed runs are left white."""
    first, second = result.parameters
    with styled():
        figure = new_figure(4.6)
        axes = figure.add_subplot()
        counts = [len(parameter.grid()) for parameter in result.study.parameters.values()]
        values = result[output].reshape(counts)
        mesh = axes.pcolormesh(*(np.arange(n + 1) - 0.5 for n in counts), np.ma.masked_invalid(values.T), cmap=COLOUR_MAP)
        for axis, name, texts in (
            (axes.xaxis, first, _texts(result, first)[:: counts[1]]),
            (axes.yaxis, second, _texts(result, second)[: counts[1]]),
        ):
            shown = np.unique(np.linspace(0, len(texts) - 1, 9).round().astype(int))
            axis.set_ticks(shown, [texts[index] for index in shown])
            axis.set_label_text(result.label(name))
        axes.grid(False)
        figure.colorbar(mesh, ax=axes, label=result.label(output))
    return figure


def matrix_figure(result: StudyResult) -> Figure:
    """Points of each output over each parameter."""
    names, outputs = list(result.parameters), list(result.units)
    with styled():
        figure = new_figure(0.5 + 1.9 * len(outputs), max(WIDTH, 1.6 * len(names) + 0.8))
        grid = figure.subplots(len(outputs), len(names), squeeze=False, sharey="row", sharex="col")
        for row, output in enumerate(outputs):
            for column, name in enumerate(names):
                axes = grid[row, column]
                x = _abscissa(axes, result, name)
                axes.plot(x[result.ok], result[output][result.ok], "o", color=COLOURS[0], markersize=3, alpha=0.6, mew=0)
                if row == len(outputs) - 1:
                    axes.set_xlabel(result.label(name))
                if column == 0:
                    axes.set_ylabel(result.label(output))
    return figure


def sensitivity_figure(result: StudyResult, found: Sequence[Sensitivity]) -> Figure:
    """Bars with their intervals, a row of bars for each output."""
    measures = list(dict.fromkeys(item.measure for item in found))
    outputs = list(dict.fromkeys(item.output for item in found))
    names = list(result.parameters)
    with styled():
        figure = new_figure(0.5 + 2.1 * len(outputs))
        for row, output in enumerate(outputs):
            axes = figure.add_subplot(len(outputs), 1, row + 1)
            for index, measure in enumerate(measures):
                items = {item.parameter: item for item in found if item.output == output and item.measure == measure}
                bars = [items[name] for name in names]
                heights = np.array([bar.value for bar in bars])
                ends = np.array([[bar.value - bar.low, bar.high - bar.value] for bar in bars]).T
                width = 0.7 / len(measures)
                x = np.arange(len(names)) + (index - 0.5 * (len(measures) - 1)) * width
                errors: Any = {"ecolor": "#1d2733", "elinewidth": 1.0, "capsize": 2.5}
                axes.bar(
                    x, heights, 0.92 * width, yerr=np.maximum(ends, 0.0), color=COLOURS[index], label=measure, error_kw=errors
                )
            axes.axhline(0.0, color="#8a95a3", linewidth=0.8)
            axes.set_xticks(np.arange(len(names)), names)
            axes.grid(False, axis="x")
            axes.set_ylabel(measures[0] if len(measures) == 1 else "share of the variance")
            axes.set_title(output)
            if len(measures) > 1 and row == 0:
                place_legend(axes)
    return figure


def _abscissa(axes: Axes, result: StudyResult, name: str) -> np.ndarray:
    """Values of a parameter for the axis; words stand at whole numbers with their text as labels."""
    values = result[name]
    parameter = result.study.parameters[name]
    if values.dtype.kind != "U":
        if parameter.scale == "log":
            axes.set_xscale("log")
        return values
    words = list(dict.fromkeys(values))
    axes.set_xticks(np.arange(len(words)), words)
    return np.array([float(words.index(value)) for value in values])


def _texts(result: StudyResult, name: str) -> list[str]:
    return [value if isinstance(value, str) else f"{value:.4g}".replace("-", "−") for value in result.parameters[name][1]]
