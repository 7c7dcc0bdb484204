"""What objects remember between the steps of a run, so that a run can be saved and gone on with."""

from __future__ import annotations

from copy import deepcopy
from typing import Any, ClassVar

import numpy as np


class Memory:
    """Something that the next step depends on, beside what never changes.

    1. ``remembered`` names the attributes that do: numbers, texts, arrays, lists, tuples and dicts of them, or other objects with
       a memory. What only saves time (a factorisation, the last force) is not among them.
    2. ``memory`` gives copies; ``recall`` takes them back, and forgets what only saved time.
    """

    remembered: ClassVar[tuple[str, ...]] = ()

    def memory(self) -> dict[str, Any]:
        """Copies of all that is remembered."""
        values = {name: getattr(self, name) for name in self.remembered}
        return {name: value.memory() if isinstance(value, Memory) else deepcopy(value) for name, value in values.items()}

    def fits(self, memory: object) -> bool:
        """Whether it is the memory of something alike: of the same names, and arrays of the same shapes."""
        if not isinstance(memory, dict) or memory.keys() != set(self.remembered):
            return False
        return all(_alike(getattr(self, name), memory[name]) for name in self.remembered)

    def recall(self, memory: dict[str, Any]) -> None:
        """Take back what :meth:`memory` gave."""
        for name in self.remembered:
            value = getattr(self, name)
            if isinstance(value, Memory):
                value.recall(memory[name])
            else:
                setattr(self, name, deepcopy(memory[name]))

    def reset(self) -> None:
        """Forget what happened in an earlier run."""


def _alike(value: object, found: object) -> bool:
    if isinstance(value, Memory):
        return value.fits(found)
    return not (isinstance(value, np.ndarray) and isinstance(found, np.ndarray)) or value.shape == found.shape
