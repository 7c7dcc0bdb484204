"""The command ``lamella verify``: cases with a known answer, as a table, as JSON or as a page."""

from __future__ import annotations

import html
import json
import sys
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from lamella.errors import ModelError, ResultFileError
from lamella.verification.runner import Case, Outcome, find_cases, run_cases

COLUMNS = ("case", "quantity", "computed", "reference", "error", "tolerance", "")


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
    outcomes = _run(cases, show=not as_json)
    rows = [row for outcome in outcomes for row in outcome.rows()]
    if as_json:
        print(json.dumps([_finite(row) for row in rows], indent=2, ensure_ascii=False))
    failed = [outcome.case.name for outcome in outcomes if not outcome.passed]
    if report is not None:
        _write_report(rows, report)
    if not as_json:
        checks, seconds = len(rows), sum(outcome.seconds for outcome in outcomes)
        passed = sum(bool(row["passed"]) for row in rows)
        verdict = f"failed: {', '.join(failed)}" if failed else "all passed"
        print(f"{passed} of {checks} checks in {len(outcomes)} cases passed, {seconds:.0f} s; {verdict}")
    return 1 if failed else 0


def _run(cases: list[Case], show: bool) -> list[Outcome]:
    outcomes = []
    console = Console(stderr=True)
    terminal = show and sys.stderr.isatty()
    for number, outcome in enumerate(run_cases(cases), start=1):
        outcomes.append(outcome)
        if terminal:
            console.print(f"{number}/{len(cases)} {outcome.case.name}: {outcome.seconds:.1f} s", highlight=False)
    if show:
        width = None if sys.stdout.isatty() else 160
        Console(width=width).print(_table(outcomes))
    return outcomes


def _table(outcomes: list[Outcome]) -> Table:
    table = Table(*COLUMNS, header_style="bold")
    for outcome in outcomes:
        for place, row in enumerate(outcome.rows()):
            table.add_row(outcome.case.name if place == 0 else "", *_cells(row), style="" if row["passed"] else "red")
        table.add_section()
    return table


def _cells(row: dict[str, Any]) -> tuple[str, ...]:
    """Quantity, computed value, reference, error, tolerance and verdict as text."""
    verdict = "ok" if row["passed"] else "FAILED"
    if row["value"] is None:
        return row["quantity"], "", "", "", "", verdict
    unit = f" [{row['unit']}]" if row["unit"] else ""
    sign = {"at most": "<= ", "at least": ">= "}.get(row["kind"], "")
    relative = row["kind"] == "relative"
    error, tolerance = (f"{100 * row[key]:.3g} %" if relative else f"{row[key]:.3g}" for key in ("error", "tolerance"))
    return row["quantity"] + unit, f"{row['value']:.6g}", f"{sign}{row['reference']:.6g}", error, tolerance, verdict


def _finite(row: dict[str, Any]) -> dict[str, Any]:
    """JSON has no NaN and no infinity: they become null."""
    return {key: None if isinstance(value, float) and not abs(value) < float("inf") else value for key, value in row.items()}


def _write_report(rows: list[dict[str, Any]], path: Path) -> None:
    body = "".join(
        f"<tr class={'ok' if row['passed'] else 'failed'}>"
        + "".join(f"<td>{html.escape(cell)}</td>" for cell in (row["case"], *_cells(row), row["source"]))
        + "</tr>\n"
        for row in rows
    )
    heading = "".join(f"<th>{name}</th>" for name in (*COLUMNS, "source"))
    style = "body{font:15px sans-serif;margin:2em}td,th{padding:.2em .8em;text-align:left}.failed{color:#b00020;font-weight:bold}"
    page = f"<!doctype html><meta charset=utf-8><title>Verification</title><style>{style}</style><h1>Verification</h1>"
    try:
        path.write_text(f"{page}<table><tr>{heading}</tr>\n{body}</table>\n", encoding="utf-8")
    except OSError as error:
        raise ResultFileError(f"'{path}' cannot be written: {error.strerror or error}") from error
