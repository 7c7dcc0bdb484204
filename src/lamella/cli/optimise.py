"""The command ``lamella optimize``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from rich.console import Console

from lamella.cli.run import say_nothing, say_on_error_stream, size_text
from lamella.optimisation.problem import read_optimisation
from lamella.optimisation.run import OptimisationResult, run_optimisation


def optimise_command(
    path: Path, out: Path | None, settings: Sequence[str], *, overwrite: bool, quiet: bool, pictures: bool
) -> None:
    """Run an optimisation file and say what was found and written."""
    source = read_optimisation(path)
    problem = replace(source.problem, set=(*source.problem.set, *settings))
    folder = out or Path("results") / path.stem
    result = run_optimisation(
        replace(source, problem=problem),
        folder,
        overwrite=overwrite,
        pictures=pictures,
        say=say_nothing if quiet else say_on_error_stream,
    )
    if not quiet:
        _summary(result, folder)


def _summary(result: OptimisationResult, folder: Path) -> None:
    console = Console(highlight=False, soft_wrap=True)
    first, best = result.history[0], result.best
    ended = "converged" if result.converged else "NOT converged"
    console.print(f"{ended} after {len(result.history)} designs: {result.message}", markup=False)
    for name in (*result.problem.parameters, *result.units):
        values = [(design.values | design.outputs)[name] for design in (first, best)]  # type: ignore[operator]
        console.print(f"  {result.label(name)}: {values[1]:.6g} (at the start {values[0]:.6g})", markup=False)
    console.print(f"written to {folder}:")
    for file in result.files:
        console.print(f"  {file.relative_to(folder)}  ({size_text(file.stat().st_size)})")
