"""Everything a finished study writes: tables, pictures, sensitivities, and the page that shows them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import astuple
from pathlib import Path

from lamella.study.folder import PICTURES
from lamella.study.outputs import make_folder, write_rows
from lamella.sweep.designs import SaltelliDesign
from lamella.sweep.sensitivity import CONFIDENCE, Sensitivity, points_used, sensitivities
from lamella.sweep.study import Checked
from lamella.sweep.table import StudyResult, write_tables

MOST_ROWS = 100
"""Runs shown on the page; the table has all."""


def write_outputs(result: StudyResult, checked: Checked, folder: Path, pictures: bool) -> list[Path]:
    """Write tables, and pictures with the report.

    Raises:
        ResultFileError: a file cannot be written.
    """
    files = write_tables(result.columns(), folder, "table")
    found = sensitivities(result)
    if found:
        heading = ["output", "parameter", "measure", "value", "low", "high"]
        files.append(write_rows(folder / "sensitivity.csv", heading, map(astuple, found)))
    if not pictures:
        return files
    drawn = _write_pictures(result, found, folder / PICTURES)
    return [*files, *drawn, _write_page(result, checked, found, drawn, folder / "report.html")]


def _write_pictures(result: StudyResult, found: Sequence[Sensitivity], folder: Path) -> dict[Path, str]:
    from lamella.sweep.drawing import sensitivity_figure, study_figures
    from lamella.viz.style import save_figure

    figures = study_figures(result)
    if found:
        figures["sensitivity"] = (sensitivity_figure(result, found), _meaning(result))
    make_folder(folder)
    return {save_figure(figure, folder / f"{name}.png"): caption for name, (figure, caption) in figures.items()}


def _write_page(result: StudyResult, checked: Checked, found: Sequence[Sensitivity], drawn: dict[Path, str], path: Path) -> Path:
    from lamella.viz.report import Figure, Section, Table, write_report

    study, failures = result.study, result.failures
    sections = [Section("Pictures", figures=[Figure(picture, caption) for picture, caption in drawn.items()])]
    if found:
        rows = [[item.output, item.parameter, item.measure, item.value, item.low, item.high] for item in found]
        columns = ["Output", "Parameter", "Measure", "Value", f"{CONFIDENCE:.0%} from", "to"]
        sections.append(Section("Sensitivity", _meaning(result), tables=[Table(columns, rows)]))
    if failures:
        rows = [[row.number, row.status, row.message] for row in failures[:MOST_ROWS]]
        sections.append(Section("Runs that failed", tables=[Table(["Run", "Status", "Message"], rows)]))
    table = {name: values for name, values in result.columns().items() if name != "message"}
    rows = [["" if cell is None else cell for cell in row] for row in zip(*table.values(), strict=True)][:MOST_ROWS]
    note = "" if len(result.rows) <= MOST_ROWS else f"The first {MOST_ROWS}; all are in table.csv."
    sections.append(Section("Runs", note, tables=[Table(list(table), rows)]))
    if checked.source:
        sections.append(Section("Study", code=checked.source))
    counts = f"{len(result.rows)} runs, {len(failures)} of them failed." if failures else f"{len(result.rows)} runs, none failed."
    return write_report(
        path,
        study.title or f"Parameter study of {checked.base.title or study.model}",
        sections,
        summary="\n\n".join(part for part in (study.description, counts) if part),
        model_text=checked.text,
    )


def _meaning(result: StudyResult) -> str:
    """What the measures of sensitivity are, in a sentence."""
    used = points_used(result)
    if isinstance(result.study.design, SaltelliDesign):
        return (
            f"Sobol's indices from {used} of {result.study.design.base} points of the base sample: the share of an output's "
            "variance that a parameter causes alone (first order), and with its interactions (total); "
            f"bars show {CONFIDENCE:.0%} confidence"
        )
    return (
        f"Spearman's rank correlation over {used} runs: 1 or -1 where an output always rises or falls with a parameter; "
        f"bars show {CONFIDENCE:.0%} confidence"
    )
