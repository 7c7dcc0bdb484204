"""Run an optimisation into a folder: designs kept as they are tried, the best one run whole, pictures, report."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from lamella.arguments import PATH, accepts, instance
from lamella.assembly.equations import Equations
from lamella.differentiation.chain import refuse
from lamella.differentiation.family import FileFamily
from lamella.differentiation.gradient import Gradient, differentiated
from lamella.errors import ConvergenceError, DeclarationError, LamellaError, ResultFileError
from lamella.optimisation.problem import Optimisation, OptimisationFile
from lamella.optimisation.search import Design, FailedDesignError, Search, best_of
from lamella.roles import Floats
from lamella.study.folder import open_folder
from lamella.study.interruption import Interruption
from lamella.study.run import Say, run_model, silent
from lamella.sweep.outputs import recorded
from lamella.sweep.parameter import label_of, label_twice
from lamella.sweep.table import write_tables
from lamella.whole import write_text

HISTORY, BEST = "history", "best"


@dataclass(frozen=True)
class OptimisationResult:
    """What an optimisation gave.

    ``result["tip"]`` is an output or a parameter over all designs in the order tried; NaN where the model failed.

    Args:
        problem: what was asked for.
        units: of the outputs, by name.
        history: the designs tried.
        converged: whether the method has found an optimum.
        message: what the method says.
        files: what was written.
    """

    problem: Optimisation
    units: Mapping[str, str]
    history: Sequence[Design]
    converged: bool
    message: str
    files: Sequence[Path] = ()

    @property
    def best(self) -> Design:
        """The best design that meets the constraints; the one that violates them least when none does."""
        found = best_of(self.history)
        assert found is not None, "an optimisation without any design raises"
        return found

    def __getitem__(self, name: str) -> Floats:
        if name in self.problem.parameters:
            return np.array([design.values[name] for design in self.history])
        if name in self.units:
            return np.array([design.outputs.get(name, np.nan) for design in self.history])
        known = ", ".join((*self.problem.parameters, *self.units))
        raise DeclarationError("optimisation", f"no output or parameter '{name}'", f"there are {known}")

    def label(self, name: str) -> str:
        """A name with its unit in brackets, where it has one."""
        unit = self.units[name] if name in self.units else self.problem.units[name]
        return label_of(name, unit)

    def columns(self) -> dict[str, list[object]]:
        """The table of designs, column by column."""
        table: dict[str, list[object]] = {"design": [design.number for design in self.history]}
        table |= {self.label(name): [design.values[name] for design in self.history] for name in self.problem.parameters}
        table |= {self.label(name): [design.outputs.get(name) for design in self.history] for name in self.units}
        for name in ("objective", "violation"):
            values = [getattr(design, name) for design in self.history]
            table[name] = [None if np.isnan(value) else value for value in values]
        table |= {name: [getattr(design, name) for design in self.history] for name in ("status", "message", "seconds")}
        return table


@accepts(problem=instance("an Optimisation, or what read_optimisation gives", Optimisation, OptimisationFile), folder=PATH)
def run_optimisation(
    problem: Optimisation | OptimisationFile,
    folder: str | Path,
    *,
    overwrite: bool = False,
    pictures: bool = True,
    say: Say = silent,
) -> OptimisationResult:
    """Look for the best design.

    Args:
        problem: what is looked for.
        folder: where to write.
        overwrite: replace the results of an earlier run.
        pictures: draw, write the report, and run the best design with its own pictures.
        say: takes a line for each design.

    Raises:
        ModelFileError, DeclarationError: model, parameters, outputs, objective and constraints do not go together, or an output
            is not differentiable.
        ResultFileError: the folder holds other results, or cannot be written.
        ConvergenceError: the model of a design fails, or no design meets the constraints.
        KeyboardInterrupt: the user interrupted. In both cases the designs tried are kept.
    """
    source = problem if isinstance(problem, OptimisationFile) else OptimisationFile(problem)
    problem, folder = source.problem, Path(folder)
    family = FileFamily.of(problem.model, problem.parameters, problem.units, problem.set)
    units = _checked(source, family)
    target, limits = source.limits(units)
    if not overwrite and os.path.exists(folder / f"{HISTORY}.csv"):  # no error for a name that no folder can have
        raise ResultFileError(f"'{folder}' holds results already; give --overwrite to replace them, or another folder with --out")
    open_folder(folder, overwrite)
    history: list[Design] = []

    def result(converged: bool, message: str) -> OptimisationResult:
        return OptimisationResult(problem, units, history, converged, message)

    def evaluate(values: Mapping[str, float]) -> Gradient:
        return differentiated(family, values, problem.outputs, problem.sizes(values), lambda: (Interruption(),))

    def keep(design: Design) -> None:
        history.append(design)
        write_tables(result(False, "").columns(), folder, HISTORY)
        say(_line(design, problem, units))

    try:
        converged, message = Search(problem, evaluate, target, limits, keep).run()
    except KeyboardInterrupt as error:
        raise KeyboardInterrupt(f"{len(history)} designs are kept in '{folder}'{_best_so_far(history, problem)}") from error
    except FailedDesignError as error:
        place = _shown(history[-1].values, problem.units)
        text = f"the model fails at {place}: {error}; {len(history)} designs are kept in '{folder}'"
        raise ConvergenceError(f"{text}{_best_so_far(history, problem)}; narrow the ranges, or start elsewhere") from error
    found = result(converged, message)
    files = _write(found, family, folder, pictures, say, source.document.text if source.document else "")
    if not found.best.meets:
        place = f"the nearest is {_shown(found.best.values, problem.units)}, off by {found.best.violation:.2g} of a limit"
        raise ConvergenceError(f"no design that meets the constraints was found ({message}); {place}; all are in '{folder}'")
    return replace(found, files=files)


def _checked(source: OptimisationFile, family: FileFamily) -> dict[str, str]:
    """The units of the outputs; refuses, before anything is run, what the model does not have or is not differentiable."""
    problem = source.problem
    first = problem.values(problem.first())[0]
    try:
        system, given = family.at(first)
    except LamellaError as error:
        spoken = [
            name for name, each in problem.parameters.items() if any(f"--set {path}=" in str(error) for path in each.factors)
        ]
        place = ("parameters", spoken[0], "path") if spoken else ("parameters",)
        raise source.refused(place, f"the model of the first design cannot be read: {error}") from error
    analyses = {analysis.name: analysis for analysis in given}
    model = system.compile()
    signals, units = recorded(given, Equations(model)), {}
    for name, output in problem.outputs.items():
        try:
            chosen = output.chosen(analyses)
            units[name] = output.check(chosen, signals[chosen.name], model)
            refuse(chosen, model, {name: output})
        except DeclarationError as error:
            key = error.problem.partition(":")[0]
            where = ("outputs", name, *([key] if hasattr(output, key) else []))
            text = error.problem.removeprefix(f"{key}: ") if hasattr(output, key) else str(error).removeprefix("output: ")
            accepted = f"; {error.accepted}" if error.accepted and hasattr(output, key) else ""
            raise source.refused(where, text + accepted) from error
    if twice := label_twice(problem.units, units):
        name, head = twice
        place = ("outputs" if name in units else "parameters", name)
        raise source.refused(place, f"the table has a column '{head}' already; accepted is another name")
    return units


def _write(found: OptimisationResult, family: FileFamily, folder: Path, pictures: bool, say: Say, text: str) -> list[Path]:
    """Tables, the best design's model, and with pictures its run and the report."""
    files = write_tables(found.columns(), folder, HISTORY)
    best = family.model(found.best.values)
    path = folder / "best.yaml"
    write_text(path, best.text())
    files.append(path)
    if pictures:
        from lamella.optimisation.report import write_report_of

        place = folder / BEST
        say("the best design is run whole")
        finished = run_model(best, place, say=say)
        files += [file for item in finished for file in item.files]
        files += write_report_of(found, finished, folder, text, best.text())
    return files


def _line(design: Design, problem: Optimisation, units: Mapping[str, str]) -> str:
    """A design in a line."""
    place = _shown(design.values, problem.units)
    if design.status != "ok":
        return f"design {design.number}: {place}: failed"
    name = problem.objective.output
    off = f", constraints off by {design.violation:.1e}" if not design.meets else ""
    return f"design {design.number}: {place}: {_shown({name: design.outputs[name]}, units)}{off}, {design.seconds:.1f} s"


def _shown(values: Mapping[str, float], units: Mapping[str, str]) -> str:
    return ", ".join(f"{name} = {value:.6g} {units[name].removeprefix('1')}".rstrip() for name, value in values.items())


def _best_so_far(history: Sequence[Design], problem: Optimisation) -> str:
    best = best_of(history)
    return f", the best at {_shown(best.values, problem.units)}" if best is not None else ""
