"""One self-contained HTML page: findings, figures, tables, model, statistics and versions; nothing is loaded from elsewhere."""

from __future__ import annotations

import base64
import io
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lamella.errors import ResultFileError
from lamella.io.provenance import versions
from lamella.viz.style import styled

if TYPE_CHECKING:
    from matplotlib import figure as matplotlib_figure

    from lamella.result import Result
    from lamella.study.findings import Finding

MEDIA = {".png": "image/png", ".svg": "image/svg+xml", ".gif": "image/gif", ".jpg": "image/jpeg", ".jpeg": "image/jpeg"}
STATISTICS = {
    "steps": "Steps",
    "rejected": "Rejected steps",
    "newton_iterations": "Newton iterations",
    "residuals": "Residuals",
    "tangents": "Tangents",
    "factorisations": "Factorisations",
    "solves": "Solutions of linear systems",
    "seconds_compile": "Compilation [s]",
    "seconds_run": "Run [s]",
}


@dataclass(frozen=True)
class Figure:
    """A picture with its caption.

    Args:
        source: a picture file (PNG, SVG, GIF, JPEG), or a matplotlib figure.
        caption: a sentence below it, also what a screen reader says.
        wide: takes the whole width of the page.
    """

    source: str | Path | matplotlib_figure.Figure
    caption: str = ""
    wide: bool = True


@dataclass(frozen=True)
class Table:
    """A table; numbers are shown with six significant digits.

    Args:
        columns: headings.
        rows: cells, text or numbers or True and False.
        caption: a sentence above it.
    """

    columns: Sequence[str]
    rows: Sequence[Sequence[object]]
    caption: str = ""


@dataclass(frozen=True)
class Section:
    """A part of the page.

    Args:
        heading: its title.
        text: paragraphs of plain text, separated by empty lines.
        figures: pictures, in order.
        tables: tables, above the pictures.
        code: text shown as it is, for example a model file; folded when long.
    """

    heading: str
    text: str = ""
    figures: Sequence[Figure] = ()
    tables: Sequence[Table] = ()
    code: str = ""


def write_report(
    path: str | Path,
    title: str,
    sections: Sequence[Section] = (),
    findings: Sequence[Finding] = (),
    *,
    summary: str = "",
    model_text: str = "",
    results: Mapping[str, Result] | None = None,
) -> Path:
    """Write a report page.

    Args:
        path: HTML file to write.
        title: heading of the page.
        sections: text, tables and figures, in order.
        findings: statements and whether they hold, with their numbers; shown first.
        summary: paragraphs below the title, separated by empty lines.
        model_text: the model file, shown as text.
        results: label to result; their outcomes and statistics are listed.

    Raises:
        ResultFileError: a picture is missing or of an unknown kind, or the page cannot be written.
    """
    from jinja2 import Environment, PackageLoader, StrictUndefined

    path = Path(path)
    environment = Environment(
        loader=PackageLoader("lamella.viz", "."), autoescape=True, undefined=StrictUndefined, trim_blocks=True
    )
    environment.filters |= {"cell": cell, "paragraphs": paragraphs, "embedded": embedded}
    page = environment.get_template("report.html.j2").render(
        title=title,
        summary=summary,
        sections=sections,
        findings=findings,
        model_text=model_text,
        outcomes={label: result.outcome for label, result in (results or {}).items()},
        statistics=_statistics_table(results or {}),
        versions=versions(),
        created=datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC"),
    )
    try:
        path.write_text(page, encoding="utf-8")
    except OSError as error:
        raise ResultFileError(f"report '{path}' cannot be written: {error}; accepted is a file in a writable folder") from error
    return path


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


def _statistics_table(results: Mapping[str, Result]) -> Table | None:
    if not results:
        return None
    counts = [result.statistics.as_dict() for result in results.values()]
    rows = [[label, *(each.get(name, "") for each in counts)] for name, label in STATISTICS.items()]
    return Table(["", *results], rows)


def _data_uri(media: str, content: bytes) -> str:
    return f"data:{media};base64,{base64.b64encode(content).decode('ascii')}"
