"""The folder of a study: which study it is, and a file for each finished run, so that an interrupted study goes on."""

from __future__ import annotations

import hashlib
import json
import os
import shutil
from dataclasses import asdict
from pathlib import Path
from typing import Any

from lamella import __version__
from lamella.errors import ResultFileError
from lamella.study.folder import open_folder
from lamella.sweep.study import Checked
from lamella.sweep.task import Row
from lamella.whole import remove_abandoned, replaced, write_text

IDENTITY, RUNS = "study.json", "runs"
TABLES = ("table.csv", "table.parquet", "sensitivity.csv")
STUDY_COPY = "study.yaml"
WRITTEN = (IDENTITY, RUNS, STUDY_COPY, *TABLES)


class Store:
    """A study's folder.

    Args:
        folder: where to write; made when it is not there.
        checked: the study.
        overwrite: replace what is there.

    Raises:
        ResultFileError: it holds another study or the results of a run, or cannot be written.
    """

    def __init__(self, folder: Path, checked: Checked, overwrite: bool) -> None:
        self.folder = folder
        identity = _identity(checked)
        found = os.path.exists(folder / IDENTITY)  # no error for a name that no folder can have
        if found and not overwrite:
            _compare(folder, identity)
            return
        if found:
            _clear(folder)
        open_folder(folder, overwrite)
        try:
            (folder / RUNS).mkdir(exist_ok=True)
            if checked.source:
                write_text(folder / STUDY_COPY, checked.source)
            _write(folder / IDENTITY, identity)
        except OSError as error:
            raise ResultFileError(f"'{folder}' cannot be written: {error.strerror or error}") from error

    def finished(self, total: int) -> dict[int, Row]:
        """The rows of an earlier session by number; lost runs and files that are not whole are left out, to be run again."""
        found = {}
        for number in range(1, total + 1):
            try:
                row = Row(**json.loads(self._path(number).read_text(encoding="utf-8")))
            except (OSError, ValueError, TypeError):
                continue
            if row.status != "lost":
                found[number] = row
        return found

    def keep(self, row: Row) -> None:
        """Write a row, whole or not at all.

        Raises:
            ResultFileError: it cannot be written.
        """
        _write(self._path(row.number), asdict(row))

    def _path(self, number: int) -> Path:
        return self.folder / RUNS / f"{number:06d}.json"


def _identity(checked: Checked) -> dict[str, str]:
    """What makes a study the same one: not where its files lie, nor how many workers it has."""
    study = checked.study
    columns = [[name, *parameter.factors.items()] for name, parameter in study.parameters.items()]
    parts: dict[str, Any] = {
        "model": checked.base.text(),
        "parameters": columns,
        "design": study.rows(),
        "outputs": {name: repr(output) for name, output in study.outputs.items()},
    }
    hashes = {name: hashlib.sha256(json.dumps(part).encode()).hexdigest() for name, part in parts.items()}
    return {"format": "lamella study", "version of lamella": __version__, **hashes}


def _compare(folder: Path, identity: dict[str, str]) -> None:
    advice = "give --overwrite to replace it, or another folder with --out"
    try:
        found = json.loads((folder / IDENTITY).read_text(encoding="utf-8"))
        differing = [name for name in identity if found.get(name) != identity[name]]
    except (OSError, ValueError, AttributeError) as error:
        raise ResultFileError(f"'{folder / IDENTITY}' cannot be read ({error}); {advice}") from error
    if differing:
        raise ResultFileError(f"'{folder}' holds another study: it differs in {', '.join(differing)}; {advice}")
    try:
        (folder / RUNS).mkdir(exist_ok=True)
        remove_abandoned(folder / RUNS)
    except OSError as error:
        raise ResultFileError(f"'{folder}' cannot be written: {error.strerror or error}") from error


def _clear(folder: Path) -> None:
    try:
        for path in (folder / name for name in WRITTEN):
            if path.is_dir():
                shutil.rmtree(path)
            else:
                path.unlink(missing_ok=True)
    except OSError as error:
        raise ResultFileError(f"'{folder}' cannot be cleared: {error.strerror or error}") from error


def _write(path: Path, content: dict[str, Any]) -> None:
    """Write it whole or not at all, also when the machine stops."""
    with replaced(path) as partial, partial.open("w", encoding="utf-8") as file:
        json.dump(content, file, indent=1, ensure_ascii=False)
        file.flush()
        os.fsync(file.fileno())
