"""Controllers in the loop: signals are sampled, and forces and moments held at what a law makes of them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, ClassVar

import numpy as np
from pydantic import Field

from lamella import units
from lamella.declaration import declaration
from lamella.dofs import Signal
from lamella.errors import DeclarationError, FunctionError
from lamella.load.control_law import ControlLaw
from lamella.memory import Memory
from lamella.roles import Declaration, Floats
from lamella.switch import HeldForce

if TYPE_CHECKING:
    from lamella.dofs import Build

LARGEST = units.LARGEST[""]
"""Size of what a law may give: the unit of a load is not known here."""

if TYPE_CHECKING:
    Period = float
else:
    Period = units.quantity("s", gt=0)

Names = Annotated[tuple[str, ...], Field(min_length=1)]


@declaration
class Controller(Declaration):
    """At the times t_k = t_0 + k T signals are measured, and until t_k+1 loads take the law's outputs as factors.

    A load so driven is a force, moment, pressure or heat flux of the system, of which each unit of the output gives the declared
    size once (zero-order hold); its own profile multiplies it. The integrator begins a new step at each sample, with
    accelerations that have jumped with the loads. In statics and linear models the loads are off: those are of the open loop.

    Args:
        name: unique name; the result holds ``<name>.output``, and ``<name>.state`` where the law has one. At a sample time both
            sides of the jump are recorded.
        measures: recorded signals or components, such as ``pin.angle`` or ``tip.position.z``.
        on: names of the loads, one for each output.
        law: what it does.
        period: T [s].
    """

    order: ClassVar[int] = 8  # after every load, before events
    python_only: ClassVar[bool] = True
    name: str
    measures: Names
    on: Names
    law: ControlLaw
    period: Period

    def contribute(self, build: Build) -> None:
        """Put a hold on the loads, and add the sampler and its signals."""
        held = []
        for target in self.on:
            places = [k for k, block in enumerate(build.loads) if block.name == target]
            if not places:
                names = ", ".join(dict.fromkeys(block.name for block in build.loads)) or "none"
                raise DeclarationError(f"Controller '{self.name}'", f"there is no load '{target}'", f"there are: {names}")
            for k in places:
                if isinstance(build.loads[k], HeldForce):
                    raise DeclarationError(
                        f"Controller '{self.name}'", f"another controller drives '{target}'", "accepted is one for each load"
                    )
                build.loads[k] = HeldForce(build.loads[k])
            held.append([block for k in places if isinstance(block := build.loads[k], HeldForce)])
        sampler = ControlSampler(self, held)
        build.samplers.append(sampler)
        labels = self.on if len(self.on) > 1 else ()

        def output(_: object) -> Floats | float:
            return sampler.output.copy() if labels else float(sampler.output[0])

        build.signals.append(Signal(f"{self.name}.output", "1", labels, output, f"outputs of {self.name}"))
        count = len(self.law.initial)
        if count:
            numbers = tuple(map(str, range(count)))
            build.signals.append(
                Signal(f"{self.name}.state", "1", numbers, lambda _: sampler.state.copy(), f"state of {self.name}")
            )


class ControlSampler(Memory):
    """A controller at work: its state, and the blocks it drives.

    Args:
        controller: the declaration.
        held: for each output the blocks of its load.
    """

    remembered = ("state", "output")

    def __init__(self, controller: Controller, held: list[list[HeldForce]]) -> None:
        self.name, self.measures, self.period = controller.name, controller.measures, controller.period
        self._law, self._held = controller.law, held
        self.reset()

    def reset(self) -> None:
        """Take the state of the start of a run, with all loads off."""
        self.state, self.output = self._law.initial, np.zeros(len(self._held))
        self._hold()

    def sample(self, t: float, y: Floats) -> None:
        """Let the law act on measured values.

        Raises:
            FunctionError: it raised an error, or gave something that is no outputs and state.
        """
        item = f"Controller '{self.name}' at t = {t:g} s"
        try:
            u, x = self._law.sample(t, y, self.state, self.period)
        except Exception as error:
            raise FunctionError(f"{item}: its law raised {type(error).__name__}: {error}; measured were {y}") from error
        for found, wanted, what in ((u, self.output, "outputs"), (x, self.state, "states")):
            if found.shape != wanted.shape or not (np.abs(found) <= LARGEST).all():
                count = f"accepted are {len(wanted)} finite numbers" if len(wanted) != 1 else "accepted is one finite number"
                raise FunctionError(f"{item}: its law gave the {what} {found}; {count} of up to {LARGEST:g}")
        self.output, self.state = u, x
        self._hold()

    def _hold(self) -> None:
        for level, blocks in zip(self.output, self._held, strict=True):
            for block in blocks:
                block.level = float(level)
