"""The inputs of a stepping run: functions of time of a system's declarations, replaced by values that are held."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lamella.assembly.equations import Equations
from lamella.errors import DeclarationError
from lamella.linear.inputs import ACCELERATION, Inputs, channels, chosen, driven_level, unit_of
from lamella.model import Model
from lamella.roles import Floats
from lamella.stepping.held import Held, HeldAcceleration
from lamella.system import System

ITEM = "Stepping"


@dataclass(frozen=True)
class Input:
    """An input at work.

    Args:
        name: name of the input.
        of: what it stands for, in words.
        unit: its unit.
        start: its value at the start.
        held: the function of time.
    """

    name: str
    of: str
    unit: str
    start: float
    held: Held


def with_inputs(model: Model, inputs: Inputs, t: float) -> tuple[Model, list[Input]]:
    """The model with some functions of time held at the values they have at the time t, and what holds them.

    Raises:
        DeclarationError: there is no such function of time; or it moves something that would have to jump.
    """
    system = model.description
    if not isinstance(system, System):
        raise DeclarationError(ITEM, "the model was not compiled from a system", "accepted is the system itself")
    held: list[Input] = []
    other = System(system.redundant)
    other.declarations = list(system.declarations)
    taken: dict[str, str] = {}
    for name, (channel, accelerates) in chosen(ITEM, system, inputs, t).items():
        if channel.name in taken:
            raise DeclarationError(
                ITEM, f"the inputs '{taken[channel.name]}' and '{name}' both stand for '{channel.name}'", "accepted is one"
            )
        taken[channel.name] = name
        level = driven_level(model, channel, t)
        function = HeldAcceleration(t, level, channel.rate) if accelerates else Held(level)
        # another function of the same declaration may be held already
        declaration = channels(other, t)[channel.name].following(function)
        other.declarations[channel.number] = declaration
        item = f"{type(declaration).__name__} '{declaration.name}'"
        of = f"acceleration of {item}" if accelerates else f"{channel.field} of {item}"
        held.append(Input(name, of, unit_of(channel, accelerates), function.now, function))
    return (other.compile(model.imperfection), held) if held else (model, [])


def refuse_jumps(equations: Equations, inputs: list[Input], t: float) -> None:
    """Refuse inputs by which a place would jump, and accelerations of what does not move.

    Raises:
        DeclarationError: there is such an input.
    """
    for item in inputs:
        moves = _asked(equations, item.held, t)
        accelerates = isinstance(item.held, HeldAcceleration)
        if moves and not accelerates:
            raise DeclarationError(
                ITEM,
                f"the input '{item.name}' is the {item.of}, a place, which cannot jump from one step to the next",
                f"accepted is its acceleration, '{item.name}{ACCELERATION}'",
            )
        if accelerates and not moves:
            raise DeclarationError(
                ITEM,
                f"the input '{item.name}' has no motion to accelerate",
                "accepted is that of a drive or a support that moves",
            )


def _asked(equations: Equations, held: Held, t: float) -> bool:
    """Whether a function of time prescribes positions."""
    q, rows = equations.model.q0, equations.elimination.rows
    mechanical = np.array([row.coords[0] < equations.model.n_motion for row in rows], bool)

    def asked() -> Floats:
        phi = equations.constraints.phi_of_all(t, q)
        return np.concatenate([equations.elimination.right_hand_side(t)[mechanical], phi])

    before, memory = asked(), held.memory()
    held.shift(1e-3)
    moved = bool(np.any(asked() != before))
    held.recall(memory)
    return moved
