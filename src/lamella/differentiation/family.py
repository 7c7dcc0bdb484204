"""Families of models: a system and what is computed with it, for any values of some parameters."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from lamella.errors import DeclarationError
from lamella.examples import Example, find_model
from lamella.io.analysis import Analysis
from lamella.io.document import Document
from lamella.io.model_file import ModelFile, loads
from lamella.sweep.parameter import Parameter, with_unit
from lamella.system import System

Values = Mapping[str, float]


class Family(ABC):
    """Models that differ by the values of parameters.

    1. ``at`` makes the same model for the same values.
    2. ``units`` names the parameters in order, with the unit in which their values are counted.
    """

    units: Mapping[str, str]

    @abstractmethod
    def at(self, values: Values) -> tuple[System, Sequence[Analysis]]:
        """The system and what is computed with it.

        Raises:
            LamellaError: there is no such model.
        """


@dataclass(frozen=True)
class FunctionFamily(Family):
    """Systems that a function builds.

    Args:
        build: takes the parameters by name.
        analyses: what is computed with each.
        units: of the parameters, by name; for messages.
    """

    build: Callable[..., System]
    analyses: Sequence[Analysis]
    units: Mapping[str, str]

    def at(self, values: Values) -> tuple[System, Sequence[Analysis]]:
        system = self.build(**values)
        if not isinstance(system, System):
            raise DeclarationError("gradient", f"the function gave {system!r}", "accepted is one that returns a System")
        return system, self.analyses


@dataclass(frozen=True)
class FileFamily(Family):
    """A model file with values replaced.

    Args:
        text: of the model file.
        name: of the file, for messages.
        folder: from which paths in it count.
        parameters: what each replaces, by name.
        units: of their values, by name.
        set: ``key=value`` texts that replace values in all models.
    """

    text: str
    name: str
    folder: Path
    parameters: Mapping[str, Parameter]
    units: Mapping[str, str]
    set: tuple[str, ...] = ()

    @classmethod
    def of(
        cls, model: str | Path, parameters: Mapping[str, Parameter], units: Mapping[str, str], settings: Sequence[str]
    ) -> FileFamily:
        """The family of a model file or example.

        Raises:
            ModelFileError: there is no such file.
        """
        found = find_model(str(model))
        document = Document.read(found.model if isinstance(found, Example) else found)
        return cls(document.text, document.name, document.folder, parameters, units, tuple(settings))

    def settings(self, values: Values) -> tuple[str, ...]:
        """The ``key=value`` texts that make the model for some values."""
        texts = [
            text
            for name, parameter in self.parameters.items()
            for text in parameter.settings(with_unit(values[name], self.units[name]))
        ]
        return (*self.set, *texts)

    def model(self, values: Values) -> ModelFile:
        """The model for some values."""
        return loads(self.text, self.settings(values), self.name, self.folder)

    def at(self, values: Values) -> tuple[System, Sequence[Analysis]]:
        made: Any = self.model(values)
        return made.system, made.analyses
