"""What the functions that solve systems accept as their common arguments."""

from __future__ import annotations

from typing import get_args

from lamella.arguments import Kind, instance, one_of, optional, sequence
from lamella.assembly.equations import Equations
from lamella.model import Model
from lamella.solve.linear import Method
from lamella.state import State
from lamella.system import System

SYSTEM = instance("a System or its compiled model", System, Model)
EQUATIONS = instance("a System, its compiled model or its equations", System, Model, Equations)
STATE = optional(instance("a state such as equilibrium(system).final", State))
SOLVER = one_of(get_args(Method))
SINKS = sequence(Kind(lambda value: all(callable(getattr(value, name, None)) for name in ("sample", "frame", "close")), "sinks"))
"""See :class:`lamella.result.Sink`."""
FAILURE = one_of(("raise", "return"))
