"""Everything a run writes besides its result file: tables, ParaView's file, plots, pictures, report."""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from lamella.errors import ResultFileError
from lamella.io.analysis import Analysis, Output, shape_table
from lamella.io.model_file import ModelFile
from lamella.io.modes import mode_frames, natural_amplitude, write_modes
from lamella.model import Model
from lamella.result import Result
from lamella.shapes import Shapes
from lamella.study.beforehand import recorded
from lamella.study.folder import MODES, PICTURES
from lamella.study.size import size_of
from lamella.viz.solids import drawable
from lamella.whole import replaced

if TYPE_CHECKING:
    from lamella.viz.report import Section

CAPTIONS = {
    "path.png": "Load factor over displacement, along the equilibrium path",
    "signals.png": "Recorded signals",
    "energy.png": "Energy and work, and what their balance leaves over",
    "shape.png": "The bodies, true to their place and scale",
    "modes.png": "The first shapes",
    "animation.gif": "The motion",
}
DRAWN = {".png", ".gif"}
SHOWN = 4
"""Configurations in the picture of a motion or a path."""


def write_outputs(
    model_file: ModelFile, analysis: Analysis, computed: Result | Shapes, folder: Path, pictures: bool, say: Callable[[str], None]
) -> list[Path]:
    """Write what the model file's ``output`` asks for.

    Args:
        model_file: the model.
        analysis: what was computed.
        computed: its result or modes.
        folder: where to write.
        pictures: False leaves out plots, pictures, animation and report.
        say: takes a line for each slow part.

    Returns:
        The files written.

    Raises:
        ResultFileError: a file cannot be written.
    """
    output = model_file.output
    if isinstance(computed, Shapes):
        return write_mode_outputs(model_file, computed, folder, pictures)
    files = [write_signals(computed, folder / "signals.csv")] if output.csv else []
    shown = bool(len(computed.frame_at) and drawable(computed.model))
    if output.paraview and shown:
        from lamella.io.vtk import write_vtkhdf

        files.append(write_vtkhdf(computed, folder / "surface.vtkhdf"))
    if not pictures:
        return files
    if output.pictures:
        say(f"{analysis.name}: drawing pictures")
        files += write_pictures(computed, folder / PICTURES, output)
    if output.animation and shown and len(computed.frame_at) > 1:
        say(f"{analysis.name}: drawing the animation")
        files.append(write_animation(computed, folder / "animation.gif", output))
    if output.report:
        drawn = [path for path in files if path.suffix in DRAWN]
        files.append(write_run_report(computed, folder / "report.html", model_file, drawn))
    return files


def write_mode_outputs(model_file: ModelFile, modes: Shapes, folder: Path, pictures: bool) -> list[Path]:
    """Write shapes and their values, the shapes for ParaView, their picture, and the report.

    Raises:
        ResultFileError: a file cannot be written.
    """
    output, text = model_file.output, model_file.text()
    files = [write_modes(modes, folder / MODES, model_text=text, title=model_file.title)]
    if output.csv:
        files.append(write_values(modes, folder / "modes.csv"))
    if output.paraview and drawable(modes.model):
        from lamella.io.vtk import write_vtkhdf

        shapes = mode_frames(modes, natural_amplitude(modes))
        files.append(write_vtkhdf(shapes, folder / "modes.vtkhdf", fields=("displacement", "normal")))
    drawn = []
    if pictures and output.pictures and drawable(modes.model):
        from lamella.viz.scene import mode_sheet

        make_folder(folder / PICTURES)
        drawn = [mode_sheet(modes, folder / PICTURES / "modes.png", view=output.view)]
    if pictures and output.report:
        from lamella.viz.report import Figure, Section, Table, write_report

        section = Section(
            modes.title,
            figures=[Figure(path, CAPTIONS[path.name]) for path in drawn],
            tables=[Table(["Number", _value_heading(modes)], shape_table(modes))],
        )
        title, about = model_file.title or modes.title, model_file.description
        sections = [section, system_section(model_file, modes.model)]
        files.append(write_report(folder / "report.html", title, sections, summary=about, model_text=text))
    return files + drawn


def _value_heading(shapes: Shapes) -> str:
    """Name and unit of the values, for people."""
    name, unit, _ = shapes.quantity
    return name.replace("_", " ").capitalize() + (f" [{unit}]" if unit != "1" else "")


def make_folder(folder: Path) -> None:
    """Make a folder if it is not there yet.

    Raises:
        ResultFileError: it cannot be made.
    """
    try:
        folder.mkdir(exist_ok=True)
    except OSError as error:
        raise ResultFileError(f"'{folder}' cannot be written: {error.strerror or error}") from error


def write_run_report(result: Result, path: Path, model_file: ModelFile, drawn: Sequence[Path]) -> Path:
    """Write the report page of one run.

    Args:
        result: of the run.
        path: HTML file to write.
        model_file: title, description and the model's text.
        drawn: pictures to show.

    Raises:
        ResultFileError: the page cannot be written.
    """
    from lamella.viz.report import Figure, Section, write_report

    shown = Section("Pictures", figures=[Figure(picture, CAPTIONS.get(picture.name, picture.stem)) for picture in drawn])
    return write_report(
        path,
        model_file.title or "Run",
        [*([shown] if drawn else []), *critical_sections(result), system_section(model_file, result.model)],
        summary=model_file.description,
        model_text=model_file.text(),
        results={path.parent.name: result},
    )


def critical_sections(result: Result) -> list[Section]:
    """What a report says about critical points: nothing, or a table of them."""
    from lamella.viz.report import Section, Table

    rows = [
        [number, point.kind, point.factor, point.at, *point.negative] for number, point in enumerate(result.critical_points, 1)
    ]
    columns = ["Number", "Kind", "Load factor", f"At {result.axis.replace('_', ' ')}"]
    columns += ["Negative eigenvalues before", "behind"]
    return [Section("Critical points", tables=[Table(columns, rows)])] if rows else []


def system_section(model_file: ModelFile, model: Model) -> Section:
    """What a report says about the system: its numbers of bodies, joints, coordinates and constraints."""
    from lamella.viz.report import Section, Table

    size = size_of(model_file.system, model)
    return Section("System", "\n\n".join(size.notes), tables=[Table(["", "number"], list(size.counts.items()))])


def write_pictures(result: Result, folder: Path, output: Output | None = None) -> list[Path]:
    """Draw signals, energies and the bodies into a folder.

    Raises:
        ResultFileError: a file cannot be written.
    """
    from lamella.viz.path import plot_path
    from lamella.viz.plots import plot_energy, plot_signals
    from lamella.viz.scene import picture
    from lamella.viz.style import save_figure

    output = output or Output()
    make_folder(folder)
    traced = [name for name in result.signals if name.endswith(".position")] if result.axis == "path" else []
    files = [save_figure(plot_path(result, traced), folder / "path.png")] if traced else []
    names = None if output.signals is None else recorded(output.signals, result.signals)
    if names is None or names:
        files.append(save_figure(plot_signals(result, names), folder / "signals.png"))
    if any(name.startswith("energy.") for name in result.signals):
        files.append(save_figure(plot_energy(result), folder / "energy.png"))
    if len(result.frame_at) and drawable(result.model):
        at = output.at or _spread(result)
        files.append(picture(result, folder / "shape.png", at=at, field=output.field, view=output.view, scale=output.scale))
    return files


def write_animation(result: Result, path: Path, output: Output | None = None) -> Path:
    """Draw the animation of a result.

    Raises:
        ResultFileError: the file cannot be written.
    """
    from lamella.viz.scene import animation

    output = output or Output()
    return animation(result, path, field=output.field, view=output.view, scale=output.scale)


def _spread(result: Result) -> Sequence[float]:
    """Axis values of a few frames spread over the whole."""
    chosen = np.unique(np.linspace(0, len(result.frame_at) - 1, SHOWN).round().astype(int))
    return [float(result.frame_at[index]) for index in chosen]


def write_signals(result: Result, path: Path) -> Path:
    """Write all signals as a table: one row for each sample, one column for each component, units in the heading.

    Raises:
        ResultFileError: the file cannot be written.
    """
    unit = {"time": "s"}.get(result.axis, "1")
    heading, columns = [f"{result.axis} [{unit}]"], [result.at]
    for name, signal in result.signals.items():
        if name == result.axis:
            continue
        values = result.samples(name)
        for component, label in enumerate(signal.labels or ("",)):
            heading.append(f"{name}{'.' if label else ''}{label} [{signal.unit}]")
            columns.append(values[:, component] if signal.labels else values)
    return write_rows(path, heading, zip(*(column.tolist() for column in columns), strict=True), numbers=True)


def write_values(modes: Shapes, path: Path) -> Path:
    """Write natural frequencies or buckling load factors as a table.

    Raises:
        ResultFileError: the file cannot be written.
    """
    return write_rows(path, ["mode", f"{modes.quantity[0]} [{modes.quantity[1]}]"], shape_table(modes))


def write_rows(path: Path, heading: Sequence[str], rows: Iterable[Sequence[object]], *, numbers: bool = False) -> Path:
    """Write a table as CSV, whole or not at all.

    Args:
        path: file to write.
        heading: names of the columns.
        rows: values of the columns.
        numbers: whether they are numbers of Python alone, which are written faster than values that may have to be quoted.

    Raises:
        ResultFileError: it cannot be written.
    """
    with replaced(path) as partial, partial.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(heading)
        if numbers:
            file.writelines(f"{','.join(map(repr, row))}\r\n" for row in rows)
        else:
            writer.writerows(rows)
    return path
