"""Ply angles of a panel in the sun: a search by gradients, and a grid that tells whether it has found the best."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from lamella.errors import DeclarationError
from lamella.examples.swing import rounded
from lamella.optimisation.problem import read_optimisation
from lamella.optimisation.run import OptimisationResult, run_optimisation
from lamella.study.findings import Finding
from lamella.sweep.designs import GridDesign
from lamella.sweep.run import run_parameter_study
from lamella.sweep.study import ParameterStudy
from lamella.sweep.table import StudyResult

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from lamella.study.study import Study

FILE = Path(__file__).parent / "optimize.yaml"
ANGLES = tuple(np.linspace(0.0, 60.0, 13).tolist())
"""Of the grid [deg]."""
LOWEST = 0.42
"""Frequency that the search keeps [Hz]."""
OWN = ("laminates.panel.angles", "laminates.panel.thickness")


def study(study: Study) -> Iterator[Finding]:
    """Search, look at a grid of the angle with the thickness found, draw both, and yield the findings."""
    for text in study.overrides:
        if text.startswith(OWN):
            accepted = "the search sets angles and thickness itself; accepted are other values, or the model file alone"
            raise DeclarationError("layup-optimisation", f"the value {text} was given", accepted)
    source = read_optimisation(FILE)
    problem = replace(source.problem, set=(*source.problem.set, *study.overrides))
    found = run_optimisation(replace(source, problem=problem), study.folder / "search", pictures=study.draw, say=study.say)
    study.files.extend(found.files)
    thickness = found.best.values["thickness"]
    around = ParameterStudy(
        model=str(Path(__file__).parent / "model.yaml"),
        parameters={"outer": replace(problem.parameters["outer"], range=None, values=ANGLES)},
        design=GridDesign(),
        outputs=problem.outputs,
        set=(*problem.set, f"laminates.panel.thickness={thickness!r} mm"),
        title="Grid of the outer plies' angle with the thickness found",
    )
    grid = run_parameter_study(around, study.folder / "grid", pictures=study.draw, progress=study.progress, say=study.say)
    study.files.extend(grid.files)
    if study.draw:
        caption = "Motion of the tip over the angle of the outer plies with the thickness found, and the way of the search."
        study.show(angle_figure(found, grid), "search", caption)
    yield stays_still(found)
    yield no_better(found, grid)


def stays_still(found: OptimisationResult) -> Finding:
    """The panel that was found hardly moves and keeps its limits."""
    first, best = found.history[0], found.best
    ratio = best.outputs["tip"] / first.outputs["tip"]
    numbers = {f"{found.label(name)}, best": value for name, value in (best.values | dict(best.outputs)).items()}  # type: ignore[operator]
    numbers |= {f"{found.label(name)}, at the start": value for name, value in first.outputs.items()}
    numbers |= {"designs tried": float(len(found.history)), "tip, best over start": ratio}
    return Finding(
        "A search along gradients finds a panel whose tip moves by less than a fifth of what it did, within its limits.",
        found.converged and best.meets and ratio < 0.2,
        rounded(numbers),
        "Plies along the panel shrink with heat, plies across it grow: with both, the bending that the light asks for cancels.",
    )


def no_better(found: OptimisationResult, grid: StudyResult) -> Finding:
    """No point of a coarse grid that keeps the limits is better."""
    allowed = np.flatnonzero(grid["frequency"] >= LOWEST)
    best = allowed[np.argmin(grid["tip"][allowed])] if len(allowed) else 0
    return Finding(
        "On a grid of the angle no panel that keeps the limits moves less.",
        bool(len(allowed)) and bool(grid["tip"][best] >= found.best.outputs["tip"]),
        rounded(
            {
                "tip, found by the search [m]": found.best.outputs["tip"],
                "tip, best of the grid [m]": float(grid["tip"][best]),
                "outer angle, best of the grid [deg]": float(grid["outer"][best]),
                "points of the grid": float(len(grid.rows)),
                "of them within the limits": float(len(allowed)),
                "worst of the grid [m]": float(np.nanmax(grid["tip"])),
            }
        ),
        "The grid has the thickness that was found.",
    )


def angle_figure(found: OptimisationResult, grid: StudyResult) -> Figure:
    """The tip's motion over the angle, on the grid and as the search went."""
    from lamella.viz.style import COLOURS, new_figure, place_legend, styled

    with styled():
        figure = new_figure(3.8)
        axes = figure.add_subplot()
        kept = grid["frequency"] >= LOWEST
        axes.semilogy(grid["outer"], 1e3 * grid["tip"], "-", color=COLOURS[0])
        for chosen, face, label in ((kept, COLOURS[0], "grid, within the limits"), (~kept, "white", "grid, too slow")):
            axes.plot(grid["outer"][chosen], 1e3 * grid["tip"][chosen], "o", color=COLOURS[0], markerfacecolor=face, label=label)
        axes.plot(found["outer"], 1e3 * found["tip"], "s", color=COLOURS[1], markersize=4, label="search")
        axes.plot(
            [found.best.values["outer"]], [1e3 * found.best.outputs["tip"]], "*", color=COLOURS[1], markersize=13, label="best"
        )
        axes.set_xlabel("outer plies [deg]")
        axes.set_ylabel("tip, root mean square [mm]")
        place_legend(axes)
    return figure
