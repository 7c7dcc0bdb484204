"""The command ``lamella study``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from rich.console import Console

from lamella.cli.run import say_nothing, say_on_error_stream, size_text
from lamella.errors import ConvergenceError
from lamella.sweep.run import run_parameter_study
from lamella.sweep.study import read_study
from lamella.sweep.table import StudyResult

SHOWN = 5
"""Messages of failed runs shown."""


def study_command(
    path: Path,
    out: Path | None,
    settings: Sequence[str],
    *,
    workers: int | None,
    cluster: str | None,
    overwrite: bool,
    quiet: bool,
    pictures: bool,
) -> None:
    """Run a study file and say what was written.

    Raises:
        ConvergenceError: not one run gave anything.
    """
    source = read_study(path)
    study = replace(source.study, set=(*source.study.set, *settings))
    if workers is not None:  # the command line counts more than the file
        study = replace(study, workers=workers, cluster=cluster)
    elif cluster is not None:
        study = replace(study, workers=None, cluster=cluster)
    folder = out or Path("results") / path.stem
    result = run_parameter_study(
        replace(source, study=study),
        folder,
        overwrite=overwrite,
        pictures=pictures,
        progress=not quiet,
        say=say_nothing if quiet else say_on_error_stream,
    )
    if not quiet:
        _summary(result, folder)
    if not result.ok.any():
        raise ConvergenceError(f"none of the {len(result.rows)} runs gave its outputs; the first: {result.rows[0].message}")


def _summary(result: StudyResult, folder: Path) -> None:
    console = Console(highlight=False, soft_wrap=True)
    failures = result.failures
    console.print(f"{len(result.rows)} runs, {len(failures)} failed")
    for row in failures[:SHOWN]:
        console.print(f"  run {row.number} {row.status}: {row.message}", markup=False)
    if len(failures) > SHOWN:
        console.print(f"  ... and {len(failures) - SHOWN} more, see the table")
    console.print(f"written to {folder}:")
    for file in result.files:
        console.print(f"  {file.relative_to(folder)}  ({size_text(file.stat().st_size)})")
