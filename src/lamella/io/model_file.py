"""Model files: a system, what is computed with it and what is written, as YAML.

The accepted keys are the fields of the declarations, so the Python interface and the model file cannot drift apart.
See docs/model-file.md.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, get_args

from lamella.errors import ModelFileError
from lamella.io.analysis import Analysis, Output
from lamella.io.document import Document, key_path, parsed, plain_value, refuse_other_kind, shown
from lamella.io.reader import FAILED, suggestion
from lamella.io.references import Items
from lamella.io.sections import FORMAT, SECTIONS
from lamella.io.writer import dumps
from lamella.system import Redundant, System

__all__ = ["ModelFile", "dumps", "loads", "read_model"]


@dataclass(frozen=True)
class ModelFile:
    """What a model file says.

    Args:
        title: a line for the heads of reports.
        description: what the model is about.
        system: the system.
        analyses: what is computed, in order.
        output: what is written besides the result file.
        name: path or name of the file.
    """

    title: str
    description: str
    system: System
    analyses: tuple[Analysis, ...] = ()
    output: Output = field(default_factory=Output)
    name: str = ""

    def text(self) -> str:
        """The model as the text of a model file, with all overrides."""
        return dumps(self.system, self.title, self.description, self.analyses, self.output)


def read_model(path: str | Path, overrides: Sequence[str] = ()) -> ModelFile:
    """Read a model file.

    Args:
        path: the file.
        overrides: ``key=value`` texts that replace values, such as ``system.plate.mesh=[8, 8]``.

    Raises:
        ModelFileError: the file cannot be read, or does not describe a model; all its problems are listed with their lines.
    """
    return _model(Document.read(Path(path)), overrides)


def loads(text: str, overrides: Sequence[str] = (), name: str = "model", folder: Path | None = None) -> ModelFile:
    """Read a model from the text of a model file.

    Args:
        text: YAML (or JSON, which is YAML too).
        overrides: ``key=value`` texts that replace values.
        name: what messages call it.
        folder: from which paths in it count; the present one when left out.

    Raises:
        ModelFileError: as :func:`read_model`.
    """
    return _model(parsed(text, name, folder).copy(), overrides)


def _model(document: Document, overrides: Sequence[str]) -> ModelFile:
    for override in overrides:
        apply_override(document, override)
    _check_top(document)
    items = Items(document)
    for section in ("materials", "laminates"):
        items.section(section)
    declarations, analyses = items.section("system"), items.section("analysis")
    items.section("profiles")
    _check_order(document, analyses)
    output = document.data.get("output")
    read = items.reader.declared(SECTIONS["output"].classes(), output, ("output",)) if output is not None else Output()
    document.check()
    assert read is not FAILED
    system = System(document.data.get("redundant", "raise"))
    for declaration in declarations.values():
        system.add(declaration)
    title, description = (str(document.data.get(key) or "") for key in ("title", "description"))
    return ModelFile(title, description, system, tuple(analyses.values()), read, document.name)


def _check_top(document: Document) -> None:
    data: dict[str, Any] = document.data
    for key in data:
        if key not in SECTIONS:
            document.problem((key,), f"there is no section '{key}'{suggestion(key, SECTIONS)}")
    version = data.get("lamella")
    if version is None:
        refuse_other_kind(document, "lamella")
        document.problem((), f"the line 'lamella: {FORMAT}' is missing, which says that this is a model file and its version")
    elif version != FORMAT or isinstance(version, bool):
        document.problem(("lamella",), f"found version {shown(version)} of the model file; accepted is {FORMAT}")
    for key in ("title", "description"):
        if isinstance(data.get(key), (dict, list)):
            document.problem((key,), f"found {shown(data[key])}; accepted is text")
    if "redundant" in data and data["redundant"] not in get_args(Redundant):
        document.problem(
            ("redundant",), f"found {shown(data['redundant'])}{suggestion(str(data['redundant']), get_args(Redundant))}"
        )
    if not data.get("system"):
        document.problem(("system",), "no body, joint or load is given; accepted are 'name: {type: plate, ...}' entries")


def _check_order(document: Document, analyses: Mapping[str, Analysis]) -> None:
    """Refuse an analysis that goes on from none of those before it, or from one that ends in no state."""
    names = [*document.data["analysis"]] if analyses else []
    for name, analysis in analyses.items():
        for place, of in analysis.begins().items():
            shape = place[0] == "imperfection"  # one of modes or buckling as well
            fit = [key for key in names[: names.index(name)] if key not in analyses or analyses[key].axis or shape]
            if of not in fit:
                wanted = f"'{of}' is no earlier analysis{'' if shape else ' with a state'}"
                document.problem(("analysis", name, *place), wanted + suggestion(of, fit))


def apply_override(document: Document, override: str) -> None:
    """Put ``key.key=value`` into a document.

    Raises:
        ModelFileError: it has no ``=``, its value is not YAML, or it leads through something that has no such key.
    """
    path, sign, text = override.partition("=")
    if not sign or not path.strip(" .[]"):
        raise ModelFileError(f"--set {override}: accepted is key=value, for example system.plate.mesh=[8,8]")
    try:
        value = plain_value(text)
    except ModelFileError as error:
        raise ModelFileError(f"--set {override}: the value is not valid YAML ({error})") from error
    document.override(_target(document, override, path), value, override)


def _target(document: Document, override: str, path: str) -> tuple[str | int, ...]:
    """The place an override speaks of; sections and optional keys that are not in the file yet may be added."""
    place: list[str | int] = []
    here: Any = document.data
    keys = [key for key in path.strip().replace("[", ".").replace("]", "").split(".") if key]
    for depth, key in enumerate(keys):
        last = depth == len(keys) - 1
        where = key_path(tuple(place)) or document.name
        if isinstance(here, list):
            if not key.isdigit() or int(key) >= len(here):
                raise ModelFileError(f"{document.name}, --set {override}: {where} has items 0 to {len(here) - 1}, not '{key}'")
            place.append(int(key))
            here = here[int(key)]
            continue
        if not isinstance(here, dict):
            raise ModelFileError(f"{document.name}, --set {override}: {where} is {shown(here)} and has no keys of its own")
        known: list[str] = [*SECTIONS] if depth == 0 else [*here]
        is_item = depth == 1 and keys[0] in SECTIONS and SECTIONS[keys[0]].named
        if key not in here and key not in known and (depth == 0 or (is_item and not last)):
            raise ModelFileError(f"{document.name}, --set {override}: {where} has no key '{key}'{suggestion(key, known)}")
        place.append(key)
        here = here.get(key) if last else {} if here.get(key) is None else here[key]
    return tuple(place)
