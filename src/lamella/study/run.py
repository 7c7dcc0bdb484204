"""Run the analyses of a model file, one after another, into a folder."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from lamella.assembly.equations import Equations
from lamella.compilation import compilation_notice
from lamella.ended_early import error_of
from lamella.errors import LamellaError, ModelFileError, ResultFileError
from lamella.io.analysis import Analysis, Computed
from lamella.io.model_file import ModelFile
from lamella.io.results import ResultWriter
from lamella.linear.state_space import StateSpace
from lamella.model import Model
from lamella.progress import ProgressBar
from lamella.result import Cause, Result, Sink
from lamella.study.beforehand import refuse_unknown
from lamella.study.folder import MODEL, RESULT, check_folder, open_folder, swept
from lamella.study.interruption import Interruption
from lamella.study.linear_outputs import write_linear_outputs
from lamella.study.outputs import write_outputs
from lamella.whole import write_text

Say = Callable[[str], None]


def silent(text: str) -> None:
    """Say nothing."""


@dataclass(frozen=True)
class Finished:
    """One analysis that has been run.

    Args:
        analysis: what was asked for.
        computed: the result, the modes or the linear model.
        files: what was written, in the order written.
        failure: why it ended early, empty when it completed.
    """

    analysis: Analysis
    computed: Computed
    files: list[Path] = field(default_factory=list)
    failure: str = ""


def run_model(
    model_file: ModelFile,
    folder: Path,
    *,
    overwrite: bool = True,
    pictures: bool = True,
    progress: bool = False,
    say: Say = silent,
) -> list[Finished]:
    """Run all analyses of a model file; those after one that did not complete are left out.

    Args:
        model_file: what to run.
        folder: made, or cleared of an earlier run, once the system is compiled; each analysis has one of its own in it when
            there are several.
        overwrite: replace the results of an earlier run.
        pictures: write plots, pictures and the report.
        progress: show a progress bar.
        say: takes messages such as that kernels are being compiled.

    Returns:
        What was computed, with the files written.

    Raises:
        KeyboardInterrupt: the user interrupted; the result file is closed and says how far the solution got.
        ConvergenceError: an analysis stopped early; what it gave until then is written.
        ResultFileError: the folder holds results and ``overwrite`` is False, or it cannot be written.
    """
    if not model_file.analyses:
        name, sample = model_file.name or "the model", "'analysis: {swing: {type: motion, t_end: 1 s}}'"
        raise ModelFileError(f"{name} asks for no analysis; add one, for example {sample}")
    check_folder(folder, overwrite)
    text = model_file.text()
    with compilation_notice(progress, say), swept(folder):
        model = model_file.system.compile()
        refuse_unknown(model_file, model, pictures=pictures)
        open_folder(folder, overwrite)
        finished: list[Finished] = []
        for analysis in model_file.analyses:
            place = folder if len(model_file.analyses) == 1 else folder / analysis.name
            earlier = {item.analysis.name: item.computed for item in finished}
            with swept(place):
                place.mkdir(exist_ok=True)
                done = _run_analysis(model_file, text, model, analysis, earlier, place, progress)
                write_text(place / MODEL, text)
                done.files.append(place / MODEL)
            finished.append(done)
            if isinstance(done.computed, StateSpace):
                done.files.extend(write_linear_outputs(model_file, done.computed, model, place, pictures))
            else:
                done.files.extend(write_outputs(model_file, analysis, done.computed, place, pictures, say))
            _raise_failure(done, place)
    return finished


def _run_analysis(
    model_file: ModelFile,
    text: str,
    model: Model,
    analysis: Analysis,
    earlier: Mapping[str, Computed],
    folder: Path,
    progress: bool,
) -> Finished:
    model = analysis.prepared(model, earlier)
    sinks: list[Sink] = []
    files: list[Path] = []
    writer = None
    if analysis.axis:
        signals = analysis.signals(Equations(model))
        files.append(folder / RESULT)
        writer = ResultWriter(
            files[0],
            signals,
            analysis.axis,
            model.n_q,
            model_text=text,
            title=model_file.title,
            target=analysis.target,
            imperfection=model.imperfection,
        )
        sinks.append(writer)
    if progress and analysis.axis:
        sinks.append(ProgressBar(analysis.name, *analysis.span, "s" if analysis.axis == "time" else ""))
    sinks.append(Interruption())
    try:
        computed = analysis.run(model, earlier, model_file.output.frames, sinks)
    except LamellaError:  # nothing was computed; what ends early comes back with its outcome
        if writer is not None:
            writer.discard()
        raise
    failure = str(computed.outcome) if isinstance(computed, Result) and not computed.outcome.completed else ""
    return Finished(analysis, computed, files, failure)


def _raise_failure(done: Finished, folder: Path) -> None:
    if not done.failure:
        return
    assert isinstance(done.computed, Result)
    text = f"analysis '{done.analysis.name}' {done.failure}; what was computed is in '{folder}'"
    if done.computed.outcome.cause is Cause.WRITE_FAILED:
        raise ResultFileError(text)
    raise error_of(done.computed, text)
