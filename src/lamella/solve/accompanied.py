"""Substitutions that two solutions share: each asks for its own, and both are made in one reading of the factor."""

from __future__ import annotations

from collections.abc import Callable, Generator
from typing import Any, Generic, TypeVar

from lamella.roles import Floats
from lamella.solve.base import LinearSolver

T = TypeVar("T")
Pair = tuple[Floats, Floats]
Asking = Generator[Pair | None, Any, T]
"""A solution that yields right-hand sides, is sent what substitutions make of them, and returns T. It yields None before it does
what takes the factorisation away from others."""


def driven(asking: Asking[T], substituted: Callable[[Floats, Floats], Pair]) -> T:
    """What a solution returns, with substitutions of its own."""
    found = None
    try:
        while True:
            right = asking.send(found)
            found = None if right is None else substituted(*right)
    except StopIteration as end:
        return end.value


class Accompanied(Generic[T]):
    """A factorisation for solutions that others go along with: with each substitution the next one of the other is made too.

    Where a factor does not fit the first-level cache, two in one reading take 0.7 to 0.8 of the time of one after the other.

    Args:
        linear: holds the factorisation.
    """

    def __init__(self, linear: LinearSolver) -> None:
        self.pattern, self._linear = linear.pattern, linear
        self._other: Asking[T] | None = None
        self._right: Pair | None = None
        self._found: list[T] = []

    def begin(self, other: Asking[T]) -> None:
        """Let another solution go along, as far as it gets."""
        self._other = other
        self._go_on(None)

    def solve(self, r: Floats, s: Floats) -> Pair:
        """The solution for a right-hand side, and what that does for the other."""
        if self._right is None:
            return self._linear.solve(r, s)
        own, others = self._linear.solve_each([(r, s), self._right])
        self._go_on(others)
        return own

    def finish(self) -> T:
        """What the other returns, with what it still asks for by itself."""
        while self._other is not None:
            self._go_on(None if self._right is None else self._linear.solve(*self._right))
        return self._found.pop()

    def _go_on(self, found: Pair | None) -> None:
        assert self._other is not None, "it has begun and not ended"
        try:
            self._right = self._other.send(found)
        except StopIteration as end:
            self._right, self._other = None, None
            self._found.append(end.value)
