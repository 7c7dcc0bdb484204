"""Inputs of a linear model: the functions of time that loads, drives and supports of a system follow."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from functools import cache
from typing import Any, get_type_hints

import numpy as np

from lamella.assembly.constraints import ConstraintStack
from lamella.assembly.forces import ForceSum
from lamella.errors import DeclarationError
from lamella.joint.drive import AngleDrive, SlideDrive
from lamella.linear.steady import SteadyState
from lamella.load.controller import Controller
from lamella.math.profile import Constant
from lamella.math.time_function import TimeFunction
from lamella.model import Model
from lamella.roles import Declaration, Floats
from lamella.state import State
from lamella.system import System
from lamella.units import unit_in

Inputs = Sequence[str] | Mapping[str, str]
Following = Callable[[TimeFunction], Declaration]

STEP = 1e-5
"""Step of central differences where an input does not act in proportion."""
PROPORTIONAL = 1e-9
"""Share of an effect by which equal steps up and down may differ where it is proportional."""
ACCELERATION = ".acceleration"
AXES = ("x", "y", "z")


@dataclass(frozen=True)
class Channel:
    """A function of time of a declaration.

    Args:
        name: name of the declaration, with the field's behind a dot where there are several.
        field: name of the field.
        number: place of the declaration in its system.
        unit: unit of the function.
        level: its value at the time of the state, not a number for a drive that is given by its speed.
        rate: its rate at that time [1/s].
        following: the declaration with another function in its place.
    """

    name: str
    field: str
    number: int
    unit: str
    level: float
    rate: float
    following: Callable[[TimeFunction], Declaration]


@dataclass(frozen=True)
class Effect:
    """What a unit of an input does at the state.

    Args:
        name: name of the input.
        unit: its unit.
        level: its value in the state.
        force: derivative of the force f = f_int - f_ext, shape (n_q,).
        position: change of q that moving supports, drives and prescribed temperatures ask for, shape (n_q,).
        signals: derivatives of signals that depend on the input itself, by name.
        accelerates: whether the input is the second derivative of the function.
    """

    name: str
    unit: str
    level: float
    force: Floats
    position: Floats
    signals: dict[str, Floats]
    accelerates: bool = False


def channels(system: System, t: float) -> dict[str, Channel]:
    """All functions of time of a system's declarations, by name."""
    found: dict[str, Channel] = {}
    for number, item in enumerate(system.declarations):
        own = _functions(item, t)
        for part, (level, rate, following) in own.items():
            name = item.name if len(own) == 1 else f"{item.name}.{part}"
            units = _units(type(item))
            unit = units["motion"] if part in AXES else units[part]
            found[name] = Channel(name, part, number, unit, level, rate, following)
    return found


@cache
def _units(kind: type) -> dict[str, str]:
    """Unit of what each field of a declaration stands for; that of a factor is 1."""
    return {name: unit_in(annotation) or "1" for name, annotation in get_type_hints(kind, include_extras=True).items()}


def chosen(item: str, system: System, inputs: Inputs, t: float) -> dict[str, tuple[Channel, bool]]:
    """The functions of time that inputs name, by the inputs' own names, and whether each is meant by its acceleration.

    Args:
        item: who asks, for messages.
        system: the system.
        inputs: names of loads, drives and supports; or a mapping of names of inputs to those.
        t: time of the state [s].

    Raises:
        DeclarationError: there is no such function of time, or one is given twice.
    """
    names = dict(inputs) if isinstance(inputs, Mapping) else {name: name for name in inputs}
    if len(names) < len(inputs):
        raise DeclarationError(item, f"inputs = {inputs!r}", "accepted is each once")
    known = channels(system, t)
    found = {}
    for name, of in names.items():
        channel = known.get(of.removesuffix(ACCELERATION))
        if channel is None:
            accepted = f"inputs are loads, drives and supports that follow a function of time; there are: {', '.join(known)}"
            raise DeclarationError(item, f"there is no input '{of}'", accepted if known else "none of the system does")
        found[name] = channel, of.endswith(ACCELERATION)
    return found


def unit_of(channel: Channel, accelerates: bool) -> str:
    """Unit of an input."""
    return f"{channel.unit}/s^2" if accelerates else channel.unit


def effects(steady: SteadyState, inputs: Inputs) -> list[Effect]:
    """What each input does.

    Args:
        steady: the state.
        inputs: names of loads, drives and supports; or a mapping of names of inputs to those.

    Raises:
        DeclarationError: there is no such function of time, or the model was compiled from no system.
    """
    if not inputs:
        raise DeclarationError("linearise", f"inputs = {inputs!r}", "accepted is at least one input")
    system = steady.model.description
    if not isinstance(system, System):
        raise DeclarationError("linearise", "the model was not compiled from a system", "accepted is the system itself")
    found = chosen("linearise", system, inputs, steady.point.t)
    return [_effect(steady, system, name, channel, accelerates=turned) for name, (channel, turned) in found.items()]


def _functions(item: Declaration, t: float) -> dict[str, tuple[float, float, Following]]:
    """Functions of time of one declaration: value and rate at t, and the declaration with another one in their place."""
    if isinstance(item, (AngleDrive, SlideDrive)):  # a speed is given by its integral
        field = "angle" if isinstance(item, AngleDrive) else "displacement"
        given: Any = getattr(item, field)
        level, rate = (given.value(t), given.rate(t)) if given is not None else (float("nan"), item.speed.value(t))  # type: ignore[union-attr]  # one of them is given
        return {field: (level, rate, lambda to: replace(item, speed=None, **{field: to}))}
    found: dict[str, tuple[float, float, Following]] = {}
    for field in fields(item):  # type: ignore[arg-type]  # every declaration is a dataclass
        value = getattr(item, field.name)
        if field.name == "change" and value is None:
            value = Constant(0.0)
        if isinstance(value, TimeFunction):
            found[field.name] = value.value(t), value.rate(t), _with(item, field.name)
        elif field.name == "motion" and isinstance(value, dict):
            for axis, function in value.items():
                found[axis] = function.value(t), function.rate(t), _with_axis(item, value, axis)
    return found


def _with(item: Any, field: str) -> Following:
    return lambda to: replace(item, **{field: to})


def _with_axis(item: Any, motion: dict[str, TimeFunction], axis: str) -> Following:
    return lambda to: replace(item, motion={**motion, axis: to})


class _Probe:
    """Everything an input may act on, with the input held at some level.

    Args:
        steady: the state.
        model: the system with that level.
    """

    def __init__(self, steady: SteadyState, model: Model) -> None:
        equations, state = steady.equations, steady.state
        t, q, v = state.t, state.q, state.v
        blocks = (*model.forces, *model.loads)
        self.force = ForceSum(blocks, model.n_q)(t, q, v).copy()
        self.phi = ConstraintStack(model.constraints).phi_of_all(t, q)[equations.constraints.kept]
        rows = [model.rows[number] for number in equations.elimination.kept]
        self.held = np.array([row.constant + (row.motion.value(t) if row.motion is not None else 0.0) for row in rows])
        plain = State(t, q, v, state.a, state.lam, state.reaction, 1.0)
        self.signals = {s.name: np.atleast_1d(s.evaluate(plain)) for s in model.signals}

    def parts(self) -> tuple[Floats, ...]:
        return self.force, self.phi, self.held, *self.signals.values()


def _effect(steady: SteadyState, system: System, name: str, channel: Channel, *, accelerates: bool) -> Effect:
    level = driven_level(steady.model, channel, steady.point.t)

    def probe(change: float) -> _Probe:
        other = System(system.redundant)
        other.declarations = list(system.declarations)
        other.declarations[channel.number] = channel.following(Constant(level + change))
        other.declarations = [item for item in other.declarations if not isinstance(item, Controller)]  # the loop is open
        return _Probe(steady, other.compile(steady.model.imperfection))

    step, here = 1.0, probe(0.0)
    ahead, behind = probe(step), probe(-step)
    if not _proportional(ahead, here, behind):
        step = STEP * max(1.0, abs(level))
        ahead, behind = probe(step), probe(-step)
    force, phi, held, *_ = ((a - b) / (2.0 * step) for a, b in zip(ahead.parts(), behind.parts(), strict=True))
    signals = {key: (ahead.signals[key] - behind.signals[key]) / (2.0 * step) for key in ahead.signals}
    elimination = steady.equations.elimination
    moved = elimination.particular(held)
    position = moved - elimination.T @ (steady.P @ (steady.J @ moved + phi))
    if accelerates and not np.any(position):
        raise DeclarationError(
            "linearise",
            f"the input '{channel.name}{ACCELERATION}' has no motion to accelerate",
            f"accepted is '{channel.name}', or the acceleration of a drive or a support that moves",
        )
    return Effect(name, unit_of(channel, accelerates), 0.0 if accelerates else level, force, position, signals, accelerates)


def driven_level(model: Model, channel: Channel, t: float) -> float:
    """The level of a channel; where a drive that is given by its speed stands, what its constraint asks for at the time t."""
    if np.isfinite(channel.level):
        return channel.level
    block = next(block for block in model.constraints if block.name == channel.name)
    return float(block.prescribed(t)[0])


def _proportional(ahead: _Probe, here: _Probe, behind: _Probe) -> bool:
    """Whether equal steps up and down change everything by the same."""
    for a, b, c in zip(ahead.parts(), here.parts(), behind.parts(), strict=True):
        scale = np.abs(a - c).max(initial=0.0) + np.finfo(float).eps * np.abs(b).max(initial=0.0) / PROPORTIONAL
        if np.abs(a - 2.0 * b + c).max(initial=0.0) > PROPORTIONAL * scale:
            return False
    return True
