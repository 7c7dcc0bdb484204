"""JSON Schema of the model file, made from the declarations, for completion and checking in editors."""

from __future__ import annotations

import inspect
import math
import re
from typing import Any

from pydantic import TypeAdapter

from lamella.io.annotation import Options, field_specs, options, tag_of
from lamella.io.reader import kinds
from lamella.io.sections import DEFINITIONS, SECTIONS, Section
from lamella.io.table_file import FILE, SCHEMA
from lamella.math.profile import Constant
from lamella.math.table import Table

DRAFT = "https://json-schema.org/draft/2020-12/schema"
NAME = r"^[^\W\d][\w-]*$"
QUANTITY = r"^\s*[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?(\s*[^\s\d].*|\s+1\s*/.*)?$"


def json_schema() -> dict[str, Any]:
    """The schema of a whole model file (JSON Schema, draft 2020-12)."""
    definitions: dict[str, Any] = {}
    properties = {name: _section(section, definitions) for name, section in SECTIONS.items()}
    return {
        "$schema": DRAFT,
        "title": "lamella model file",
        "description": "A flexible multibody system, what is computed with it, and what is written.",
        "type": "object",
        "properties": properties,
        "required": [name for name, section in SECTIONS.items() if section.required],
        "additionalProperties": False,
        "$defs": definitions,
    }


def declaration_schema(kind: type, key: str, title: str) -> dict[str, Any]:
    """The schema of a file that holds one declaration, whose first line is ``key: 1``: a study or an optimisation."""
    definitions: dict[str, Any] = {}
    found = _definition(kind, definitions, False)
    found["properties"].pop(tag_of(kind)[0])  # such a file is told by its first line
    found["required"] = [key, *(name for name in found["required"] if name in found["properties"])]
    return {"$schema": DRAFT, "title": title, **found, "$defs": definitions}


def arguments(cls: type) -> dict[str, str]:
    """The sentences of the docstring's ``Args:`` of a class and of the classes it derives from, by argument."""
    found: dict[str, str] = {}
    for base in reversed(cls.__mro__):
        found |= _arguments(inspect.cleandoc(base.__doc__ or ""))
    return found


def _arguments(text: str) -> dict[str, str]:
    block = re.search(r"^Args:\n((?:[ \t]+.*\n?|\n)*)", text, re.MULTILINE)
    found: dict[str, str] = {}
    name = ""
    for line in inspect.cleandoc(block.group(1)).splitlines() if block else []:
        start = re.match(r"(\w+): (.*)", line)
        if start:
            name = start.group(1)
            found[name] = start.group(2)
        elif name and line.strip():
            found[name] += " " + line.strip()
    return found


def _section(section: Section, definitions: dict[str, Any]) -> dict[str, Any]:
    if section.plain is not None:
        return {**section.plain, "description": section.meaning}
    item = _one_of([_reference(cls, definitions, section.named) for cls in section.classes()])
    if not section.named:
        return {**item, "description": section.meaning}
    return {
        "description": section.meaning,
        "type": "object",
        "propertyNames": {"pattern": NAME},
        "additionalProperties": item,
    }


def _reference(cls: type, definitions: dict[str, Any], named: bool) -> dict[str, Any]:
    """A reference to the definition of a class, which is made at the first need; ``named`` items take their name from the key."""
    if cls.__name__ not in definitions:
        definitions[cls.__name__] = {}  # closes the circle of classes that hold each other
        definitions[cls.__name__] = _definition(cls, definitions, named)
    return {"$ref": f"#/$defs/{cls.__name__}"}


def _definition(cls: type, definitions: dict[str, Any], named: bool) -> dict[str, Any]:
    key, tag = tag_of(cls)
    words = arguments(cls)
    properties: dict[str, Any] = {key: {"const": tag}}
    required = [key] if named and "name" in field_specs(cls) else []
    for spec in field_specs(cls).values():
        if spec.name == key or (named and spec.name == "name"):
            continue
        properties[spec.name] = _annotated(spec.annotation, definitions)
        if spec.name in words:
            properties[spec.name]["description"] = words[spec.name]
        if not spec.required and isinstance(spec.default, (bool, int, float, str)) and spec.default not in (math.inf, -math.inf):
            properties[spec.name]["default"] = spec.default
        if spec.required:
            required.append(spec.name)
    alternatives: dict[str, Any] = {}
    if cls is Table:
        properties[FILE] = SCHEMA
        alternatives, required = {"oneOf": [{"required": required}, {"required": [FILE]}]}, []
    summary = (inspect.getdoc(cls) or tag).split("\n\n")[0].replace("\n", " ")
    return {
        "description": summary,
        "type": "object",
        "properties": properties,
        "required": required,
        "additionalProperties": False,
        **alternatives,
    }


def _annotated(annotation: Any, definitions: dict[str, Any]) -> dict[str, Any]:
    allowed = options(annotation)
    if not allowed.structured:
        return _with_units(TypeAdapter(annotation).json_schema(), definitions)
    choices = [_reference(cls, definitions, False) for cls in allowed.classes]
    choices += _texts(allowed)
    if allowed.items:
        parts = [_annotated(item, definitions) for item in allowed.items]
        fixed = {"prefixItems": parts, "minItems": len(parts), "maxItems": len(parts)}
        choices.append({"type": "array", **({"items": parts[0]} if allowed.repeated else fixed)})
    if allowed.values is not None:
        choices.append({"type": "object", "additionalProperties": _annotated(allowed.values, definitions)})
    if Constant in allowed.classes:
        choices.append({"type": "number"})
    choices += [_with_units(TypeAdapter(part).json_schema(), definitions) for part in allowed.plain]
    return _one_of(choices)


def _texts(allowed: Options) -> list[dict[str, Any]]:
    texts: list[dict[str, Any]] = []
    if allowed.places:
        texts.append(
            {"type": "string", "pattern": r"^[^\W\d][\w-]*\.[\w+-]+$", "examples": ["plate.tip", "plate.x-", "plate.x-y-"]}
        )
    if allowed.references:
        texts.append(
            {"type": "string", "pattern": NAME, "description": f"name of an item: {', '.join(kinds(allowed.references))}"}
        )
    if any(cls in SECTIONS[section].classes() for section in DEFINITIONS for cls in allowed.classes):
        texts.append({"type": "string", "description": "name of a definition"})
    return texts


def _one_of(choices: list[dict[str, Any]]) -> dict[str, Any]:
    return choices[0] if len(choices) == 1 else {"anyOf": choices}


def _with_units(schema: Any, definitions: dict[str, Any]) -> Any:
    """A plain value's schema in which every quantity may also be text with a unit."""
    if isinstance(schema, list):
        return [_with_units(part, definitions) for part in schema]
    if not isinstance(schema, dict):
        return schema
    definitions |= {name: _with_units(part, definitions) for name, part in schema.pop("$defs", {}).items()}
    if schema.get("type") == "number" and "unit" in schema:
        unit = schema.pop("unit")
        text = {"type": "string", "pattern": QUANTITY, "examples": [f"1.5 {unit}".strip()]}
        return {"anyOf": [schema, text], "unit": unit or "1"}
    return {key: _with_units(part, definitions) for key, part in schema.items()}
