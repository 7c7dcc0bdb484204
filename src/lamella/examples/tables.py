"""A parameter study inside an example."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from lamella.sweep.run import run_parameter_study
from lamella.sweep.study import read_study

if TYPE_CHECKING:
    from lamella.study.study import Study
    from lamella.sweep.table import StudyResult


def run_study(study: Study, file: Path, folder: str) -> StudyResult:
    """Run a study file with the overrides of the example, into a folder of its results."""
    source = read_study(file)
    chosen = replace(source.study, set=(*source.study.set, *study.overrides))
    result = run_parameter_study(
        replace(source, study=chosen), study.folder / folder, pictures=study.draw, progress=study.progress, say=study.say
    )
    study.files.extend(result.files)
    return result
