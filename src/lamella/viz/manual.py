"""The verification manual: one page with every case, what it compares, how well it agrees, and its pictures."""

from __future__ import annotations

import os
import platform
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import groupby
from pathlib import Path
from typing import Any

from lamella.errors import LamellaError
from lamella.verification.runner import Outcome
from lamella.verification.table import cells
from lamella.viz.case_pictures import drawn
from lamella.viz.page import refuse_unwritable, render_page, write_page

WHAT = "manual"


@dataclass(frozen=True)
class Drawn:
    """A picture as a data URI, or why it could not be drawn."""

    title: str
    source: str
    problem: str = ""


@dataclass(frozen=True)
class Chapter:
    """What the manual says of one case; its outcome holds no data of pictures any more."""

    outcome: Outcome
    pictures: tuple[Drawn, ...]

    @property
    def text(self) -> str:
        """The case's README without its heading, as HTML."""
        return markdown(self.outcome.case.text)

    @property
    def passed(self) -> int:
        return sum(bool(row["passed"]) for row in self.outcome.rows())

    @property
    def worst(self) -> float | None:
        """Largest error in units of its tolerance; None when no number can be given."""
        shares = [share for check in self.outcome.checks if (share := _share(check.error, check.tolerance)) is not None]
        return max(shares, default=None)

    @property
    def lines(self) -> list[dict[str, Any]]:
        """The checks as lines of a table; reason and source stand at the first of several equal ones, with their number."""
        rows = self.outcome.rows()
        lines: list[dict[str, Any]] = [{"cells": cells(row), "passed": row["passed"], "rows": 0} for row in rows]
        start = 0
        for (reason, source), same in groupby(rows, key=lambda row: (row["reason"], row["source"])):
            count = len(list(same))
            lines[start] |= {"reason": reason, "source": source, "rows": count}
            start += count
        return lines


class Manual:
    """Collects outcomes, draws their pictures at once and writes the page at the end.

    Args:
        path: HTML file to write.
        command: what was typed, shown so that the page can be made again.

    Raises:
        ResultFileError: the page could not be written there, found out before anything is run.
    """

    def __init__(self, path: str | Path, command: str = "lamella verify") -> None:
        self.path, self.command = Path(path), command
        self.chapters: list[Chapter] = []
        refuse_unwritable(self.path, WHAT)

    def add(self, outcome: Outcome) -> None:
        """Add a case; results that its pictures are of are let go."""
        self.chapters.append(Chapter(replace(outcome, pictures=()), tuple(map(_drawn, outcome.pictures))))

    def write(self) -> Path:
        """Write the page.

        Raises:
            ResultFileError: it cannot be written.
        """
        rows = [row for chapter in self.chapters for row in chapter.outcome.rows()]
        text = render_page(
            "manual.html.j2",
            title="Verification manual",
            chapters=self.chapters,
            checks=len(rows),
            passed=sum(bool(row["passed"]) for row in rows),
            seconds=sum(chapter.outcome.seconds for chapter in self.chapters),
            failed=[chapter for chapter in self.chapters if not chapter.outcome.passed],
            command=self.command,
            machine=machine(),
        )
        return write_page(self.path, text, WHAT)


def machine() -> dict[str, str]:
    """Processor, number of its threads, and operating system."""
    return {
        "processor": _processor() or platform.machine(),
        "threads": str(os.cpu_count()),
        "system": f"{platform.system()} {platform.release()}",
    }


def markdown(text: str) -> str:
    """Markdown as HTML without its first heading; the others become one level lower.

    HTML, pictures and links other than to web addresses are shown as the text they are.
    """
    from markdown_it import MarkdownIt

    parser = MarkdownIt("commonmark", {"html": False}).enable("table").disable("image")
    parser.validateLink = lambda url: url.startswith(("https://", "http://"))
    tokens = parser.parse(text)
    if tokens and tokens[0].type == "heading_open":
        tokens = tokens[3:]
    for token in tokens:
        if token.type in ("heading_open", "heading_close"):
            token.tag = f"h{min(int(token.tag[1]) + 1, 6)}"
    return parser.renderer.render(tokens, parser.options, {})


def _drawn(picture: Any) -> Drawn:
    try:
        return Drawn(picture.title, drawn(picture))
    except LamellaError as error:  # one picture must not cost the whole manual
        return Drawn(picture.title, "", str(error))


def _share(error: float, tolerance: float) -> float | None:
    """Error in units of the tolerance; of a limit that is kept and has none, nothing can be said."""
    if tolerance > 0:
        return error / tolerance
    return None if error == 0 else float("inf")


def _processor() -> str:
    """Name of the processor, where the system tells it."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return platform.processor()
    names: Sequence[str] = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor()
