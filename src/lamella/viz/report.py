"""One self-contained HTML page: findings, figures, tables, model, statistics and versions; nothing is loaded from elsewhere."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from lamella.result import STEPS_OF_ORDER
from lamella.viz.page import render_page, write_page

if TYPE_CHECKING:
    from matplotlib import figure as matplotlib_figure

    from lamella.result import Result
    from lamella.study.findings import Finding

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
    text = render_page(
        "report.html.j2",
        title=title,
        summary=summary,
        sections=sections,
        findings=findings,
        model_text=model_text,
        outcomes={label: result.outcome for label, result in (results or {}).items()},
        statistics=_statistics_table(results or {}),
    )
    return write_page(Path(path), text)


def _statistics_table(results: Mapping[str, Result]) -> Table | None:
    if not results:
        return None
    counts = [result.statistics.as_dict() for result in results.values()]
    orders = sorted({name for each in counts for name in each if name.startswith(STEPS_OF_ORDER)})
    labels = STATISTICS | {name: name.replace("_", " ").capitalize() for name in orders}
    rows = [[label, *(each.get(name, "") for each in counts)] for name, label in labels.items()]
    return Table(["", *results], rows)
