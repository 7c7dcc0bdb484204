"""The commands ``lamella plot`` and ``lamella export``."""

from __future__ import annotations

import difflib
from collections.abc import Callable
from pathlib import Path

from lamella.errors import ModelFileError, ResultFileError
from lamella.io.results import read_result
from lamella.io.stored_result import StoredResult
from lamella.study.folder import PICTURES, result_path
from lamella.study.outputs import write_animation, write_pictures, write_run_report, write_signals
from lamella.whole import write_text


def plot_command(path: Path, signals: list[str], out: Path | None) -> None:
    """Plot signals of a result into a picture file."""
    from lamella.viz.plots import plot_signals
    from lamella.viz.style import save_figure

    result = read_result(result_path(path))
    target = out or result.path.with_name("signals.png")
    save_figure(plot_signals(result, signals or None, title=result.title), target)
    print(f"wrote {target}")


def export_command(path: Path, form: str, out: Path | None) -> None:
    """Write a result in another form beside the result file, or to ``out``."""
    forms = _forms()
    if form not in forms:
        near = difflib.get_close_matches(form, forms, 1)
        hint = f"; did you mean '{near[0]}'?" if near else ";"
        raise ResultFileError(f"there is no form '{form}'{hint} accepted are {', '.join(forms)}")
    result = read_result(result_path(path))
    name, write = forms[form]
    for written in write(result, out or result.path.with_name(name)):
        print(f"wrote {written}")


Write = Callable[[StoredResult, Path], list[Path]]


def _forms() -> dict[str, tuple[str, Write]]:
    """File name and writer of each form."""
    return {
        "vtkhdf": ("surface.vtkhdf", _write_vtkhdf),
        "csv": ("signals.csv", lambda result, path: [write_signals(result, path)]),
        "png": ("pictures", write_pictures),
        "gif": ("animation.gif", lambda result, path: [write_animation(result, path)]),
        "html": ("report.html", _write_html),
        "yaml": ("model.yaml", _write_model),
    }


def _write_html(result: StoredResult, path: Path) -> list[Path]:
    from lamella.io.model_file import loads

    drawn = write_pictures(result, path.parent / PICTURES)
    return [*drawn, write_run_report(result, path, loads(result.model_text, name=str(result.path)), drawn)]


def _write_vtkhdf(result: StoredResult, path: Path) -> list[Path]:
    from lamella.io.vtk import write_vtkhdf

    return [write_vtkhdf(result, path)]


def _write_model(result: StoredResult, path: Path) -> list[Path]:
    if not result.model_text:
        raise ModelFileError(f"'{result.path}' holds no model; accepted is the result of a model that can be written as a file")
    write_text(path, result.model_text)
    return [path]
