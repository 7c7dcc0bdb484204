"""One run of a study, as a worker does it: nothing is written, and what goes wrong comes back as a message."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

from lamella import __version__
from lamella.errors import DeclarationError, LamellaError
from lamella.io.analysis import Computed
from lamella.io.catalogue import import_catalogue
from lamella.io.model_file import loads
from lamella.result import Result
from lamella.sweep.outputs import StudyOutput

Status = Literal["ok", "failed", "lost"]
"""A run is ``ok``; it ``failed``, as it would again; or it was ``lost`` with its worker, and a resumed study tries it again."""


@dataclass(frozen=True)
class Task:
    """What a worker needs to know of a run.

    Args:
        number: of the run in the design, from 1.
        text: of the model file; a worker on another machine does not see the file.
        name: of the model file, for messages.
        folder: from which paths in it count.
        settings: ``key=value`` texts of this run.
        outputs: what is kept, by name.
    """

    number: int
    text: str
    name: str
    folder: Path
    settings: tuple[str, ...]
    outputs: Mapping[str, StudyOutput]


@dataclass(frozen=True)
class Row:
    """What a run gave.

    Args:
        number: of the run in the design, from 1.
        status: ``ok``, ``failed`` or ``lost``.
        values: of the outputs, by name; empty unless it is ok.
        message: why it failed.
        seconds: time it took.
        version: of lamella in the worker.
    """

    number: int
    status: Status
    values: Mapping[str, float] = field(default_factory=dict)
    message: str = ""
    seconds: float = 0.0
    version: str = __version__


def import_all() -> None:
    """Import what runs need and this module has not: all that a model may be made of."""
    import_catalogue()


def run_task(task: Task) -> Row:
    """Compute a run's outputs; a model that cannot be read or solved gives a failed row."""
    start = time.perf_counter()
    try:
        values = _values(task)
    except LamellaError as error:
        return Row(task.number, "failed", {}, " ".join(str(error).split()), time.perf_counter() - start)
    return Row(task.number, "ok", values, "", time.perf_counter() - start)


def _values(task: Task) -> dict[str, float]:
    model_file = loads(task.text, task.settings, task.name, task.folder)
    analyses = {analysis.name: analysis for analysis in model_file.analyses}
    chosen = {name: output.chosen(analyses).name for name, output in task.outputs.items()}
    model = model_file.system.compile()
    earlier: dict[str, Computed] = {}
    for analysis in analyses.values():
        if set(chosen.values()) <= set(earlier):  # what comes behind the last one needed is left out
            break
        computed = analysis.run(analysis.prepared(model, earlier), earlier, 1, ())
        if isinstance(computed, Result) and not computed.outcome.completed:
            raise LamellaError(f"analysis '{analysis.name}' {computed.outcome}")
        earlier[analysis.name] = computed
    values = {name: output.value(earlier[chosen[name]]) for name, output in task.outputs.items()}
    for name, value in values.items():
        if not math.isfinite(value):
            raise DeclarationError(f"output '{name}'", f"found {value}", "accepted is a finite number")
    return values
