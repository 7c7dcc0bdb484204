"""Commands that list or write files of the package: templates, examples, schema."""

from __future__ import annotations

import json
from pathlib import Path

from lamella.errors import DeclarationError, ResultFileError
from lamella.examples import example, examples
from lamella.templates import template, templates
from lamella.whole import write_text

SCHEMA_LINE = "# yaml-language-server: $schema="
SCHEMA_NAME = "lamella.schema.json"
KINDS = ("model", "study", "optimize")
"""Files that have a schema, by the commands' names."""


def list_templates() -> None:
    """Print the templates."""
    _print_table("Templates: lamella new NAME --template TEMPLATE", templates())


def list_examples() -> None:
    """Print the examples."""
    found = {name: item.title + (" (study)" if item.is_study else "") for name, item in examples().items()}
    _print_table("Examples: lamella run NAME, or lamella examples copy NAME", found)


def write_template(name: str, template_name: str) -> None:
    """Write a template as ``name.yaml`` with the schema for editors beside it.

    Raises:
        ResultFileError: the file exists or cannot be written.
    """
    path = Path(name if name.endswith((".yaml", ".yml")) else f"{name}.yaml")
    text = template(template_name)
    if path.exists():
        raise ResultFileError(f"'{path}' exists already; choose another name")
    write_text(path, f"{SCHEMA_LINE}{SCHEMA_NAME}\n{text}")
    schema = path.with_name(SCHEMA_NAME)
    if not schema.exists():
        write_text(schema, _schema_text())
    print(f"wrote {path} ('lamella run {path}' runs it) and {schema} (completion and checks in editors)")


def copy_example(name: str, folder: Path | None) -> None:
    """Copy an example's files into a new folder."""
    chosen = example(name)
    for path in chosen.copy(folder or Path(chosen.name)):
        print(f"wrote {path}")


def write_schema(out: Path | None, kind: str = "model") -> None:
    """Print the JSON Schema of a kind of file, or write it to ``out``.

    Raises:
        DeclarationError: there is no such kind.
    """
    text = _schema_text(kind)
    if out is None:
        print(text, end="")
    else:
        write_text(out, text)
        print(f"wrote {out}")


def _schema_text(kind: str = "model") -> str:
    from lamella.io.schema import declaration_schema, json_schema
    from lamella.optimisation.problem import Optimisation
    from lamella.sweep.study import ParameterStudy

    if kind == "study":
        schema = declaration_schema(ParameterStudy, "study", "lamella study file")
    elif kind == "optimize":
        schema = declaration_schema(Optimisation, "optimize", "lamella optimisation file")
    elif kind == "model":
        schema = json_schema()
    else:
        raise DeclarationError("lamella schema", f"--of {kind}", f"accepted is {', '.join(KINDS)}")
    return json.dumps(schema, indent=2, ensure_ascii=False) + "\n"


def _print_table(title: str, rows: dict[str, str]) -> None:
    width = max((len(name) for name in rows), default=0)
    print(title)
    for name, text in rows.items():
        print(f"  {name:<{width}}  {text}")
