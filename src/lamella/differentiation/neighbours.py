"""The models on both sides of a parameter's value, in the unknowns of the model at the value itself."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from lamella.assembly.equations import Equations
from lamella.assembly.point import Point
from lamella.differentiation.difference import PartDifference, WholeDifference, difference_of, may_follow
from lamella.differentiation.parts import Side
from lamella.errors import DeclarationError, LamellaError
from lamella.model import Model
from lamella.roles import ConstraintBlock, Floats, ForceBlock, remembers
from lamella.state import State
from lamella.system import System

STEP = 5e-5
"""Distance of the models, in sizes of what is changed. Central differences leave 4e-10 of the third derivative, those of fourth
order 2e-19 of the fifth, and both 4e-12 of the value differenced. The fifth derivative of a strain energy by a length is large: a
plate that moves along a straight line is stretched, and its membrane is stiffer than its bending by 12 (length / thickness)^2."""
SHORT = 1e-5
"""Distance of the models where nothing but tables of elements is differenced, and step of central differences along a change of
the state, which bends what moves along a straight line by 1e-10 of it. They leave 2e-11 of the third derivative and of the value,
which is enough of such tables, but not of a strain energy itself."""
Rule = tuple[tuple[float, float], ...]
CENTRAL: Rule = ((-1.0, -0.5), (1.0, 0.5))
FOURTH: Rule = ((-2.0, 1 / 12), (-1.0, -8 / 12), (1.0, 8 / 12), (2.0, -1 / 12))
"""Places in steps and weights of the differences."""
PLACE = re.compile(r" at \(?[-+.e\d, ]+\)? m")
"""Where something is, in the label of a constraint: a parameter may move it."""


@dataclass(frozen=True)
class Neighbours:
    """Models beside the value of one parameter, by which functions of the parameter are differentiated.

    All take their unknowns from the model in the middle, so that coordinates that supports eliminate there are eliminated here.

    Args:
        name: of the parameter.
        sides: the models.
        residual: the difference of their residuals.
    """

    name: str
    sides: Sequence[Side]
    residual: WholeDifference | PartDifference

    @property
    def rule(self) -> tuple[float, Rule]:
        """Step along a change of the state, in sizes, and places and weights of the difference that suits the parameter."""
        return (SHORT, CENTRAL) if len(self.sides) == len(CENTRAL) else (STEP, FOURTH)

    @property
    def parts(self) -> PartDifference | None:
        """The difference of residuals by the parts that differ; None where whole residuals are differenced."""
        return self.residual if isinstance(self.residual, PartDifference) else None

    @property
    def following(self) -> PartDifference | None:
        """The parts, where coordinates may follow the parameter in them; they then tell of reactions too."""
        return self.parts if self.parts and self.parts.follows else None

    @property
    def of_potential(self) -> PartDifference | None:
        """The parts, where they tell of the potential of all forces."""
        return self.parts if self.parts and self.parts.tells_potential else None

    def difference(self, evaluate: Callable[[Side], Floats]) -> Floats:
        """The derivative of a function, from its values at the sides."""
        first, *others = (side.weight * evaluate(side) for side in self.sides)
        return sum(others, start=first)

    @cached_property
    def _remembering(self) -> list[list[ForceBlock | ConstraintBlock]]:
        models = [side.equations.model for side in self.sides]
        return [[block for block in (*m.forces, *m.loads, *m.constraints) if remembers(block)] for m in models]

    def settle(self, moved: Callable[[float], Point]) -> None:
        """Tell blocks with a discrete state the point that was accepted, for the distance of each side."""
        if not any(self._remembering):
            return
        for side, blocks in zip(self.sides, self._remembering, strict=True):
            there = moved(side.distance)
            q = side.equations.coordinates(there)
            for block in blocks:
                block.settle(there.t, q)

    def begin(self, states: Sequence[State] | None) -> None:
        """Let the models begin anew, with what these states, one for each, remember."""
        for k, side in enumerate(self.sides):
            side.equations.model.begin(None if states is None else states[k])

    def remembering(self, state: State) -> list[State]:
        """A state with what each model remembers now."""
        return [side.equations.model.remembering(state) for side in self.sides]


def neighbours_of(
    name: str, base: Equations, value: float, size: float, made: Callable[[float], System], by_tables: bool = False
) -> Neighbours:
    """The neighbours of a model.

    Two are enough for a parameter of material, section or load. One that moves the places at which coordinates have no strain
    stretches a plate that is held in its place; the membrane is stiffer than the bending by 12 (length / thickness)^2, and to
    third order that would be seen. Such a parameter has four neighbours, with differences of fourth order. Two are enough where
    neither forces nor outputs are differenced in their places, but the tables of elements alone.

    Args:
        name: of the parameter.
        base: the equations at its value.
        value: of the parameter, in its unit.
        size: of a change of the parameter that matters, in its unit.
        made: gives the system for a value.
        by_tables: whether tables of elements tell the derivatives of all outputs (:attr:`lamella.dofs.Signal.by_tables`).

    Raises:
        DeclarationError: there is no model beside the value, or one of another kind.
    """
    near = by_tables and may_follow(base)
    step = (SHORT if near else STEP) * size
    if value + step == value:
        problem = f"{name} = {value!r} is not changed by a share of its size {size!r}"
        raise DeclarationError("gradient", problem, "accepted is a larger one in 'sizes'")
    known: dict[float, Equations] = {}

    def at(there: float) -> Equations:
        if there not in known:
            known[there] = _equations(name, base, _model(name, there, made))
        return known[there]

    def beside(step: float, rule: Rule) -> Neighbours:
        places = [(value + place * step, weight / step) for place, weight in rule]
        sides = [Side(there - value, weight, at(there)) for there, weight in places]
        return Neighbours(name, sides, difference_of(base, sides))

    moves = _moves(base, at(value + step))
    found = beside(step, FOURTH if moves and not near else CENTRAL)
    return found if not (moves and near) or found.following else beside(STEP * size, FOURTH)


def _moves(base: Equations, there: Equations) -> bool:
    """Whether a parameter changes the reference, or coordinates in which unknowns are as they were."""
    if not np.array_equal(base.model.q0, there.model.q0):
        return True
    start = base.start()
    motions = [[row.motion for row in equations.elimination.rows] for equations in (base, there)]
    return not (np.array_equal(base.coordinates(start), there.coordinates(start)) and motions[0] == motions[1])


def _model(name: str, value: float, made: Callable[[float], System]) -> Model:
    try:
        return made(value).compile()
    except LamellaError as error:
        problem = f"there is no model at {name} = {value!r}, beside the value asked for: {error}"
        raise DeclarationError("gradient", problem, "choose another value") from error


def _equations(name: str, base: Equations, model: Model) -> Equations:
    """The equations of a model in the unknowns of the one in the middle."""
    try:
        found = Equations(model, like=base) if model.n_q == base.model.n_q else None
    except LamellaError as error:
        raise DeclarationError("gradient", f"{name}: beside the value asked for {error}", "choose another value") from error
    if found is None or not _same_form(found, base):
        accepted = "accepted is one that changes sizes, materials, loads or places"
        raise DeclarationError("gradient", f"{name} changes the number of unknowns or constraints", accepted)
    if not np.array_equal(model.breakpoints, base.model.breakpoints):
        accepted = "accepted is one that moves no such time"
        raise DeclarationError("gradient", f"{name} moves a time at which a load or motion jumps", accepted)
    return found


def _same_form(found: Equations, base: Equations) -> bool:
    same = np.array_equal(found.elimination.independent, base.elimination.independent)
    labels = [[PLACE.sub("", label) for label in equations.constraints.labels] for equations in (found, base)]
    return same and labels[0] == labels[1] and found.elimination.kept == base.elimination.kept
