"""A parameter study as data, from Python or from a file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field

from lamella.assembly.equations import Equations
from lamella.declaration import declaration
from lamella.errors import DeclarationError, LamellaError, ModelFileError
from lamella.examples import Example, find_model
from lamella.io.document import Document, Place
from lamella.io.model_file import ModelFile, loads
from lamella.sweep.designs import Design, Row, design_rows
from lamella.sweep.file import read_declaration
from lamella.sweep.outputs import StudyOutput, recorded
from lamella.sweep.parameter import Parameter, check_names, check_paths, columns_of, label_twice

TRIED = 10
"""Runs whose model is read before anything is run, until one can be."""


@declaration
class ParameterStudy:
    """One model, run at many values of its parameters.

    Args:
        model: a model file, or the name of an example.
        parameters: what is varied, by name.
        design: at which values.
        outputs: the numbers kept of each run, by name.
        title: a line for the head of the report.
        description: what the study is about.
        set: ``key=value`` texts that replace values of the model in every run.
        workers: number of processes on this machine; as many as cores when left out.
        cluster: address of the scheduler of a Dask cluster, which runs them instead.
        study: version of the study file's form.
    """

    model: str
    parameters: dict[str, Parameter]
    design: Design
    outputs: dict[str, StudyOutput]
    title: str = ""
    description: str = ""
    set: tuple[str, ...] = ()
    workers: Annotated[int, Field(ge=1)] | None = None
    cluster: str | None = None
    study: Literal[1] = 1

    def __post_init__(self) -> None:
        """Refuse an empty design, a path that two parameters replace, and a study without outputs."""
        if not self.outputs:
            raise ValueError("outputs is empty; accepted is at least one number to keep of each run")
        if self.workers is not None and self.cluster is not None:
            raise ValueError("workers and cluster are both given; a cluster has its own workers")
        check_names(self.parameters, self.outputs, ("run", "status", "message"))
        check_paths(self.parameters)
        self.rows()

    def rows(self) -> list[Row]:
        """The value of each parameter, run by run, in the order of the design."""
        return design_rows(self.design, self.parameters)

    def settings(self, row: Row) -> tuple[str, ...]:
        """The ``key=value`` texts that make a run's model."""
        return (*self.set, *(text for name, value in row.items() for text in self.parameters[name].settings(value)))


@dataclass(frozen=True)
class Checked:
    """A study whose model, parameters and outputs are known to go together.

    Args:
        study: the study.
        text: of the model file.
        path: of the model file.
        base: the model without the parameters.
        units: of the outputs, by name.
        source: text of the study file, empty when it was made in Python.
    """

    study: ParameterStudy
    text: str
    path: Path
    base: ModelFile
    units: Mapping[str, str]
    source: str = ""


@dataclass(frozen=True)
class StudyFile:
    """A study with the file it was read from, for messages.

    Args:
        study: what the file says.
        document: the file; None when the study was made in Python.
    """

    study: ParameterStudy
    document: Document | None = None

    def refused(self, place: Place, text: str) -> LamellaError:
        """An error that names file, line and key, or the item."""
        if self.document is None:
            return DeclarationError(f"study: {' '.join(map(str, place))}".strip(), text)
        return ModelFileError(f"{self.document.name}, {self.document.where(place)}: {text}")

    def checked(self) -> Checked:
        """Read the model and compare parameters and outputs with it.

        Raises:
            ModelFileError: the model cannot be read, no run of the design can, or an output is not in it.
            DeclarationError: the same of a study made in Python.
        """
        study = self.study
        found = find_model(study.model)
        path = found.model if isinstance(found, Example) else found
        document = Document.read(path)
        base = self._read(document, study.set)
        first = self._first_readable(document)
        model = first.system.compile()
        analyses = {analysis.name: analysis for analysis in first.analyses}
        if not analyses:
            raise self.refused(("model",), f"{path} asks for no analysis, so that there is nothing to run")
        signals, units = recorded(first.analyses, Equations(model)), {}
        for name, output in study.outputs.items():
            try:
                chosen = output.chosen(analyses)
                units[name] = output.check(chosen, signals[chosen.name], model)
            except DeclarationError as error:
                key = error.problem.partition(":")[0]
                place: tuple[str, ...] = ("outputs", name, *([key] if hasattr(output, key) else []))
                raise self.refused(place, error.problem.removeprefix(f"{key}: ") + _accepted(error)) from error
        of_parameters = {name: unit for name, (unit, _) in columns_of(study.rows(), list(study.parameters)).items()}
        if twice := label_twice(of_parameters, units):
            name, head = twice
            place = ("outputs" if name in units else "parameters", name)
            raise self.refused(place, f"the table has a column '{head}' already; accepted is another name")
        return Checked(study, document.text, path, base, units, self.document.text if self.document else "")

    def _read(self, document: Document, settings: tuple[str, ...]) -> ModelFile:
        return loads(document.text, settings, document.name, document.folder)

    def _first_readable(self, document: Document) -> ModelFile:
        """The model of the first run that has one: a run may ask for what cannot be, but not all of them.

        Raises:
            ModelFileError: none of the first runs can be read; the message is that of the first.
        """
        first: LamellaError | None = None
        for row in self.study.rows()[:TRIED]:
            try:
                return self._read(document, self.study.settings(row))
            except ModelFileError as error:
                first = first or error
        parameters = self.study.parameters.items()
        spoken = [name for name, each in parameters if any(f"--set {path}=" in str(first) for path in each.factors)]
        place = ("parameters", spoken[0], "path") if spoken else ("parameters",)
        raise self.refused(place, f"no run of the study has a model that can be read; that of the first: {first}")


def read_study(path: str | Path) -> StudyFile:
    """Read a study file.

    Raises:
        ModelFileError: it cannot be read, or does not describe a study; all its problems are listed with their lines.
    """
    return StudyFile(*read_declaration(path, ParameterStudy, "study"))


def _accepted(error: DeclarationError) -> str:
    return f"; {error.accepted}" if error.accepted else ""
