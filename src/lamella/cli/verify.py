"""The command ``lamella verify``: cases with a known answer, as a table, as JSON or as a manual."""

from __future__ import annotations

import json
import shlex
import sys
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rich.console import Console
from rich.table import Table

from lamella.errors import ModelError
from lamella.verification.runner import Case, Outcome, find_cases, run_cases
from lamella.verification.table import COLUMNS, cells

if TYPE_CHECKING:
    from lamella.viz.manual import Manual


def list_cases(names: list[str], as_json: bool) -> None:
    """Print the names and titles of the cases."""
    cases = find_cases(names)
    if as_json:
        print(json.dumps([{"case": case.name, "title": case.title, "slow": case.slow} for case in cases], indent=2))
        return
    width = max((len(case.name) for case in cases), default=0)
    for case in cases:
        print(f"{case.name:<{width}}  {case.title}{' (slow)' if case.slow else ''}")


def verify_command(names: list[str], *, as_json: bool, fast: bool, report: Path | None) -> int:
    """Run cases; the exit code is 1 when one fails."""
    cases = [case for case in find_cases(names) if not (fast and case.slow)]
    if not cases:
        raise ModelError("no verification case to run")
    manual = _manual(names, fast, report) if report is not None else None
    outcomes = _run(cases, show=not as_json, manual=manual)
    rows = [row for outcome in outcomes for row in outcome.rows()]
    if as_json:
        print(json.dumps([_finite(row) for row in rows], indent=2, ensure_ascii=False))
    failed = [outcome.case.name for outcome in outcomes if not outcome.passed]
    if manual is not None:
        manual.write()
    if not as_json:
        checks, seconds = len(rows), sum(outcome.seconds for outcome in outcomes)
        passed = sum(bool(row["passed"]) for row in rows)
        verdict = f"failed: {', '.join(failed)}" if failed else "all passed"
        print(f"{passed} of {checks} checks in {len(outcomes)} cases passed, {seconds:.0f} s; {verdict}")
    return 1 if failed else 0


def _manual(names: list[str], fast: bool, path: Path) -> Manual:
    """An empty manual that says by which command it was made."""
    from lamella.viz.manual import Manual

    if path.suffix not in (".html", ".htm") and not path.is_dir():
        path = path.with_name(f"{path.name}.html")
    options = [*(["--fast"] if fast else []), "--report", path.name]
    return Manual(path, shlex.join(["lamella", "verify", *names, *options]))


def _run(cases: list[Case], show: bool, manual: Manual | None) -> list[Outcome]:
    outcomes = []
    console = Console(stderr=True)
    terminal = show and sys.stderr.isatty()
    for number, outcome in enumerate(run_cases(cases), start=1):
        if manual is not None:
            manual.add(outcome)
        outcomes.append(replace(outcome, pictures=()))  # the results that pictures hold would fill the memory
        if terminal:
            console.print(f"{number}/{len(cases)} {outcome.case.name}: {outcome.seconds:.1f} s", highlight=False)
    if show:
        width = None if sys.stdout.isatty() else 160
        Console(width=width).print(_table(outcomes))
    return outcomes


def _table(outcomes: list[Outcome]) -> Table:
    table = Table("case", *COLUMNS, "", header_style="bold")
    for outcome in outcomes:
        for place, row in enumerate(outcome.rows()):
            name, verdict = outcome.case.name if place == 0 else "", "ok" if row["passed"] else "FAILED"
            table.add_row(name, *cells(row), verdict, style="" if row["passed"] else "red")
        table.add_section()
    return table


def _finite(row: dict[str, Any]) -> dict[str, Any]:
    """JSON has no NaN and no infinity: they become null."""
    return {key: None if isinstance(value, float) and not abs(value) < float("inf") else value for key, value in row.items()}
