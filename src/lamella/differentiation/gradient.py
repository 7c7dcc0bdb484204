"""The gradient of outputs by parameters of a model."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from lamella.arguments import NUMBER, POSITIVE, TEXT, Kind, accepts, either, instance, mapping, optional, sequence
from lamella.assembly.equations import Equations
from lamella.differentiation.chain import Chain, refuse
from lamella.differentiation.family import Family, FileFamily, FunctionFamily, Values
from lamella.differentiation.neighbours import neighbours_of
from lamella.dofs import Signal
from lamella.errors import DeclarationError, no_such
from lamella.io.analysis import Analysis
from lamella.result import Sink
from lamella.roles import Floats
from lamella.sweep.outputs import MassOutput, SignalOutput, StudyOutput, recorded
from lamella.sweep.parameter import Parameter, check_paths, quantity_of
from lamella.system import System

BEGINS = ("start", "about")
"""Keys that say from which analysis one goes on; shapes of imperfections are refused."""


@dataclass(frozen=True)
class Gradient:
    """Outputs at a design, with their derivatives.

    ``found["tip"]`` is the derivative of an output by each parameter, ``found["tip", "thickness"]`` by one.

    Args:
        at: values of the parameters, by name, in their units.
        values: of the outputs, by name.
        derivatives: of each output by each parameter in the order of ``at``, shape (n_parameter,).
        units: of the outputs, by name.
        parameter_units: of the parameters, by name.
    """

    at: Values
    values: Mapping[str, float]
    derivatives: Mapping[str, Floats]
    units: Mapping[str, str]
    parameter_units: Mapping[str, str]

    def __getitem__(self, name: str | tuple[str, str]) -> Floats | float:
        output, parameter = name if isinstance(name, tuple) and len(name) == 2 else (name, None)
        if not isinstance(output, str):
            raise DeclarationError("gradient", f"found[{name!r}]", "accepted is an output, or an output and a parameter")
        for what, key, known in (("output", output, self.derivatives), ("parameter", parameter, self.at)):
            if key is not None and key not in known:
                raise DeclarationError("gradient", f"no {what} '{key}'", f"there are {', '.join(known)}")
        row = self.derivatives[output]
        return row if parameter is None else float(row[list(self.at).index(parameter)])

    @property
    def matrix(self) -> Floats:
        """All derivatives, outputs by parameters, shape (n_output, n_parameter)."""
        return np.array([self.derivatives[name] for name in self.values]).reshape(len(self.values), len(self.at))


@accepts(
    at=mapping(either(NUMBER, TEXT)),
    outputs=mapping(instance("outputs such as SignalOutput(...)", StudyOutput)),
    analyses=sequence(instance("analyses such as Motion(...)", Analysis)),
    parameters=optional(mapping(instance("Parameter(...)", Parameter))),
    settings=sequence(Kind(TEXT.accepts, "key=value texts")),
    sizes=optional(mapping(POSITIVE)),
)
def gradient(
    model: Callable[..., System] | str | Path,
    at: Mapping[str, float | str],
    outputs: Mapping[str, StudyOutput],
    *,
    analyses: Sequence[Analysis] = (),
    parameters: Mapping[str, Parameter] | None = None,
    settings: Sequence[str] = (),
    sizes: Mapping[str, float] | None = None,
) -> Gradient:
    """Derivatives of outputs of statics, motions and natural modes by parameters of the model.

    Args:
        model: a function that builds the system from the parameters, given by name; or a model file, or the name of an example.
        at: value of each parameter, by name. Of a model file they may have units, such as ``1.5 mm``, and derivatives are then
            by that unit; names are paths such as ``system.plate.laminate.thickness`` unless ``parameters`` says otherwise.
        outputs: numbers taken from what is computed, as in a parameter study, by name.
        analyses: what is computed with the system of a function; a model file has its own.
        parameters: what the parameters of a model file replace, as in a parameter study, by name.
        settings: ``key=value`` texts that replace values of the model file.
        sizes: typical size of a parameter, in its unit, by name, above zero; its value when left out, and 1 where that is 0.
            Residuals are differenced over 5e-5 of it.

    Raises:
        DeclarationError: an unknown output, one that is not differentiable, or a parameter that changes more than numbers.
        ModelFileError: the model file cannot be read, or has no such path.
        ConvergenceError: an analysis ends early.
        ModelError: the system cannot be solved, or its solution has no derivative.
    """
    values, units = {}, {}
    for name in sizes or {}:
        if name not in at:
            raise DeclarationError("gradient", f"sizes: {no_such('parameter', name, at)}")
    for name, given in at.items():
        found = quantity_of(given)
        if found is None or (callable(model) and found[1]):
            raise DeclarationError(
                "gradient", f"{name} = {given!r}", "accepted is a number" + (" with a unit" * (not callable(model)))
            )
        values[name], units[name] = found
    family: Family
    if callable(model):
        if parameters or settings:
            raise DeclarationError(
                "gradient", "parameters and settings belong to a model file", "a function takes its parameters"
            )
        family = FunctionFamily(model, analyses, units)
    else:
        if analyses:
            raise DeclarationError("gradient", "analyses are given", f"those of '{model}' are in the file")
        chosen = {name: Parameter(name) for name in values} if parameters is None else dict(parameters)
        if set(chosen) != set(values):
            accepted = f"accepted is a value for each of {', '.join(chosen)}"
            raise DeclarationError("gradient", f"at has values for {', '.join(values)}", accepted)
        try:
            check_paths(chosen)
        except ValueError as error:
            raise DeclarationError("gradient", str(error)) from error
        family = FileFamily.of(model, chosen, units, settings)
    return differentiated(family, values, outputs, sizes or {})


def differentiated(
    family: Family,
    values: Values,
    outputs: Mapping[str, StudyOutput],
    sizes: Mapping[str, float],
    sinks: Callable[[], Sequence[Sink]] = tuple,
) -> Gradient:
    """The gradient at some values of a family's parameters; arguments and errors as those of :func:`gradient`."""
    system, given = family.at(values)
    analyses = _ordered(given)
    if not values or not outputs:
        raise DeclarationError("gradient", f"no {'outputs' if values else 'parameters'} are given", "accepted is at least one")
    chosen = {name: output.chosen(analyses) for name, output in outputs.items()}
    model = system.compile()
    equations = Equations(model)
    signals, units = recorded({each.name: each for each in chosen.values()}.values(), equations), {}
    for name, output in outputs.items():
        try:
            units[name] = output.check(chosen[name], signals[chosen[name].name], model)
        except DeclarationError as error:
            raise DeclarationError(f"output '{name}'", error.problem, error.accepted) from error
    needed = _needed(analyses, chosen)
    own = {name: {key: output for key, output in outputs.items() if chosen[key].name == name} for name in needed}
    for name in needed:
        refuse(analyses[name], model, own[name])

    def made(name: str, value: float) -> System:
        there, others = family.at({**values, name: value})
        if tuple(others) != tuple(given):
            raise DeclarationError("gradient", f"{name} changes an analysis", "accepted is a parameter of the system")
        return there

    by_tables = all(_by_tables(output, signals[chosen[name].name]) for name, output in outputs.items())
    neighbours = [
        neighbours_of(name, equations, value, sizes.get(name, abs(value) or 1.0), lambda x, name=name: made(name, x), by_tables)
        for name, value in values.items()
    ]
    chain = Chain(model, equations, neighbours, sinks)
    for name in needed:
        chain.run(analyses[name], own[name])
    ordered = {name: chain.values[name] for name in outputs}
    return Gradient(dict(values), ordered, {name: chain.derivatives[name] for name in outputs}, units, dict(family.units))


def _by_tables(output: StudyOutput, signals: Mapping[str, Signal]) -> bool:
    """Whether the derivatives of the elements' tables tell that of an output."""
    return isinstance(output, MassOutput) or (isinstance(output, SignalOutput) and signals[output.signal].by_tables)


def _ordered(given: Sequence[Analysis]) -> dict[str, Analysis]:
    """Analyses by name.

    Raises:
        DeclarationError: two have one name, or one goes on from none before it that ends in a state.
    """
    analyses: dict[str, Analysis] = {}
    for analysis in given:
        item = f"gradient: analysis '{analysis.name}'"
        if analysis.name in analyses and analyses[analysis.name] != analysis:
            raise DeclarationError(item, "two have this name", "accepted are different names")
        for place, of in analysis.begins().items():
            if place[0] in BEGINS and of not in (fit := [name for name, each in analyses.items() if each.axis]):
                problem = f"{place[0]}: '{of}' is no analysis before it with a state"
                raise DeclarationError(item, problem, f"accepted are {', '.join(fit) or 'none'}")
        analyses[analysis.name] = analysis
    return analyses


def _needed(analyses: Mapping[str, Analysis], chosen: Mapping[str, Analysis]) -> list[str]:
    """Names of the analyses that outputs are taken from, and of those they start from, in order."""
    wanted = {analysis.name for analysis in chosen.values()}
    for name in reversed([*analyses]):
        if name in wanted:
            wanted |= {of for place, of in analyses[name].begins().items() if place[0] in BEGINS}
    return [name for name in analyses if name in wanted]
