"""Figures of recorded signals, of the energy balance, of models compared and of convergence (matplotlib)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from lamella.arguments import TEXT, Kind, accepts, instance, mapping, numbers, optional, sequence
from lamella.errors import DeclarationError
from lamella.result import Result
from lamella.roles import Floats
from lamella.viz.style import COLOURS, COMPONENT_COLOURS, DASHES, INK, WIDTH, new_figure, place_legend, styled

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

NUMBERS = numbers("a list of numbers")
CURVE = Kind(
    lambda value: isinstance(value, Sequence) and len(value) == 2 and all(map(NUMBERS.accepts, value)), "two lists of numbers"
)
AXIS_LABEL = {"time": "Time [s]", "load_factor": "Load factor [–]", "path": "Point on the path [–]"}
LOAD_FACTOR = "load_factor"
ENERGIES = ("energy.", "work.")
POSITION = ".position"
BALANCE = "energy.balance"
SMALLEST_SPAN = 5e-3
"""A component that varies less than this part of its signal's largest variation is drawn as flat as it is."""

LEGEND_ROW = 0.18
"""Height of a row of a legend [inch]."""

MOST_MARKERS = 40
"""Points beyond so many are thinned out, evenly, so that markers do not hide what they are compared with."""

MOST_IN_A_ROW, IN_A_ROW = 6, 3
"""A signal of more components than the first, such as a rotation matrix, takes rows of the second."""

CHOSEN = (POSITION, ".force", ".angle", ".displacement")
"""Signals drawn when none are named: of markers and bodies, of joints and supports."""

Curve = tuple[Floats, Floats]


def unit_label(name: str, unit: str) -> str:
    """A quantity with its unit in brackets; a pure number has a dash."""
    return f"{name} [{'–' if unit in ('', '1') else unit.replace(' ', ' ')}]"


def abscissa(result: Result) -> tuple[Floats, str]:
    """What signals are drawn over, with its label: time or load factor; on a path it may go forth and back."""
    if result.axis == "path" and LOAD_FACTOR in result:
        return result.samples(LOAD_FACTOR), AXIS_LABEL[LOAD_FACTOR]
    return result.at, AXIS_LABEL[result.axis]


@accepts(result=instance("a result", Result), names=optional(sequence(TEXT, least=1)))
def plot_signals(result: Result, names: Sequence[str] | None = None, *, title: str = "") -> Figure:
    """Recorded signals over time or load factor: a row for each signal, a column for each component, each with its own range.

    Args:
        result: of a solution, or read from a file.
        names: signals, or single components such as ``tip.position.z``; by default all positions, forces, and angles
            and displacements of joints.
        title: heading of the figure.

    Raises:
        DeclarationError: no such signal.
    """
    if names is None:
        names = [name for name in result.signals if name.endswith(CHOSEN)] or list(result.signals)
    rows = [(name, part) for name in names for part in _parts(columns_of(result, name))]
    with styled():
        figure = new_figure(0.35 + 1.75 * len(rows))
        if title:
            figure.suptitle(title, x=0.01, ha="left", fontsize=11.5, fontweight="bold")
        grid = figure.add_gridspec(len(rows), 1)
        for row, (name, columns) in enumerate(rows):
            axes = [figure.add_subplot(cell) for cell in grid[row].subgridspec(1, len(columns))]
            _draw_row(axes, name, result, columns, last=row == len(rows) - 1)
        note_outcome(figure, [result])
    return figure


@accepts(result=instance("a result", Result))
def plot_energy(result: Result, *, title: str = "Energy balance") -> Figure:
    """Energies and works over time, and below them what the balance leaves over.

    Raises:
        DeclarationError: the result has no energies.
    """
    names = [name for name in result.signals if name.startswith(ENERGIES) and name != BALANCE]
    if not names:
        raise DeclarationError(
            "energy plot", "the result has no signal energy.* or work.*", f"recorded are {', '.join(result.signals)}"
        )
    series = {name: result.samples(name) for name in names}
    zero = [name for name, values in series.items() if not np.any(values)]
    x, label = abscissa(result)
    with styled():
        figure = new_figure(4.2)
        upper, lower = (
            figure.subplots(2, 1, sharex=True, height_ratios=(3, 1)) if BALANCE in result else (figure.subplots(), None)
        )
        for number, (name, values) in enumerate((n, v) for n, v in series.items() if n not in zero):
            dash = DASHES[1] if name.startswith("work.") else DASHES[0]
            upper.plot(x, values, color=COLOURS[number % len(COLOURS)], linestyle=dash, label=_short(result, name))
        upper.set(title=title, ylabel="Energy [J]")
        place_legend(upper)
        if lower is not None:
            lower.plot(x, result.samples(BALANCE), color=INK, linewidth=1.1)
            lower.set_ylabel("Balance [J]")
        (upper if lower is None else lower).set_xlabel(label)
        upper.margins(x=0.01)
        note_outcome(figure, [result], "Zero: " + ", ".join(_short(result, name).lower() for name in zero) if zero else "")
    return figure


@accepts(results=mapping(instance("a result", Result), least=1), name=TEXT)
def plot_comparison(
    results: Mapping[str, Result],
    name: str,
    *,
    change: bool = False,
    references: Mapping[str, Curve] | None = None,
    label: str = "",
    title: str = "",
) -> Figure:
    """One signal of several results in one axes.

    Args:
        results: a label for each model, and its result.
        name: a scalar signal or one component, such as ``C.position.z``.
        change: draw the change since the start, such as a deflection instead of a position.
        references: points to compare with, such as published values: label to (time, value).
        label: of the vertical axis without unit, by default the signal's name.
        title: heading.

    Raises:
        DeclarationError: a result has no such signal, or the signal has several components.
    """
    curves = {}
    for model, result in results.items():
        columns = columns_of(result, name)
        if len(columns) != 1:
            names = ", ".join(f"{name}.{component}" for component in columns)
            raise DeclarationError("comparison", f"'{name}' has several components", f"accepted are {names}")
        values = next(iter(columns.values()))
        curves[model] = (abscissa(result)[0], values - values[0] if change else values)
    first = next(iter(results.values()))
    text = label or (f"Change of {name}" if change else name)
    unit = signal_of(first, name)[1]
    figure = plot_curves(curves, abscissa(first)[1], unit_label(text, unit), points=references, title=title)
    with styled():
        note_outcome(figure, list(results.values()))
    return figure


def plot_curves(
    curves: Mapping[str, Curve],
    x_label: str,
    y_label: str,
    *,
    points: Mapping[str, Curve] | None = None,
    title: str = "",
    joined: bool = True,
    log: str = "",
) -> Figure:
    """Curves, and points to compare them with, in one axes.

    Args:
        curves: label to (x, y), drawn as lines.
        x_label: horizontal axis with unit.
        y_label: vertical axis with unit.
        points: label to (x, y), drawn as open markers; of many points every so manieth.
        title: heading.
        joined: False draws the curves as dots.
        log: axes that are logarithmic: ``x``, ``y`` or ``xy``.
    """
    with styled():
        figure = new_figure(3.4)
        axes = figure.subplots()
        for number, (name, (x, y)) in enumerate(curves.items()):
            dash = DASHES[(number // 2 + number) % len(DASHES)] if len(curves) > 1 else DASHES[0]
            look = {"linestyle": dash} if joined else {"linestyle": "", "marker": ".", "markersize": 7, "zorder": 4}
            axes.plot(x, y, color=COLOURS[number % len(COLOURS)], label=name, **look)
        for number, (name, (x, y)) in enumerate((points or {}).items()):
            look = {"markerfacecolor": "white", "markeredgecolor": INK, "markersize": 5 if joined else 8, "zorder": 3}
            axes.plot(x, y, "os^Dv"[number % 5], markevery=-(-len(x) // MOST_MARKERS), label=name, **look)
        axes.set(title=title, xlabel=x_label, ylabel=y_label)
        axes.set(**{f"{axis}scale": "log" for axis in log})
        axes.margins(x=0.01 if joined else 0.05)
        if len(curves) + len(points or {}) > 1:
            place_legend(axes)
            if figure.legends:  # below the axes, which keep their height
                figure.set_figheight(3.4 + LEGEND_ROW * -(-len(axes.lines) // 2))
    return figure


@accepts(series=mapping(CURVE), orders=NUMBERS)
def plot_convergence(
    series: Mapping[str, Curve],
    x_label: str,
    y_label: str = "Relative error [–]",
    *,
    title: str = "",
    orders: Sequence[int] = (),
) -> Figure:
    """Errors against a step or an element size, both logarithmic; the legend gives the order observed.

    Args:
        series: label to (size, error), errors positive.
        x_label: horizontal axis with unit.
        y_label: vertical axis with unit.
        title: heading.
        orders: thin lines of these orders to compare with, through the first series' last point.

    Raises:
        DeclarationError: no series, or one whose sizes and errors are not positive or not equally many.
    """
    for name, curve in series.items():
        size, error = (np.asarray(values, float) for values in curve)
        if not (size.shape == error.shape == (max(size.size, 1),) and (size > 0.0).all() and (error > 0.0).all()):
            found = f"series '{name}' has the sizes {size.tolist()} and the errors {error.tolist()}"
            raise DeclarationError("convergence plot", found, "accepted are as many positive sizes and errors, one or more")
    if not series:
        raise DeclarationError("convergence plot", "there is no series", "accepted is one or more")
    with styled():
        figure = new_figure(3.4, WIDTH * 0.86)
        axes = figure.subplots()
        for number, (name, (size, error)) in enumerate(series.items()):
            text = f"{name}, order {observed_order(size, error):.2f}" if len(size) > 1 else name
            axes.loglog(size, error, "osD^v"[number % 5] + "-", color=COLOURS[number % len(COLOURS)], markersize=4.5, label=text)
        size, error = (np.asarray(values, float) for values in next(iter(series.values())))
        finest, span = int(np.argmin(size)), np.array([size.min(), size.max()])
        for order in orders:
            line = error[finest] * (span / size[finest]) ** order
            axes.loglog(span, line, color="#8a95a3", linewidth=0.9, linestyle=DASHES[2], zorder=1)
            axes.annotate(f"order {order}", (span[0], line[0]), (12, 0), textcoords="offset points", fontsize=8, va="center")
        axes.set(title=title, xlabel=x_label, ylabel=y_label)
        _tick_sizes(axes, np.unique(np.concatenate([np.asarray(x, float) for x, _ in series.values()])))
        place_legend(axes)
    return figure


def _tick_sizes(axes: Axes, sizes: Floats) -> None:
    """Label the sizes that were computed, unless there are too many of them."""
    axes.grid(which="minor", axis="y", linewidth=0.3)
    if len(sizes) <= 8:
        axes.set_xticks(sizes, [f"{size:.3g}" for size in sizes])
        axes.set_xticks([], minor=True)


def observed_order(size: Floats, error: Floats) -> float:
    """Slope of log(error) over log(size) by least squares."""
    return float(np.polyfit(np.log(size), np.log(error), 1)[0])


def signal_of(result: Result, name: str) -> tuple[str, str, str | None]:
    """Signal, unit and component meant by ``name``, which is a signal or a signal with a component."""
    if name in result.signals:
        return name, result.signals[name].unit, None
    stem, _, component = name.rpartition(".")
    if stem not in result.signals or component not in result.signals[stem].labels:
        result.samples(name)  # raises the error that lists the signals
    return stem, result.signals[stem].unit, component


def columns_of(result: Result, name: str) -> dict[str, Floats]:
    """Components by their label; a scalar has the empty label."""
    signal, _, component = signal_of(result, name)
    values, labels = result.samples(signal), result.signals[signal].labels
    if not labels:
        return {"": values}
    return {label: values[:, k] for k, label in enumerate(labels) if component in (None, label)}


def _parts(columns: dict[str, Floats]) -> list[dict[str, Floats]]:
    """Components that share a row."""
    items = list(columns.items())
    width = len(items) if len(items) <= MOST_IN_A_ROW else IN_A_ROW
    return [dict(items[k : k + width]) for k in range(0, len(items), width)]


def _draw_row(axes: Sequence[Axes], name: str, result: Result, columns: dict[str, Floats], last: bool) -> None:
    signal, unit, _ = signal_of(result, name)
    spans = [float(np.ptp(values[np.isfinite(values)])) if np.isfinite(values).any() else 0.0 for values in columns.values()]
    x, x_label = abscissa(result)
    for number, (axis, (label, values)) in enumerate(zip(axes, columns.items(), strict=True)):
        colour = COMPONENT_COLOURS.get(label, COLOURS[number % len(COLOURS)])
        axis.plot(x, values, color=colour)
        axis.margins(x=0.01)
        _keep_flat(axis, values, spans[number], SMALLEST_SPAN * max(spans))
        axis.set_title(f"{signal} {label}".strip() if number == 0 else label)
        if number == 0:
            axis.set_ylabel(f"[{'–' if unit in ('', '1') else unit}]")
        if last:
            axis.set_xlabel(x_label)


def _keep_flat(axis: Axes, values: Floats, span: float, smallest: float) -> None:
    """Do not blow rounding errors up to the height of the axes."""
    if span < smallest:
        middle = 0.5 * float(np.nanmin(values) + np.nanmax(values))
        half = max(smallest, 1e-9 * abs(middle))
        axis.set_ylim(middle - half, middle + half)


def _short(result: Result, name: str) -> str:
    """Name of an energy for the legend."""
    text = result.signals[name].description or name
    return text[:1].upper() + text[1:]


def note_outcome(figure: Figure, results: Sequence[Result], note: str = "") -> None:
    """Say below the figure which runs did not reach their end, after a note."""
    stopped = sorted({str(result.outcome) for result in results if not result.outcome.completed})
    if stopped or note:
        text = "\n".join([note] * bool(note) + ["; ".join(stopped)] * bool(stopped))
        colour = "#a33" if stopped else "#4b5563"
        if figure.legends:  # below the axes too, where both would stand upon each other
            figure.legends[0].set_title(text)
            figure.legends[0].get_title().set(fontsize=8, color=colour)
        else:
            figure.supxlabel(text, fontsize=8, color=colour, x=0.01, ha="left")
