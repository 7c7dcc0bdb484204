"""Quantities that have been read before, kept in a file: a start that needs no Pint is 0.4 s shorter."""

from __future__ import annotations

import atexit
import json
from contextlib import suppress
from pathlib import Path

from lamella.errors import ResultFileError
from lamella.whole import write_text

MOST = 5000
"""Quantities in the file; when there are more, it begins anew."""


class Remembered:
    """The values of texts with units, by text and unit, from a file that is written when the process ends.

    A file that cannot be read or written only costs time: Pint reads the texts again.

    Args:
        path: the file.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._values = self._read()
        self._changed = False

    def _read(self) -> dict[str, float]:
        try:
            found = json.loads(self.path.read_text(encoding="utf-8"))
        except (OSError, ValueError):
            return {}
        usable = isinstance(found, dict) and len(found) <= MOST
        return {text: value for text, value in found.items() if isinstance(value, float)} if usable else {}

    def get(self, text: str, unit: str) -> float | None:
        """The value of a text in a unit; None when it is not known yet."""
        return self._values.get(f"{text}\n{unit}")

    def put(self, text: str, unit: str, value: float) -> float:
        """Remember a value from now on, and give it back."""
        if not self._changed:
            atexit.register(self.write)
        self._changed = True
        self._values[f"{text}\n{unit}"] = value
        return value

    def write(self) -> None:
        """Write the file whole or not at all; of two processes that end together one wins."""
        with suppress(OSError, ResultFileError):
            self.path.parent.mkdir(parents=True, exist_ok=True)
            write_text(self.path, json.dumps(self._values))
