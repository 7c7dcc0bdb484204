"""What every HTML page of lamella has in common: its look, pictures within it, and that it is written whole or not at all."""

from __future__ import annotations

import base64
import io
import tempfile
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lamella.errors import ResultFileError
from lamella.io.provenance import versions
from lamella.viz.style import styled
from lamella.whole import unwritable, write_text

if TYPE_CHECKING:
    from matplotlib import figure as matplotlib_figure

MEDIA = {
    ".png": "image/png",
    ".svg": "image/svg+xml",
    ".gif": "image/gif",
    ".jpg": "image/jpeg",
    ".jpeg": "image/jpeg",
    ".webp": "image/webp",
}


def render_page(template: str, **content: Any) -> str:
    """The text of a page.

    Args:
        template: file beside this one that extends ``page.html.j2``.
        content: its variables; versions and the present time are added.
    """
    from jinja2 import Environment, PackageLoader, StrictUndefined

    environment = Environment(
        loader=PackageLoader("lamella.viz", "."), autoescape=True, undefined=StrictUndefined, trim_blocks=True
    )
    environment.filters |= {"cell": cell, "paragraphs": paragraphs, "embedded": embedded}
    created = datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC")
    return environment.get_template(template).render(versions=versions(), created=created, **content)


def write_page(path: Path, text: str, what: str = "report") -> Path:
    """Write a page, whole or not at all.

    Raises:
        ResultFileError: it cannot be written.
    """
    write_text(path, text, what)
    return path


def refuse_unwritable(path: Path, what: str = "report") -> None:
    """Find out before a long run whether :func:`write_page` could write now; nothing is left behind.

    Raises:
        ResultFileError: it could not.
    """
    try:
        if path.is_dir():
            raise IsADirectoryError("it is a folder")
        if not path.parent.is_dir():
            raise FileNotFoundError(f"there is no folder '{path.parent}'")
        with tempfile.TemporaryFile(dir=path.parent):
            pass
    except OSError as error:
        raise unwritable(path, error, what) from error


def embedded(source: str | Path | matplotlib_figure.Figure) -> str:
    """A picture as a data URI.

    Raises:
        ResultFileError: no such file, or an unknown kind of picture.
    """
    if not isinstance(source, (str, Path)):
        content = io.BytesIO()
        with styled():
            source.savefig(content, format="svg", metadata={"Date": None})
        return _data_uri("image/svg+xml", content.getvalue())
    path = Path(source)
    if path.suffix.lower() not in MEDIA:
        raise ResultFileError(f"report: picture '{path}' is of an unknown kind; accepted are {', '.join(MEDIA)}")
    try:
        return _data_uri(MEDIA[path.suffix.lower()], path.read_bytes())
    except OSError as error:
        raise ResultFileError(f"report: picture '{path}' cannot be read: {error}") from error


def cell(value: Any) -> str:
    """A table cell as text: numbers with six significant digits, a true minus sign, yes and no."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    try:
        return f"{value:.6g}".replace("-", "−") if not isinstance(value, int) else f"{value:,}".replace(",", " ")
    except (TypeError, ValueError):  # text, None and other values are shown as they are
        return str(value)


def paragraphs(text: str) -> list[str]:
    """Parts of a text that are separated by empty lines."""
    return [" ".join(part.split()) for part in text.split("\n\n") if part.strip()]


def _data_uri(media: str, content: bytes) -> str:
    return f"data:{media};base64,{base64.b64encode(content).decode('ascii')}"
