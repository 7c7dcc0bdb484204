"""Examples: ready-made model files, some of them studies that compare several models with a paper.

An example is a folder of this package with

- ``model.yaml``: the model; its ``title`` is the example's,
- ``README.md``: what it shows,
- ``study.py`` (optional): ``def study(study: lamella.study.Study) -> Iterable[Finding]``, which runs variants of the model
  (``study.run(name, overrides)``), shows figures (``study.show(figure, name, caption)``) and yields findings.

Folder names have ``_`` where the example's name has ``-``; folders that begin with ``_`` are left out.
"""

from __future__ import annotations

import importlib
import os
import re
import shutil
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from lamella.errors import ModelError, ModelFileError, ResultFileError, no_such

if TYPE_CHECKING:
    from lamella.study.findings import Finding
    from lamella.study.study import Study

FOLDER = Path(__file__).parent


@dataclass(frozen=True)
class Example:
    """A folder with a model file."""

    folder: Path

    @property
    def name(self) -> str:
        return self.folder.name.replace("_", "-")

    @property
    def model(self) -> Path:
        """The model file."""
        return self.folder / "model.yaml"

    @property
    def title(self) -> str:
        """The title in the model file, found without reading the rest."""
        found = re.search(r"^title: *(.+)$", self.model.read_text(encoding="utf-8"), re.MULTILINE)
        return found.group(1).strip("\"' ") if found else self.name

    @property
    def is_study(self) -> bool:
        return (self.folder / "study.py").is_file()

    def study(self) -> Callable[[Study], Iterable[Finding]]:
        """The function that runs the example's variants and yields findings."""
        return importlib.import_module(f"lamella.examples.{self.folder.name}.study").study

    def copy(self, target: Path) -> list[Path]:
        """Copy the example's files into a folder that does not exist yet or is empty; returns the files written.

        Raises:
            ResultFileError: the folder holds files, or cannot be written.
        """
        try:
            if target.exists() and (not target.is_dir() or any(target.iterdir())):
                raise ResultFileError(f"'{target}' exists already; choose another folder")
            shutil.copytree(self.folder, target, ignore=shutil.ignore_patterns("__pycache__", "__init__.py"), dirs_exist_ok=True)
        except OSError as error:
            raise ResultFileError(f"'{target}' cannot be written: {error.strerror or error}") from error
        return sorted(path for path in target.rglob("*") if path.is_file())


def examples() -> dict[str, Example]:
    """All examples by name."""
    found = [Example(path.parent) for path in sorted(FOLDER.glob("[!_]*/model.yaml"))]
    return {example.name: example for example in found}


def example(name: str) -> Example:
    """The example called ``name``.

    Raises:
        ModelError: there is none; the message lists all.
    """
    known = examples()
    name = name.replace("_", "-")
    if name not in known:
        raise ModelError(no_such("example", name, known))
    return known[name]


def find_model(name: str) -> Path | Example:
    """The model file or example called ``name``; a file comes first.

    Raises:
        ModelFileError: there is neither.
    """
    path = Path(name)
    if os.path.exists(path):  # no error for a name that no file can have
        return path
    if name.replace("_", "-") in examples():
        return example(name)
    if path.suffix or len(path.parts) > 1:
        raise ModelFileError(f"the model file '{name}' does not exist; 'lamella new {path.stem}' writes one to start from")
    known = ", ".join(examples()) or "none"
    raise ModelFileError(f"'{name}' is neither a model file nor an example; examples are: {known}")
