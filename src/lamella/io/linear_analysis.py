"""Linear models for control in a model file, as a declaration."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated

from pydantic import Field

from lamella.assembly.equations import Equations
from lamella.declaration import declaration
from lamella.io.analysis import Analysis, Computed, Count, model_of, state_of
from lamella.linear.inputs import chosen
from lamella.linear.model import linearise
from lamella.linear.outputs import named
from lamella.linear.state_space import StateSpace
from lamella.model import Model
from lamella.result import Sink
from lamella.system import System

Names = Annotated[tuple[str, ...], Field(min_length=1)]


@declaration
class Linear(Analysis):
    """A linear model from inputs to outputs about a steady state.

    Args:
        name: unique name.
        inputs: loads, drives and supports that follow a function of time, such as ``motor``, ``spring.preload`` or
            ``drive.acceleration``.
        outputs: recorded signals or components, such as ``tip.position.z``.
        about: name of an earlier analysis whose last state it is about; the reference configuration when left out.
        modes: number of natural motions, from the lowest; all when left out.
        static_correction: with ``modes``, add a static shape for each input.
        order: number of states that balanced truncation leaves; all when left out.
    """

    name: str
    inputs: Names
    outputs: Names
    about: str | None = None
    modes: Count | None = None
    static_correction: bool = True
    order: Count | None = None

    def check(self, equations: Equations) -> None:
        """Refuse unknown inputs and outputs."""
        if isinstance(system := equations.model.description, System):
            chosen("linearise", system, self.inputs, 0.0)
        named(self.outputs, equations)

    def prepared(self, model: Model, earlier: Mapping[str, Computed]) -> Model:
        return model_of(self, self.about, earlier) or model

    def run(self, model: Model, earlier: Mapping[str, Computed], frames: int, sinks: Sequence[Sink]) -> StateSpace:
        linear = linearise(model, self.inputs, self.outputs, state=state_of(self, self.about, earlier))
        found = linear.state_space(self.modes, static_correction=self.static_correction)
        return found if self.order is None else found.balanced(self.order)
