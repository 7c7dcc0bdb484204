"""Templates of model files for ``lamella new``: one ``<name>.yaml`` each."""

from __future__ import annotations

from pathlib import Path

from lamella.errors import ModelError, no_such

FOLDER = Path(__file__).parent


def templates() -> dict[str, str]:
    """The templates' names and titles."""
    found = {}
    for path in sorted(FOLDER.glob("*.yaml")):
        lines = path.read_text(encoding="utf-8").splitlines()
        found[path.stem] = next((line.removeprefix("title:").strip() for line in lines if line.startswith("title:")), "")
    return found


def template(name: str) -> str:
    """The text of a template.

    Raises:
        ModelError: there is none of that name.
    """
    known = templates()
    if name not in known:
        raise ModelError(no_such("template", name, known))
    return (FOLDER / f"{name}.yaml").read_text(encoding="utf-8")
