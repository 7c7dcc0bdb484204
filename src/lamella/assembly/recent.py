"""Values that an object evaluated last, by their arguments."""

from __future__ import annotations

from collections.abc import Callable, Hashable

from lamella.roles import Floats


class Recent:
    """What an object evaluated last, by the arguments.

    ``lru_cache`` of a method that the object itself holds would tie both into a cycle, and a whole model would wait for the
    garbage collector: the next one would then be made in fresh memory.

    Args:
        count: values that are kept.
    """

    def __init__(self, count: int = 4) -> None:
        self._count = count
        self._values: dict[Hashable, Floats] = {}

    def get(self, arguments: Hashable, evaluate: Callable[[], Floats]) -> Floats:
        """The value, evaluated where it is not known; not to be written to."""
        if arguments not in self._values:
            while len(self._values) >= self._count:
                del self._values[next(iter(self._values))]  # the oldest
            self._values[arguments] = evaluate()
        return self._values[arguments]

    def clear(self) -> None:
        """Forget all values."""
        self._values.clear()
