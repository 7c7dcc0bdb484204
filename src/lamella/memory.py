"""What objects remember between the steps of a run, so that a run can be saved and gone on with."""

from __future__ import annotations

from copy import deepcopy
from typing import Any, ClassVar


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

    def recall(self, memory: dict[str, Any]) -> None:
        """Take back what :meth:`memory` gave."""
        for name in self.remembered:
            value = getattr(self, name)
            if isinstance(value, Memory):
                value.recall(memory[name])
            else:
                setattr(self, name, deepcopy(memory[name]))
