"""The table of benchmarks as text, Markdown, CSV and JSON, with what it was measured on."""

from __future__ import annotations

import csv
import json
import math
import os
import platform
from collections.abc import Sequence
from dataclasses import asdict, fields
from pathlib import Path

from lamella.bench.peers import PEERS
from lamella.bench.row import Row
from lamella.errors import ResultFileError
from lamella.io.provenance import versions

COLUMNS = ("code", "what", "time", "", "ratio", "steps", "iterations", "factorisations", "result", "error", "note")
NUMERIC = {"time", "ratio", "steps", "iterations", "factorisations", "error"}


def cells(row: Row) -> tuple[str, ...]:
    """A row as texts, in the order of :data:`COLUMNS`; what does not apply is empty."""
    value = f"{row.quantity} {row.value:.5g}" if row.quantity else ""
    error = "" if math.isnan(row.error) else f"{100.0 * row.error:.2f} %"
    ratio = "" if math.isnan(row.ratio) else f"{row.ratio:.2f}" if row.ratio < 10.0 else f"{row.ratio:.0f}"
    counts = [
        "" if math.isnan(count) else f"{count:.0f}" if count >= 1e4 else f"{count:.4g}"
        for count in (row.steps, row.iterations, row.factorisations)
    ]
    time = "" if math.isnan(row.time) else f"{row.time:.3g}"
    return (row.code, row.what, time, row.unit, ratio, *counts, value, error, row.note)


def machine() -> dict[str, str]:
    """Versions of everything that ran, and the machine; the load tells how busy it was with other work."""
    found = versions() | {peer.name: peer.find() or f"not installed; {peer.install}" for peer in PEERS}
    load = f"{os.getloadavg()[0]:.1f}" if hasattr(os, "getloadavg") else "unknown"
    return found | {
        "processor": f"{_processor()}, {os.cpu_count()} cores, of which one is used",
        "system": f"{platform.system()} {platform.machine()}",
        "times": "CPU time, where the unit does not say elapsed",
        "load": f"{load} (mean of processes that want a core, over the last minute of the run)",
    }


def _processor() -> str:
    info = Path("/proc/cpuinfo")
    lines = info.read_text(encoding="utf-8").splitlines() if info.is_file() else []
    name = next((line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")), platform.processor())
    return name or platform.machine()


def markdown(rows: Sequence[Row], about: dict[str, str]) -> str:
    """The page: what it was measured on, then one table for each case."""
    lines = ["# Benchmarks", "", *(f"- {name}: {text}" for name, text in about.items()), ""]
    for case in dict.fromkeys(row.case for row in rows):
        lines += [f"## {case}", "", *_aligned([cells(row) for row in rows if row.case == case]), ""]
    return "\n".join(lines)


def _aligned(rows: Sequence[tuple[str, ...]]) -> list[str]:
    """A Markdown table that reads well as it is, without its empty columns."""
    kept = [k for k in range(len(COLUMNS)) if any(row[k] for row in rows)]
    widths = {k: max(3, *(len(row[k]) for row in (COLUMNS, *rows))) for k in kept}
    right = {k for k in kept if COLUMNS[k] in NUMERIC}
    rule = tuple("-" * (widths[k] - 1) + ":" if k in right else "-" * widths.get(k, 0) for k in range(len(COLUMNS)))
    texts = [[row[k].rjust(widths[k]) if k in right else row[k].ljust(widths[k]) for k in kept] for row in (COLUMNS, rule, *rows)]
    return [f"| {' | '.join(row)} |" for row in texts]


def write(rows: Sequence[Row], about: dict[str, str], folder: Path) -> list[Path]:
    """Write ``bench.md``, ``bench.csv`` and ``bench.json`` into a folder, which is made when it is not there.

    Raises:
        ResultFileError: the folder cannot be written.
    """
    paths = [folder / f"bench.{suffix}" for suffix in ("md", "csv", "json")]
    plain = [{key: None if value != value else value for key, value in asdict(row).items()} for row in rows]  # NaN is no JSON
    try:
        folder.mkdir(parents=True, exist_ok=True)
        paths[0].write_text(markdown(rows, about), encoding="utf-8")
        with paths[1].open("w", encoding="utf-8", newline="") as file:
            writer = csv.DictWriter(file, [field.name for field in fields(Row)])
            writer.writeheader()
            writer.writerows(plain)
        paths[2].write_text(json.dumps({"about": about, "rows": plain}, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    except OSError as error:
        raise ResultFileError(f"'{folder}' cannot be written: {error.strerror or error}; choose a folder with --out") from error
    return paths
