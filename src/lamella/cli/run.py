"""The command ``lamella run``."""

from __future__ import annotations

import sys
from pathlib import Path

from rich.console import Console
from rich.table import Table

from lamella.examples import Example, find_model
from lamella.io.analysis import shape_table
from lamella.io.model_file import read_model
from lamella.linear.state_space import StateSpace
from lamella.shapes import Shapes
from lamella.study.findings import Finding
from lamella.study.folder import open_folder
from lamella.study.linear_outputs import describe
from lamella.study.run import Finished, run_model
from lamella.study.study import Study, run_study


def run_command(name: str, out: Path | None, settings: list[str], *, overwrite: bool, quiet: bool, pictures: bool) -> None:
    """Run a model file or an example and print a summary."""
    chosen = find_model(name)
    path = chosen.model if isinstance(chosen, Example) else chosen
    model = read_model(path, settings)  # all errors of the file come before anything is written
    folder = out or Path("results") / (chosen.name if isinstance(chosen, Example) else chosen.stem)
    progress = not quiet
    say = say_nothing if quiet else say_on_error_stream
    if not (isinstance(chosen, Example) and chosen.is_study):
        finished = run_model(model, folder, overwrite=overwrite, pictures=pictures, progress=progress, say=say)
        if not quiet:
            _summary({"": finished}, [], folder)
        return
    study = Study(path, open_folder(folder, overwrite), settings, draw=pictures, progress=progress, say=say)
    findings = run_study(chosen.study(), study)
    if not quiet:
        _summary(study.finished, study.files, folder)
        _show_findings(findings)


def say_on_error_stream(text: str) -> None:
    """Print a line beside the results, at once."""
    print(text, file=sys.stderr, flush=True)


def say_nothing(text: str) -> None:
    """Print nothing."""


def _summary(runs: dict[str, list[Finished]], files: list[Path], folder: Path) -> None:
    table = Table("analysis", "ended", "steps", "Newton iterations", "seconds", header_style="bold")
    notes: list[tuple[str, str]] = []
    for variant, finished in runs.items():
        for item in finished:
            label = f"{variant} {item.analysis.name}".strip()
            if isinstance(item.computed, Shapes):
                found = shape_table(item.computed)
                name, unit = item.computed.quantity[0].replace("_", " "), item.computed.quantity[1]
                lowest = f", first {name} {found[0][1]:.5g}{'' if unit == '1' else f' {unit}'}" if found else ""
                table.add_row(label, f"{len(found)} {'shape' if len(found) == 1 else 'shapes'}{lowest}", "", "", "")
                continue
            if isinstance(item.computed, StateSpace):
                table.add_row(label, describe(item.computed), "", "", "")
                continue
            notes += [
                (label, str(note)) for note in (*item.computed.start.notes, *item.computed.events, *item.computed.critical_points)
            ]
            counts = item.computed.statistics
            table.add_row(
                label, str(item.computed.outcome), str(counts.steps), str(counts.newton_iterations), f"{counts.seconds_run:.2f}"
            )
    console = Console(highlight=False, soft_wrap=True)
    if table.row_count:  # an example may be a parameter study alone
        console.print(table)
    for label, note in notes:
        console.print(f"{label}: {note}", markup=False)
    console.print(f"written to {folder}:")
    for path in sorted({path for finished in runs.values() for item in finished for path in item.files} | set(files)):
        if path.is_file():
            console.print(f"  {path.relative_to(folder)}  ({size_text(path.stat().st_size)})")


def size_text(count: int) -> str:
    """Size of a file [bytes] in words."""
    return f"{count / 1e6:.1f} MB" if count >= 1e5 else f"{count / 1e3:.1f} kB"


def _show_findings(findings: list[Finding]) -> None:
    console = Console(highlight=False, soft_wrap=True)
    for finding in findings:
        console.print(f"{'agrees   ' if finding.agrees else 'DISAGREES'} {finding.finding}", markup=False)
        for name, value in finding.numbers.items():
            console.print(
                f"            {name}: {value:.6g}" if isinstance(value, float) else f"            {name}: {value}", markup=False
            )
