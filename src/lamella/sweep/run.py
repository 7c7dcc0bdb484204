"""Run a parameter study into a folder: workers, progress, rows kept as they are finished, tables, pictures, report."""

from __future__ import annotations

from collections import Counter
from contextlib import ExitStack, closing
from dataclasses import replace
from pathlib import Path

from lamella import threads
from lamella.arguments import PATH, accepts, instance
from lamella.errors import WorkerError
from lamella.progress import CountBar
from lamella.study.run import Say, silent
from lamella.sweep.cluster import ClusterWorkers
from lamella.sweep.local import LocalWorkers
from lamella.sweep.report import write_outputs
from lamella.sweep.store import Store
from lamella.sweep.study import Checked, ParameterStudy, StudyFile
from lamella.sweep.table import StudyResult
from lamella.sweep.task import Row, Task


@accepts(study=instance("a ParameterStudy, or what read_study gives", ParameterStudy, StudyFile), folder=PATH)
def run_parameter_study(
    study: ParameterStudy | StudyFile,
    folder: str | Path,
    *,
    overwrite: bool = False,
    pictures: bool = True,
    progress: bool = False,
    say: Say = silent,
) -> StudyResult:
    """Run a parameter study, or go on with one that was interrupted.

    A script calls it below ``if __name__ == "__main__":``, because each worker process imports the script.

    Args:
        study: what to run.
        folder: where to write; when it holds the same study already, runs that are finished are not repeated.
        overwrite: start anew, whatever the folder holds.
        pictures: draw and write the report.
        progress: show a progress bar.
        say: takes messages.

    Raises:
        ModelFileError, DeclarationError: model, parameters, design and outputs do not go together.
        ResultFileError: the folder holds something else, or cannot be written.
        WorkerError: workers or cluster cannot be reached, or were lost.
        KeyboardInterrupt: the user interrupted; what is finished is kept.
    """
    source = study if isinstance(study, StudyFile) else StudyFile(study)
    folder, asked = Path(folder), source.study
    with ExitStack() as stack:
        workers: LocalWorkers | ClusterWorkers | None = None
        if asked.cluster is None:  # first of all: they start while the study is checked
            workers = stack.enter_context(LocalWorkers(asked.workers or threads.cores(), say))
        checked = source.checked()
        store = Store(folder, checked, overwrite)
        tasks = _tasks(checked)
        rows = store.finished(len(tasks))
        if rows:
            say(f"{len(rows)} of {len(tasks)} runs are finished already")
        left = [task for task in tasks if task.number not in rows]
        if left:
            try:
                if asked.cluster is not None:
                    workers = stack.enter_context(ClusterWorkers(asked.cluster, say))
                assert workers is not None
                _run(workers, store, left, rows, progress)
            except KeyboardInterrupt as error:
                raise KeyboardInterrupt(_so_far(rows, tasks, folder)) from error
            except WorkerError as error:
                raise WorkerError(f"{error}; {_so_far(rows, tasks, folder)}") from error
    result = StudyResult(checked.study, checked.units, [rows[task.number] for task in tasks])
    return replace(result, files=write_outputs(result, checked, folder, pictures))


def _tasks(checked: Checked) -> list[Task]:
    study = checked.study
    return [
        Task(number, checked.text, str(checked.path), checked.path.parent.absolute(), study.settings(row), study.outputs)
        for number, row in enumerate(study.rows(), start=1)
    ]


def _run(workers: LocalWorkers | ClusterWorkers, store: Store, left: list[Task], rows: dict[int, Row], progress: bool) -> None:
    """Run the tasks that are left; ``rows`` grows as they are finished."""
    with closing(workers.run(left)) as finished:
        bar = CountBar("study", len(rows), len(rows) + len(left), "runs") if progress else None
        try:
            for row in finished:
                store.keep(row)
                rows[row.number] = row
                if bar is not None:
                    failed = Counter(kept.status != "ok" for kept in rows.values())[True]
                    bar.count(len(rows), f"{failed} failed" if failed else "")
        finally:
            if bar is not None:
                bar.end()


def _so_far(rows: dict[int, Row], tasks: list[Task], folder: Path) -> str:
    return f"{len(rows)} of {len(tasks)} runs are finished and kept in '{folder}'; the same command goes on from there"
