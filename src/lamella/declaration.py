"""The decorator of everything a user declares: frozen data, checked when it is made, with errors that name the item."""

from __future__ import annotations

import functools
import reprlib
from collections.abc import Callable, Sequence
from dataclasses import Field as DataField
from dataclasses import fields
from inspect import Parameter, Signature
from typing import Any, TypeVar, dataclass_transform

from pydantic import ConfigDict, Field, ValidationError
from pydantic.dataclasses import dataclass, rebuild_dataclass
from pydantic_core import ErrorDetails

from lamella.errors import DeclarationError, LamellaError

C = TypeVar("C")
CONFIG = ConfigDict(extra="forbid", arbitrary_types_allowed=True, validate_default=False, defer_build=True)
"""Validators are built when the first one of a kind is declared: a model needs a fifth of all kinds."""


KINDS: list[type] = []
"""All declarations that are known so far."""


@dataclass_transform(frozen_default=True, field_specifiers=(Field,))
def declaration(cls: type[C]) -> type[C]:
    """Make ``cls`` a frozen, validated dataclass that raises :class:`DeclarationError` for impossible values."""
    made = dataclass(frozen=True, config=CONFIG)(cls)
    made.__init__ = _clear_errors(made)  # type: ignore[method-assign]
    KINDS.append(made)
    return made  # type: ignore[return-value]


def _clear_errors(made: Any) -> Callable[..., None]:
    kind, init = made.__name__, made.__init__

    @functools.wraps(init)
    def checked(self: Any, *args: Any, **kwargs: Any) -> None:
        if not made.__pydantic_complete__:
            rebuild_dataclass(made)
            made.__init__ = checked  # the building has put its own in place
        names = [field.name for field in given_fields(type(self)) if not field.kw_only]
        if len(args) > len(names):
            raise DeclarationError(kind, f"{len(args)} arguments given", f"accepted are {', '.join(names)}")
        kwargs.update(zip(names, args, strict=False))  # so that messages say the argument's name, not its number
        try:
            init(self, **kwargs)
        except ValidationError as error:
            name = kwargs.get("name")
            item = f"{kind} '{name}'" if isinstance(name, str) else kind
            problem, accepted = explain(error.errors())
            raise DeclarationError(item, problem, accepted) from error

    checked.__signature__ = _signature(made)  # type: ignore[attr-defined]
    return checked


def _signature(made: Any) -> Signature:
    """What a declaration is made of, for help and editors; pydantic knows it only once the validator is built."""
    parameters = [Parameter("self", Parameter.POSITIONAL_OR_KEYWORD)]
    for field in given_fields(made):
        kind = Parameter.KEYWORD_ONLY if field.kw_only else Parameter.POSITIONAL_OR_KEYWORD
        known = made.__pydantic_fields__[field.name]
        default = Parameter.empty if known.is_required() else known.get_default(call_default_factory=True)
        parameters.append(Parameter(field.name, kind, default=default, annotation=field.type))
    return Signature(parameters, return_annotation=None)


@functools.cache
def given_fields(cls: type) -> tuple[DataField[Any], ...]:
    """The fields of a declaration that are given when it is made; those that are given by name alone come last."""
    return tuple(sorted((field for field in fields(cls) if field.init), key=lambda field: bool(field.kw_only)))


LIMITS = {
    "greater_than": ("gt", "greater than"),
    "greater_than_equal": ("ge", "at least"),
    "less_than": ("lt", "less than"),
    "less_than_equal": ("le", "at most"),
}


VALUES = {
    **dict.fromkeys(("tuple_type", "list_type"), "a list"),
    "dict_type": "a mapping of names to values",
    **dict.fromkeys(("bool_type", "bool_parsing"), "true or false"),
    **dict.fromkeys(("int_type", "int_parsing", "int_parsing_size", "int_from_float", "finite_number"), "a whole number"),
    **dict.fromkeys(("float_type", "float_parsing"), "a number"),
    "string_type": "a text",
    "callable_type": "a function",
}
"""What is accepted where a value is of another kind."""

_short = reprlib.Repr()
_short.maxstring = _short.maxother = 60


def wanted(errors: Sequence[ErrorDetails]) -> str:
    """What the first of pydantic's errors accepts, if it is of another kind or length; of a union of classes all of them."""
    context, kind = errors[0].get("ctx", {}), errors[0]["type"]
    if kind == "too_short":
        return f"a list of at least {context['min_length']}"
    if kind == "too_long":
        return f"a list of at most {context['max_length']}"
    here = [error.get("ctx", {}) for error in errors if error["loc"][:1] == errors[0]["loc"][:1]]
    classes = [found for found in (known.get("class") or known.get("class_name") for known in here) if found]
    return VALUES.get(kind, "") or " or ".join(f"{'an' if name[0] in 'AEIOU' else 'a'} {name}" for name in classes)


def explain(errors: Sequence[ErrorDetails]) -> tuple[str, str]:
    """Turn the first of pydantic's errors into (problem with the value, what is accepted)."""
    error, accepted = errors[0], wanted(errors)
    parts = [str(part) for part in error["loc"] if not str(part).startswith(("function-", "is-instance["))]
    context = error.get("ctx", {})
    if "class_name" in context and parts[-1:] == [context["class_name"]]:  # a member of a union
        parts.pop()
    place = ".".join(parts)
    kind, value = error["type"], error.get("input")
    cause = context.get("error")
    if isinstance(cause, DeclarationError) and not place:
        return cause.problem, cause.accepted
    if isinstance(cause, LamellaError):
        return f"{place} = {value!r}" if place else str(cause), str(cause) if place else ""
    if kind in LIMITS:
        key, words = LIMITS[kind]
        return f"{place} = {value}", f"accepted is a value {words} {context[key]:g}"
    if kind in ("unexpected_keyword_argument", "extra_forbidden"):
        return f"unknown argument '{place}'", ""
    if kind in ("missing", "missing_argument"):
        return f"'{place}' is missing", ""
    if kind == "literal_error":
        return f"{place} = {value!r}", f"accepted is {context['expected']}"
    if accepted:
        return f"{place} = {_brief(value)}", f"accepted is {accepted}"
    message = error["msg"].removeprefix("Value error, ")
    return f"{place} = {_brief(value)}" if place else message, message if place else ""


def _brief(value: object) -> str:
    """A value for a message: a declaration by its name."""
    name = getattr(value, "name", None)
    return f"{type(value).__name__} '{name}'" if type(value) in KINDS and name else _short.repr(value)
