"""Pictures and the page of an optimisation."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from lamella.optimisation.problem import in_unit
from lamella.optimisation.run import OptimisationResult
from lamella.study.folder import PICTURES
from lamella.study.outputs import make_folder
from lamella.study.run import Finished

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SHOWN = 3
"""Pictures of the best design on the page."""


def write_report_of(result: OptimisationResult, finished: Sequence[Finished], folder: Path, text: str, best: str) -> list[Path]:
    """Write the picture of the search and the page, with pictures of the best design that was run.

    Raises:
        ResultFileError: one cannot be written.
    """
    from lamella.viz.report import Figure, Section, Table, write_report
    from lamella.viz.style import save_figure

    make_folder(folder / PICTURES)
    search = save_figure(search_figure(result), folder / PICTURES / "search.png")
    drawn = [file for item in finished for file in item.files if file.suffix == ".png"]
    bodies = [file for file in drawn if file.stem not in ("signals", "energy")][:SHOWN]
    problem, chosen = result.problem, result.best
    rows = [[result.label(name), result.history[0].values[name], chosen.values[name]] for name in problem.parameters]
    rows += [[result.label(name), result.history[0].outputs[name], chosen.outputs[name]] for name in result.units]
    goal = problem.objective
    aim = f"{goal.goal} {goal.output}" + (f" = {goal.target}" if goal.target is not None else "")
    ended = "Converged" if result.converged else "Not converged"
    sections = [
        Section(
            "Result",
            f"{aim}. {ended} after {len(result.history)} designs: {result.message}.".replace("..", "."),
            tables=[Table(["", "at the start", "best"], rows)],
            figures=[Figure(search, f"The search: {goal.output}, constraints and parameters, design by design")],
        )
    ]
    if bodies:
        sections.append(Section("The best design", figures=[Figure(file, file.stem.replace("_", " ")) for file in bodies]))
    columns = {name: values for name, values in result.columns().items() if name != "message"}
    cells = [["" if cell is None else cell for cell in row] for row in zip(*columns.values(), strict=True)]
    sections.append(Section("Designs tried", tables=[Table(list(columns), cells)]))
    if text:
        sections.append(Section("Optimisation", code=text))
    page = folder / "report.html"
    title = problem.title or f"Optimisation of {Path(problem.model).stem}"
    write_report(page, title, sections, summary=problem.description, model_text=best)
    return [search, page]


def search_figure(result: OptimisationResult) -> Figure:
    """The objective, the constrained outputs with their limits, and the parameters over the designs tried."""
    from lamella.viz.style import COLOURS, new_figure, place_legend, styled

    problem = result.problem
    outputs = list(dict.fromkeys((problem.objective.output, *problem.constraints)))
    numbers = np.array([design.number for design in result.history])
    with styled():
        figure = new_figure(0.6 + 1.8 * (len(outputs) + 1))
        grid = figure.subplots(len(outputs) + 1, 1, sharex=True)
        best = result.best.number
        for axes, name in zip(grid, outputs, strict=False):
            axes.plot(numbers, result[name], "o-", color=COLOURS[0], markersize=4)
            axes.plot([best], result[name][best - 1], "o", color=COLOURS[1], markersize=7, label="best")
            for end in (problem.constraints[name].min, problem.constraints[name].max) if name in problem.constraints else ():
                if end is not None:
                    axes.axhline(in_unit(end, result.units[name]), color="#8a95a3", linestyle="--", label="limit")
            axes.set_ylabel(result.label(name))
            place_legend(axes)
        axes = grid[-1]
        for k, (name, parameter) in enumerate(problem.parameters.items()):
            low, high, unit = parameter.bounds
            share = (result[name] - low) / (high - low)
            axes.plot(
                numbers, share, "o-", color=COLOURS[k % len(COLOURS)], markersize=4, label=f"{name}, {low:g} to {high:g} {unit}"
            )
        axes.set_ylabel("share of the range")
        axes.set_xlabel("design")
        axes.xaxis.get_major_locator().set_params(integer=True)
        place_legend(axes)
    return figure
