"""What public functions are called with: arguments of another kind are refused with words."""

from __future__ import annotations

import inspect
import reprlib
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from functools import wraps
from math import isfinite
from numbers import Integral, Real
from os import PathLike
from typing import Any, NamedTuple, ParamSpec, TypeVar

from lamella.errors import DeclarationError

Parameters = ParamSpec("Parameters")
Returned = TypeVar("Returned")


class Kind(NamedTuple):
    """What an argument may be: a test of a value, and the words for it in a message."""

    accepts: Callable[[Any], bool]
    words: str


NUMBER = Kind(lambda value: isinstance(value, Real) and not isinstance(value, bool), "a number")
REAL = Kind(lambda value: NUMBER.accepts(value) and _converts(value), "a number")
PATH = Kind(lambda value: isinstance(value, (str, PathLike)), "a path")
TEXT = Kind(lambda value: isinstance(value, str), "a text")
WHOLE = Kind(lambda value: isinstance(value, Integral) and REAL.accepts(value), "a whole number")
FINITE = Kind(lambda value: REAL.accepts(value) and isfinite(value), "a finite number")
POSITIVE = Kind(lambda value: FINITE.accepts(value) and value > 0, "a positive number")


def _converts(value: Real) -> bool:
    """Whether it is a float, or has one near it."""
    try:
        float(value)
    except OverflowError:  # of a whole number of more than 308 digits
        return False
    return True


def at_least(least: int) -> Kind:
    """A whole number that is not smaller."""
    return Kind(lambda value: WHOLE.accepts(value) and value >= least, f"a whole number, {least} or more")


def instance(words: str, *classes: type) -> Kind:
    """An instance of one of some classes."""
    return Kind(lambda value: isinstance(value, classes), words)


def optional(kind: Kind) -> Kind:
    """The same, or None."""
    return Kind(lambda value: value is None or kind.accepts(value), f"{kind.words}, or None")


def one_of(words: Iterable[str]) -> Kind:
    """One of some words."""
    known = tuple(words)
    return Kind(lambda value: isinstance(value, str) and value in known, f"one of {', '.join(known)}")


def numbers(words: str) -> Kind:
    """A sequence of numbers."""

    def accepts(value: Any) -> bool:
        return isinstance(value, Iterable) and not isinstance(value, str) and all(map(NUMBER.accepts, value))

    return Kind(accepts, words)


def sequence(kind: Kind, least: int = 0) -> Kind:
    """A list of values of a kind, of some length at least."""

    def accepts(value: Any) -> bool:
        listed = isinstance(value, Sequence) and not isinstance(value, str)
        return listed and len(value) >= least and all(map(kind.accepts, value))

    return Kind(accepts, f"a list of {kind.words}{f', {least} or more' if least else ''}")


def mapping(kind: Kind, least: int = 0) -> Kind:
    """A mapping of names to values of a kind, of some length at least."""

    def accepts(value: Any) -> bool:
        named = isinstance(value, Mapping) and all(map(TEXT.accepts, value))
        return named and len(value) >= least and all(map(kind.accepts, value.values()))

    return Kind(accepts, f"a mapping of names to {kind.words}{f', {least} or more' if least else ''}")


def either(*kinds: Kind) -> Kind:
    """What one of some kinds accepts."""
    return Kind(lambda value: any(kind.accepts(value) for kind in kinds), " or ".join(kind.words for kind in kinds))


def _are_texts(value: Any) -> bool:
    return isinstance(value, Collection) and not isinstance(value, str) and all(map(TEXT.accepts, value))


NAMES = Kind(_are_texts, "a list of names")
NAMED = Kind(
    lambda value: _are_texts(value) and (not isinstance(value, Mapping) or _are_texts(value.values())),
    "a list of names, or a mapping of names to names",
)


def accepts(**kinds: Kind) -> Callable[[Callable[Parameters, Returned]], Callable[Parameters, Returned]]:
    """Let a function refuse arguments that are not of their kind; those not named are left to the function.

    Args:
        kinds: of the arguments, by name.

    Raises:
        DeclarationError: by the function: its name, the argument with its value, and what is accepted.
    """

    def decorate(function: Callable[Parameters, Returned]) -> Callable[Parameters, Returned]:
        signature = inspect.signature(function)
        name_of = function.__qualname__.removesuffix(".__init__").rpartition(".")[2]

        @wraps(function)
        def call(*args: Parameters.args, **kwargs: Parameters.kwargs) -> Returned:
            for name, value in signature.bind(*args, **kwargs).arguments.items():
                if name in kinds and not kinds[name].accepts(value):
                    raise DeclarationError(name_of, f"{name} = {reprlib.repr(value)}", f"accepted is {kinds[name].words}")
            return function(*args, **kwargs)

        return call

    return decorate
