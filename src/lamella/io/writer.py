"""A system as the text of a model file."""

from __future__ import annotations

import io
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from pydantic.dataclasses import is_pydantic_dataclass
from ruamel.yaml import YAML

from lamella.body.base import Marker
from lamella.body.ground import Ground
from lamella.body.plate import Edge
from lamella.errors import DeclarationError
from lamella.io.annotation import field_specs, options, tag_of
from lamella.io.references import NAME, place_of
from lamella.io.sections import FORMAT
from lamella.roles import Declaration

if TYPE_CHECKING:
    from lamella.io.analysis import Analysis, Output
    from lamella.system import System


def dumps(
    system: System,
    title: str = "",
    description: str = "",
    analyses: Sequence[Analysis] = (),
    output: Output | None = None,
) -> str:
    """Write a system as the text of a model file; reading it gives an equal system.

    Args:
        system: the system.
        title: a line for the heads of reports.
        description: what the model is about.
        analyses: what is computed with it.
        output: what is written besides the result file.

    Raises:
        DeclarationError: a declaration holds something a model file cannot express, such as a Python function, or has a name of
            other signs than letters, digits, _ and -.
    """
    content: dict[str, Any] = {"lamella": FORMAT}
    content |= {key: text for key, text in (("title", title), ("description", description)) if text}
    if system.redundant != "raise":
        content["redundant"] = system.redundant
    content["system"] = {_checked(item): _mapping(item, named=True) for item in _items(system)}
    if analyses:
        content["analysis"] = {item.name: _mapping(item, named=True) for item in analyses}
    if output is not None and (written := _mapping(output, tagged=False)):
        content["output"] = written
    stream = io.StringIO()
    yaml = YAML(typ="safe", pure=True)
    yaml.default_flow_style = None
    yaml.sort_base_mapping_type_on_output = False  # type: ignore[assignment]  # keep the order of the declaration
    yaml.width = 120
    yaml.dump(content, stream)
    return stream.getvalue()


def _checked(item: Declaration) -> str:
    """The name of an item, which a model file refers to it by."""
    if not NAME.fullmatch(item.name):
        raise DeclarationError(
            f"{type(item).__name__} '{item.name}'",
            "a model file cannot hold this name",
            "accepted are letters, digits, _ and -, beginning with a letter",
        )
    return item.name


def _items(system: System) -> list[Declaration]:
    """The declarations, with every ground whose markers are used: a ground need not have been added."""
    items = {item.name: item for item in system.declarations}
    for item in system.declarations:
        given = (getattr(item, name) for name in field_specs(type(item)))
        places = [place for value in given for place in (value if isinstance(value, tuple) else (value,))]
        for ground in [place.body for place in places if isinstance(place, Marker) and isinstance(place.body, Ground)]:
            known = items.setdefault(ground.name, ground)
            if isinstance(known, Ground):
                items[ground.name] = _merged(known, ground)
    return list(items.values())


def _merged(a: Ground, b: Ground) -> Ground:
    for name in a.markers.keys() & b.markers.keys():
        if a.markers[name] != b.markers[name]:
            places = f"{a.markers[name]} and {b.markers[name]}"
            raise DeclarationError(
                f"Ground '{a.name}'", f"marker '{name}' is at {places}", "accepted is a name of its own for each point"
            )
    return Ground(a.name, {**a.markers, **b.markers})


def _plain(value: Any, annotation: Any) -> Any:
    """A value as plain data; ``annotation`` says what else could stand there."""
    if isinstance(value, Marker):
        return _marker(value)
    if isinstance(value, Edge):
        return str(value)
    if isinstance(value, Declaration):
        return value.name
    if is_pydantic_dataclass(type(value)):
        return _mapping(value, tagged=options(annotation).classes != (type(value),))
    if isinstance(value, dict):
        return {str(key): _plain(item, options(annotation).values) for key, item in value.items()}
    if isinstance(value, (tuple, list)):
        inner = options(annotation).items or (None,)
        return [_plain(item, inner[i % len(inner)]) for i, item in enumerate(value)]
    if value is None or isinstance(value, (bool, int, float, str)):
        return value
    if callable(value):
        said = "is a Python function, which a model file cannot hold"
        raise DeclarationError("model file", f"{getattr(value, '__name__', value)!s} {said}", "accepted is a system in Python")
    raise DeclarationError("model file", f"{value!r} cannot be written", "accepted are declarations, numbers, texts, lists")


def _mapping(declared: Any, named: bool = False, tagged: bool = True) -> dict[str, Any]:
    """The fields of a declaration that differ from their defaults; ``named`` items stand under their name, not repeated."""
    key, tag = tag_of(type(declared))
    written: dict[str, Any] = {key: tag} if tagged else {}
    for spec in field_specs(type(declared)).values():
        value = getattr(declared, spec.name)
        if spec.name == key or (named and spec.name == "name") or (not spec.required and value == spec.default):
            continue
        try:
            written[spec.name] = _plain(value, spec.annotation)
        except DeclarationError as error:
            name = f" '{declared.name}'" if isinstance(declared, Declaration) else ""
            raise DeclarationError(f"{type(declared).__name__}{name}", f"{spec.name}: {error.problem}", error.accepted) from error
    return written


def _marker(marker: Marker) -> str:
    found = place_of(marker.body, marker.name)
    if not isinstance(found, Marker) or found.at != marker.at:
        raise DeclarationError(
            "model file", f"the marker {marker} is not one of its body", "accepted are markers made by body.marker(...)"
        )
    return str(marker)
