"""Checks as cells of a table, for the screen and for the manual."""

from __future__ import annotations

from typing import Any

COLUMNS = ("quantity", "computed", "reference", "error", "tolerance")


def cells(row: dict[str, Any]) -> tuple[str, str, str, str, str]:
    """The texts of ``COLUMNS`` for a row of :meth:`lamella.verification.Outcome.rows`."""
    if row["value"] is None:
        return row["quantity"], "", "", "", ""
    unit = f" [{row['unit']}]" if row["unit"] else ""
    sign = {"at most": "<= ", "at least": ">= "}.get(row["kind"], "")
    relative = row["kind"] == "relative"
    error, tolerance = (f"{100 * row[key]:.3g} %" if relative else f"{row[key]:.3g}" for key in ("error", "tolerance"))
    return row["quantity"] + unit, f"{row['value']:.6g}", f"{sign}{row['reference']:.6g}", error, tolerance
