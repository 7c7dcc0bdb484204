"""Files that say what is done with a model: studies and optimisations."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path
from typing import Any, Protocol, TypeVar

from lamella.errors import LamellaError, ModelFileError
from lamella.examples import find_model
from lamella.io.document import KINDS, Document, refuse_other_kind
from lamella.io.reader import FAILED, Reader


class OfModel(Protocol):
    """A declaration that names a model file, or an example."""

    @property
    def model(self) -> str: ...


Declared = TypeVar("Declared", bound=OfModel)


def read_declaration(path: str | Path, kind: type[Declared], key: str) -> tuple[Declared, Document]:
    """What a file declares, with the path of its model as seen from here.

    Args:
        path: the file.
        kind: what it is to declare.
        key: of its first line, one of ``KINDS``.

    Raises:
        ModelFileError: it cannot be read, or does not describe that; all its problems are listed with their lines.
    """
    document = Document.read(Path(path))
    data: dict[str, Any] = document.data
    if key not in data:
        refuse_other_kind(document, key)
        document.problem((), f"the line '{key}: 1' is missing, which says that this is {KINDS[key][0]} file and its version")
    declared = Reader(document, lambda *_: None).declared((kind,), data, ())
    document.check()
    assert declared is not FAILED
    beside = document.folder / declared.model
    if os.path.exists(beside):  # no error for a name that no file can have
        declared = replace(declared, model=str(beside))
    try:
        find_model(declared.model)
    except LamellaError as error:
        raise ModelFileError(f"{document.name}, {document.where(('model',))}: {error}") from error
    return declared, document
