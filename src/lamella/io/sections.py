"""The sections of a model file and what each may hold."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any, get_args

from lamella.declaration import KINDS
from lamella.io.analysis import Analysis, Output
from lamella.io.annotation import concrete, in_files, tag_of
from lamella.io.catalogue import public_class
from lamella.material.isotropic import Isotropic
from lamella.material.lamina import Lamina
from lamella.material.laminate import Laminate
from lamella.math.time_function import TimeFunction
from lamella.roles import Declaration
from lamella.system import Redundant

FORMAT = 1
"""Version of the model file's form."""


@dataclass(frozen=True)
class Section:
    """A top-level key.

    Args:
        meaning: a sentence for the schema.
        bases: what its items are: declarations of these classes or their subclasses.
        named: True when it holds ``name: item`` entries, False when it is itself one item.
        required: True when a file must have it.
        plain: JSON Schema of a section that is a plain value.
    """

    meaning: str
    bases: tuple[type, ...] = ()
    named: bool = True
    required: bool = False
    plain: dict[str, Any] | None = None

    def classes(self) -> tuple[type, ...]:
        """The declarations accepted."""
        return _accepted(self.bases, len(KINDS))

    def classes_of(self, tag: object) -> tuple[type, ...]:
        """The declaration that ``type: tag`` means, without importing others, or all accepted when it means none."""
        found = public_class(tag)
        if found is not None and issubclass(found, self.bases) and in_files(found) and tag_of(found) == ("type", tag):
            return (found,)
        return self.classes()


@cache
def _accepted(bases: tuple[type, ...], n_kinds: int) -> tuple[type, ...]:
    """The declarations accepted, kept while there are as many in all."""
    return tuple(cls for base in bases for cls in concrete(base) if in_files(cls))


SECTIONS = {
    "lamella": Section("Version of the model file's form.", plain={"const": FORMAT}, required=True),
    "title": Section("A line for the heads of reports.", plain={"type": "string"}),
    "description": Section("What the model is about.", plain={"type": "string"}),
    "materials": Section("Materials, to be referred to by name.", (Lamina, Isotropic)),
    "laminates": Section("Sections of plates, to be referred to by name.", (Laminate,)),
    "profiles": Section("Functions of time, to be referred to by name.", (TimeFunction,)),
    "redundant": Section(
        "What to do with joint constraints that repeat others: raise an error that names them, or drop them.",
        plain={"enum": list(get_args(Redundant)), "default": "raise"},
    ),
    "system": Section("Bodies, joints and loads by name.", (Declaration,), required=True),
    "analysis": Section("What is computed, by name and in this order.", (Analysis,)),
    "output": Section("What is written besides the result file.", (Output,), named=False),
}
"""All top-level keys in the order they are written."""

DEFINITIONS = ("materials", "laminates", "profiles")
"""Sections whose items are referred to by name."""
