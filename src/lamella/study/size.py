"""How large a system is: its items by kind, its coordinates and constraints."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

from lamella.assembly.equations import Equations
from lamella.body.ground import Ground
from lamella.model import Model
from lamella.system import System

KINDS = {"joint": "joints and supports", "load": "loads"}
"""What is declared in a folder of the package, in words."""


@dataclass(frozen=True)
class Size:
    """Numbers of items, coordinates and constraints.

    Args:
        counts: a number for each of them, by its name in words.
        notes: what the user should know, such as that redundant constraints were left out.
    """

    counts: dict[str, int]
    notes: tuple[str, ...]

    def __str__(self) -> str:
        return ", ".join(f"{name} {number}" for name, number in self.counts.items())


def size_of(system: System, model: Model) -> Size:
    """The size of a system.

    Args:
        system: what was declared.
        model: its compiled form.

    Raises:
        ConstraintError: constraints are redundant or contradict each other.
    """
    equations = Equations(model)
    folders = Counter(type(item).__module__.split(".")[1] for item in system.declarations if not isinstance(item, Ground))
    counts = {
        "plates": len(model.plates),
        "rigid bodies": len(model.rigid_bodies),
        **{words: folders[folder] for folder, words in KINDS.items()},
        "coordinates": model.n_q,
        "constraints eliminated": len(equations.elimination.kept),
        "multipliers": equations.n_lam,
        "degrees of freedom": equations.mobility,
    }
    return Size(counts, tuple(equations.notes))
