"""The analyses of a model run one after another, each with its derivatives."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial

import numpy as np

from lamella.assembly.equations import Equations
from lamella.assembly.point import Point
from lamella.contact.block import ContactBlock
from lamella.differentiation.exact_matrix import ExactMatrix, exact
from lamella.differentiation.modal import enough_modes, frequency_derivatives
from lamella.differentiation.motion import DifferentiatedAlpha, differentiated_run
from lamella.differentiation.neighbours import Neighbours
from lamella.differentiation.parts import Side
from lamella.differentiation.signals import SignalDerivatives
from lamella.differentiation.solution import PointDerivative, static_derivatives
from lamella.differentiation.statistics import statistic_derivative
from lamella.ended_early import error_of
from lamella.errors import ConvergenceError, DeclarationError
from lamella.integrate.generalized_alpha import GeneralizedAlpha
from lamella.io.analysis import Analysis, Computed, Motion, state_of
from lamella.io.static_analysis import NaturalModes, Statics
from lamella.linear.outputs import OF_HISTORY
from lamella.model import Model
from lamella.result import Result, Sink
from lamella.roles import Floats
from lamella.state import State
from lamella.sweep.outputs import MassOutput, ShapeOutput, SignalOutput, StudyOutput

FEW = 6
"""Parameters of a motion up to which the products that each takes cost less than a factorisation L U in each step."""


@dataclass
class Chain:
    """What has been computed so far with a model, and the derivatives.

    Args:
        model: the compiled model.
        equations: of the model.
        neighbours: of each parameter.
        sinks: makes those that receive the solutions while they run.
        computed: what each analysis gave, by name.
        ends: derivatives of the last state of each analysis by each parameter.
        beside: what the models beside each parameter remember then.
        values, derivatives: of each output, by name.
    """

    model: Model
    equations: Equations
    neighbours: Sequence[Neighbours]
    sinks: Callable[[], Sequence[Sink]] = tuple
    computed: dict[str, Computed] = field(default_factory=dict)
    ends: dict[str, list[PointDerivative]] = field(default_factory=dict)
    beside: dict[str, list[list[State]]] = field(default_factory=dict)
    values: dict[str, float] = field(default_factory=dict)
    derivatives: dict[str, Floats] = field(default_factory=dict)

    def run(self, analysis: Analysis, outputs: Mapping[str, StudyOutput]) -> None:
        """Run an analysis and differentiate the outputs that are taken from it.

        Raises:
            ConvergenceError: it ended early.
            DeclarationError, ModelError: an output or the solution has no derivative.
        """
        weighed = {name: output for name, output in outputs.items() if isinstance(output, MassOutput)}
        for name, output in weighed.items():
            self.values[name] = output.of_model(self.model)

            def mass(side: Side, output: MassOutput = output) -> Floats:
                return np.array([output.of_model(side.equations.model)])

            self.derivatives[name] = np.concatenate([each.difference(mass) for each in self.neighbours])
        outputs = {name: output for name, output in outputs.items() if name not in weighed}
        if isinstance(analysis, Statics):
            self._statics(analysis, outputs)
        elif isinstance(analysis, Motion):
            self._motion(analysis, outputs)
        else:
            assert isinstance(analysis, NaturalModes), "refused before"
            self._modes(analysis, outputs)

    def _statics(self, analysis: Statics, outputs: Mapping[str, StudyOutput]) -> None:
        result = self._completed(analysis, analysis.run(self.equations, self.computed, 1, self.sinks()))
        point = self.equations.point_of(result.final, result.final.t)
        point.at_rest, point.factor = True, result.final.factor
        found = static_derivatives(ExactMatrix(self.equations), point, self.neighbours)
        self.ends[analysis.name] = found
        for each, derivative in zip(self.neighbours, found, strict=True):
            each.begin([result.final] * len(each.sides))
            each.settle(partial(derivative.moved, point))
        self.beside[analysis.name] = [each.remembering(result.final) for each in self.neighbours]
        self._sample_end(outputs, point, found)

    def _motion(self, analysis: Motion, outputs: Mapping[str, StudyOutput]) -> None:
        ends = {name: output for name, output in outputs.items() if isinstance(output, SignalOutput) and output.of_end}
        others = {name: output for name, output in outputs.items() if name not in ends}
        signals = SignalDerivatives(self.equations, self.neighbours, _names(others), many=True)
        start = None if analysis.start is None else self.ends[analysis.start]
        beside = None if analysis.start is None else self.beside[analysis.start]
        assert isinstance(analysis.integrator, GeneralizedAlpha), "refused before"
        last: list[tuple[Point, list[PointDerivative]]] = []
        sinks = self.sinks()

        def sample(point: Point, derivatives: Sequence[PointDerivative]) -> None:
            signals.sample(point, derivatives)
            last[:] = [(point, list(derivatives))]
            for sink in sinks:
                sink.sample(point.t, ())

        method = DifferentiatedAlpha(analysis.integrator, self.neighbours, start, sample, beside)
        equations = self.equations if len(self.neighbours) <= FEW else exact(self.equations)
        initial = state_of(analysis, analysis.start, self.computed)
        result = differentiated_run(equations, method, analysis.t_start, analysis.t_end, initial)
        for sink in sinks:
            sink.close(result.outcome, result.statistics)
        self._completed(analysis, result)
        signals.finish()
        point, self.ends[analysis.name] = last[0]
        self.beside[analysis.name] = [each.remembering(result.final) for each in self.neighbours]
        if others:
            steps = len(signals.at)
            self._keep(signals, others, np.unique(np.append(np.arange(0, steps, analysis.stride), steps - 1)))
        self._sample_end(ends, point, self.ends[analysis.name])

    def _sample_end(self, outputs: Mapping[str, StudyOutput], point: Point, derivatives: Sequence[PointDerivative]) -> None:
        """Take outputs from the last state."""
        if not outputs:
            return
        signals = SignalDerivatives(self.equations, self.neighbours, _names(outputs))
        signals.sample(point, derivatives)
        self._keep(signals, outputs, np.array([0]))

    def _modes(self, analysis: NaturalModes, outputs: Mapping[str, StudyOutput]) -> None:
        about = analysis.about
        earlier = None if about is None else self.computed[about]
        state = earlier.final if isinstance(earlier, Result) else None
        found = enough_modes(self.model, self.equations, analysis.count, state)
        self.computed[analysis.name] = found
        shapes = {name: output for name, output in outputs.items() if isinstance(output, ShapeOutput)}
        numbers = [output.number for output in shapes.values()]
        derivatives = frequency_derivatives(
            self.equations, self.neighbours, found, numbers, state, None if about is None else self.ends[about]
        )
        for (name, output), row in zip(shapes.items(), derivatives, strict=True):
            self.values[name], self.derivatives[name] = output.value(found), row

    def _completed(self, analysis: Analysis, computed: Computed) -> Result:
        assert isinstance(computed, Result)
        if not computed.outcome.completed:
            if computed.outcome.error is not None:
                raise error_of(computed, "")
            raise ConvergenceError(f"analysis '{analysis.name}' {computed.outcome}", computed.outcome, computed)
        self.computed[analysis.name] = computed
        return computed

    def _keep(self, signals: SignalDerivatives, outputs: Mapping[str, StudyOutput], recorded: np.ndarray) -> None:
        """Take the outputs from the samples that a result records."""
        at = np.array(signals.at)[recorded]
        for name, output in outputs.items():
            assert isinstance(output, SignalOutput)
            values, derivatives = (np.array(part[output.signal])[recorded] for part in (signals.values, signals.derivatives))
            labels = signals.labels(output.signal)
            self.values[name] = output.number(at, values, labels)
            self.derivatives[name] = statistic_derivative(output, labels, at, values, derivatives)


def refuse(analysis: Analysis, model: Model, outputs: Mapping[str, StudyOutput]) -> None:
    """Refuse an analysis that is not differentiated, and outputs of it that have no derivative.

    Raises:
        DeclarationError: what is not available, and what is.
    """
    item = f"gradient: analysis '{analysis.name}'"
    if isinstance(analysis, Motion):
        if not isinstance(analysis.integrator, GeneralizedAlpha):
            raise DeclarationError(item, "its integrator is not differentiated", "accepted is generalized_alpha")
        if model.triggers or model.samplers:
            names = ", ".join(each.name for each in (*model.triggers, *model.samplers))
            raise DeclarationError(item, f"{names}: the time of an event, and what a controller samples, are not differentiated")
        if analysis.every is not None:
            raise DeclarationError(item, f"every = {analysis.every:g}", "accepted is a motion that records its steps")
    elif isinstance(analysis, Statics):
        if analysis.imperfection is not None:
            raise DeclarationError(item, "an imperfection by a computed shape is not differentiated")
        for block in (*model.forces, *model.loads):
            if isinstance(block, ContactBlock) and block.law.bristle:
                raise DeclarationError(
                    item, f"'{block.name}' has friction that remembers its way, which statics goes in load steps"
                )
    elif not isinstance(analysis, NaturalModes):
        kind = type(analysis).__name__
        raise DeclarationError(item, f"{kind} is not differentiated", "accepted are statics, motion and natural_modes")
    for name, output in outputs.items():
        if not isinstance(output, SignalOutput):
            continue
        if output.signal.startswith(OF_HISTORY):
            accepted = "accepted are signals that a state alone has"
            raise DeclarationError(f"output '{name}'", f"'{output.signal}' sums over the steps of a run", accepted)
        if isinstance(analysis, Statics) and not output.of_end:
            accepted = "accepted is 'last' without 'start' and 'end'"
            raise DeclarationError(f"output '{name}'", f"{output.statistic} over load steps has no derivative", accepted)


def _names(outputs: Mapping[str, StudyOutput]) -> list[str]:
    return list(dict.fromkeys(output.signal for output in outputs.values() if isinstance(output, SignalOutput)))
