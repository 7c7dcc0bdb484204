"""The command ``lamella bench``: times and counts of the same work in lamella and in other codes."""

from __future__ import annotations

import os
import sys
from pathlib import Path


def list_benchmarks() -> None:
    """Print the names and titles of the benchmarks."""
    from lamella.bench.cases import CASES

    width = max(map(len, CASES))
    for name, case in CASES.items():
        print(f"{name:<{width}}  {case.title}")


def bench_command(names: list[str], out: Path, runs: int) -> None:
    """Measure, write the tables and pictures, print the table."""
    from lamella.bench.clock import ONE_THREAD

    os.environ.update(ONE_THREAD)  # before anything loads the libraries that read it
    from lamella.bench import table
    from lamella.bench.cases import find_cases
    from lamella.bench.picture import with_error, work_precision
    from lamella.viz.style import save_figure

    rows, chosen = [], find_cases(names)
    for name, case in chosen.items():
        print(f"{name}: {case.title}", file=sys.stderr, flush=True)
        rows += case.run(runs)
    about = table.machine()
    written = table.write(rows, about, out)
    for name, case in chosen.items():
        if case.picture is not None and (measured := with_error(rows, name)):
            written.append(save_figure(work_precision(measured, case.picture), out / f"{name}.png"))
    print(table.markdown(rows, about))
    print("\n".join(f"wrote {path}" for path in written))
