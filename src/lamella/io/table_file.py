"""Tables of a model file whose points stand in a file of their own: ``{kind: table, file: forces.csv}``."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from pydantic import TypeAdapter, ValidationError

from lamella.errors import DeclarationError
from lamella.io.document import Document, Place, shown
from lamella.math.table import Interpolation, Table

FILE = "file"
"""Key that takes the place of ``times`` and ``values``."""

SCHEMA = {
    "type": "string",
    "description": "CSV file with two columns, time [s] and value, in the place of times and values; relative to the model file.",
}
KEYS = ("kind", FILE, "interpolation")


def read_table(document: Document, data: dict[str, Any], place: Place) -> Table | None:
    """The table a mapping with the key ``file`` describes; None after a problem, which the document keeps.

    Args:
        document: the model file, from whose folder the path counts.
        data: the mapping.
        place: where it stands.
    """
    for key in data:
        if key not in KEYS:
            document.problem((*place, key), f"'{key}' does not go with '{FILE}'; accepted are {', '.join(KEYS[1:])}")
            return None
    name, interpolation = data[FILE], data.get("interpolation", "linear")
    if not isinstance(name, str) or not name:
        document.problem((*place, FILE), f"found {shown(name)}; accepted is the path of a CSV file")
        return None
    try:
        TypeAdapter(Interpolation).validate_python(interpolation)
    except ValidationError:
        text = f"found {shown(interpolation)}; accepted are linear, pchip, cubic"
        document.problem((*place, "interpolation"), text)
        return None
    path = document.folder / Path(name).expanduser()
    try:
        return Table.from_csv(path, interpolation)
    except DeclarationError as error:
        document.problem((*place, FILE), f"'{path}': {error.problem}; {error.accepted}")
        return None
