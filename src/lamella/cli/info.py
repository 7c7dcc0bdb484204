"""The command ``lamella info``: what is in a result or model file."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from rich.console import Console
from rich.table import Column, Table

from lamella.errors import ModelFileError
from lamella.io.analysis import Analysis
from lamella.io.annotation import tag_of
from lamella.io.model_file import ModelFile, loads, read_model
from lamella.study.folder import result_path
from lamella.study.size import size_of

if TYPE_CHECKING:
    from lamella.result import Result


WIDE = 120
"""Letters in a line of what goes to a file or a pipe, which has no width of its own."""


def info_command(path: Path) -> None:
    """Print what is in a result file, in a folder's result file, or in a model file."""
    console = Console(highlight=False, soft_wrap=True)
    if not console.is_terminal:
        console.width = WIDE
    if not path.exists():
        raise ModelFileError(f"'{path}' does not exist; accepted is a result file, a folder of results, or a model file")
    if path.suffix in (".yaml", ".yml", ".json"):
        _show_model(console, read_model(path))
        return
    from lamella.io.results import read_result

    result = read_result(result_path(path))
    console.print(f"{result.path}: {result.title or 'result'}", style="bold")
    _show_result(console, result)
    created, version = result.attributes.get("created", ""), result.attributes.get("lamella_version", "")
    console.print(f"written {created} by lamella {version}")
    if result.model_text:
        _show_model(console, loads(result.model_text, name="stored model"))
    elif result.model_missing:
        console.print(f"without its model: {result.model_missing}", markup=False)


def _show_result(console: Console, result: Result) -> None:
    samples, frames = len(result.at), len(result.frame_at)
    console.print(f"{result.outcome}; {samples} samples over {result.axis}, {frames} frames")
    for note in (*result.start.notes, *result.events, *result.critical_points):
        console.print(str(note), markup=False)
    done = {name: value for name, value in result.statistics.as_dict().items() if value}
    console.print(", ".join(f"{name.replace('_', ' ')} {value:g}" for name, value in done.items()))
    columns = [
        name + max([f".{label}" for label in signal.labels], key=len, default="") for name, signal in result.signals.items()
    ]
    whole = Column("signal", no_wrap=True, min_width=max(map(len, columns), default=0))  # names are for copying
    table = Table(whole, "unit", "first", "last", "smallest", "largest", header_style="bold")
    for name, signal in result.signals.items():
        values = result.samples(name).reshape(samples, -1)
        for component, label in enumerate(signal.labels or ("",)):
            column = values[:, component]
            numbers = (column[0], column[-1], column.min(), column.max()) if samples else (np.nan,) * 4
            table.add_row(f"{name}{'.' if label else ''}{label}", signal.unit, *(f"{number:.4g}" for number in numbers))
    console.print(table)


def _show_model(console: Console, model: ModelFile) -> None:
    console.print(f"{model.name}: {model.title}", style="bold")
    if model.description:
        console.print(model.description.strip())
    table = Table("name", "type", "what", header_style="bold")
    for item in model.system.declarations:
        table.add_row(item.name, tag_of(type(item))[1], _summary(type(item)))
    for analysis in model.analyses:
        table.add_row(analysis.name, tag_of(type(analysis))[1], _summary(type(analysis)))
    console.print(table)
    size = size_of(model.system, model.system.compile())
    console.print("\n".join([str(size), *size.notes]))


def _summary(cls: type) -> str:
    assert not issubclass(cls, Analysis) or cls.__doc__
    return (cls.__doc__ or "").strip().splitlines()[0]
