"""Read declarations from plain data, collecting every problem with its place."""

from __future__ import annotations

import difflib
import re
from collections.abc import Callable, Iterable
from functools import cache
from typing import Any, Final

from pydantic import ConfigDict, TypeAdapter, ValidationError
from pydantic.dataclasses import is_pydantic_dataclass
from pydantic_core import ErrorDetails

from lamella.body.base import Body
from lamella.declaration import LIMITS, wanted
from lamella.errors import DeclarationError, LamellaError
from lamella.io.annotation import (
    FieldSpec,
    Options,
    concrete,
    field_specs,
    fixed_length,
    in_files,
    of_profile,
    options,
    same_shape,
    tag_of,
)
from lamella.io.document import Document, Place, shown
from lamella.io.table_file import FILE, read_table
from lamella.math.profile import QUANTITY, Constant
from lamella.math.table import Table
from lamella.roles import Declaration
from lamella.units import per_second, quantity, unit_in


class Failed:
    """Stands for a value that could not be read; its problem is already in the document."""


FAILED: Final = Failed()
Lookup = Callable[[Options, str, Place, str | None], Any]
"""Finds what a text refers to, a profile in some unit; gives None when it refers to nothing of that kind."""


class Reader:
    """Turn plain data into declarations; problems go to the document, failed values come back as :data:`FAILED`.

    Args:
        document: where the data is from.
        lookup: resolves references.
    """

    def __init__(self, document: Document, lookup: Lookup) -> None:
        self.document, self.lookup = document, lookup

    def value(self, annotation: Any, data: Any, place: Place, usual: Any = None, unit: str | None = None) -> Any:
        """Read ``data`` as ``annotation`` says; the class of ``usual``, the default, is meant where none is named.

        A profile has the ``unit``, or that of the annotation.
        """
        allowed = options(annotation)
        if not allowed.structured or (data is None and allowed.plain):
            return self._plain(annotation, data, place)
        if isinstance(data, str) and (allowed.places or allowed.references or allowed.classes):
            unit = unit_in(annotation) if unit is None else unit
            if Constant in allowed.classes and QUANTITY.match(data):
                level = self._plain(_quantity(unit), data, place)
                return FAILED if level is FAILED else Constant(level)
            found = self.lookup(allowed, data, place, unit)
            if found is not None:
                return found
        if isinstance(data, dict) and allowed.classes:
            unit = unit_in(annotation) if unit is None else unit
            return self.declared(allowed.classes, data, place, usual=type(usual), unit=unit)
        if isinstance(data, dict) and allowed.values is not None:
            read = {key: self.value(allowed.values, item, (*place, key)) for key, item in data.items()}
            return FAILED if FAILED in read.values() else read
        if isinstance(data, list) and allowed.items:
            return self._sequence(allowed, data, place)
        if (data is None or isinstance(data, (dict, list))) and not allowed.plain:
            return self._fail(place, f"found {shown(data)}; accepted is {accepted(allowed)}")
        if not (allowed.classes or allowed.plain):
            return self._fail(place, f"found {shown(data)}; accepted is {accepted(allowed)}")
        return self._plain(annotation, data, place, accepted(allowed))

    def declared(
        self,
        classes: tuple[type, ...],
        data: Any,
        place: Place,
        extra: dict[str, Any] | None = None,
        usual: type | None = None,
        unit: str | None = None,
    ) -> Any:
        """Read a mapping as the one of ``classes`` its tag says; ``extra`` are fields given elsewhere, such as the name.

        The ``unit`` is that of a profile.
        """
        if not isinstance(data, dict):
            return self._fail(place, f"found {shown(data)}; accepted is a mapping with 'key: value' entries")
        cls = self._chosen(classes, data, place, usual)
        if cls is None:
            return FAILED
        if cls is Table and FILE in data:
            return read_table(self.document, data, place) or FAILED
        extra, specs = extra or {}, field_specs(cls)
        key, tag = tag_of(cls)
        given = {name: item for name, item in data.items() if name != key}
        known = [name for name in specs if name not in extra and name != key]
        read: dict[str, Any] = {}
        meant: set[str | None] = set()
        for name, item in given.items():
            if name in known:
                read[name] = self._field(specs[name], item, (*place, name), unit)
            elif name in extra:
                self._fail((*place, name), f"the name is the key '{extra[name]}' and is not repeated")
            else:
                meant.add(closest(name, known))
                self._fail((*place, name), f"{tag} has no key '{name}'{suggestion(name, known)}")
        missing = [name for name in known if specs[name].required and name not in read]
        if set(missing) - meant:
            self._fail(place, f"{tag} needs {' and '.join(repr(name) for name in missing if name not in meant)}")
        if missing or FAILED in read.values() or len(read) < len(given):
            return FAILED
        return self._made(cls, {**extra, **read}, data, place)

    def _field(self, spec: FieldSpec, data: Any, place: Place, unit: str | None) -> Any:
        """A field of a declaration; of a profile its numbers are in the ``unit``, or in that per second."""
        mark = of_profile(spec.annotation)
        if mark is None or unit is None:
            return self.value(spec.annotation, data, place, spec.default)
        if options(spec.annotation).structured:
            return self.value(spec.annotation, data, place, spec.default, per_second(unit, mark.power or 0))
        if not isinstance(data, list):
            return self._plain(_quantity(unit) if spec.annotation.__origin__ is float else spec.annotation, data, place)
        read = []
        for k, item in enumerate(data):
            own = per_second(unit, k if mark.power is None else mark.power)
            read.append(self._plain(_quantity(own), item, (*place, k)))
        return FAILED if FAILED in read else tuple(read)

    def _chosen(self, classes: tuple[type, ...], data: dict[str, Any], place: Place, usual: type | None) -> type | None:
        tags = {tag_of(cls)[1]: cls for cls in classes}
        keys = {tag_of(cls)[0] for cls in classes}
        for key in keys & set(data):
            said = data[key]
            if isinstance(said, str) and said in tags and tag_of(tags[said])[0] == key:
                return tags[said]
            if any(tag_of(cls) == (key, said) for cls in concrete(Declaration) if not in_files(cls)):
                only = "holds Python functions, and nothing in a model file is executed; add it to the system in Python"
                self._fail((*place, key), f"{said} {only}")
                return None
            if isinstance(said, str):
                self._fail((*place, key), f"there is no {key} {shown(said)}{suggestion(said, tags)}")
            else:
                self._fail((*place, key), f"found {shown(said)}; accepted are {', '.join(tags)}")
            return None
        if len(classes) == 1:
            return classes[0]
        alike = {cls: len(set(data) & set(field_specs(cls))) - len(set(data) - set(field_specs(cls))) for cls in classes}
        best = max(alike, key=lambda cls: alike[cls])
        alone = list(alike.values()).count(alike[best]) == 1
        if alike[best] > 0 and alone and len(classes) <= 3:  # a lamina or an isotropic material is told by its keys
            return best
        if usual is not None and alike.get(usual) == alike[best]:
            return usual
        self._fail(place, f"'{min(keys)}' is missing; accepted are {', '.join(sorted(tags))}")
        return None

    def _made(self, cls: type, fields: dict[str, Any], data: dict[str, Any], place: Place) -> Any:
        try:
            return cls(**fields)
        except DeclarationError as error:
            problem = error.problem.removeprefix(error.item + ": ")
            near = _nearest(problem, data, place)
            told = problem.removeprefix(f"{near[-1]}: ") if near else problem
            return self._fail(near, told + (f"; {error.accepted}" if error.accepted else ""))
        except LamellaError as error:
            return self._fail(place, str(error))

    def _sequence(self, allowed: Options, data: list[Any], place: Place) -> Any:
        annotations = allowed.items * len(data) if allowed.repeated else allowed.items
        if len(annotations) != len(data):
            return self._fail(place, f"has {len(data)} items; accepted are {len(annotations)}")
        read = tuple(self.value(annotations[i], item, (*place, i)) for i, item in enumerate(data))
        return FAILED if FAILED in read else read

    def _plain(self, annotation: Any, data: Any, place: Place, words: str = "") -> Any:
        narrowed = annotation if words else same_shape(options(annotation).plain, data)
        length = fixed_length(narrowed)
        if length is not None and isinstance(data, list) and len(data) != length:
            return self._fail(place, f"the list has {len(data)} items; accepted are {length}")
        try:
            return _adapter(narrowed).validate_python(data)
        except ValidationError as error:
            for details in error.errors():
                if details["type"] == "too_short" and len(details["input"]) >= details.get("ctx", {})["min_length"]:
                    continue  # its items are told
                inner = _inside(details["loc"], data)
                whole = details["type"] == "tuple_type" and not inner and length is not None
                self._fail((*place, *inner), explained(details, words or (f"a list of {length}" if whole else "")))
        except LamellaError as error:
            self._fail(place, str(error))
        return FAILED

    def _fail(self, place: Place, text: str) -> Any:
        self.document.problem(place, text)
        return FAILED


@cache
def _quantity(unit: str | None) -> Any:
    return quantity(unit or "")


@cache
def _adapter(annotation: Any) -> TypeAdapter[Any]:
    config = None if is_pydantic_dataclass(annotation) else ConfigDict(arbitrary_types_allowed=True)  # for abstract classes
    return TypeAdapter(annotation, config=config)


def accepted(allowed: Options) -> str:
    """What a value may be, in words."""
    words = []
    if allowed.places:
        edge, marker = (any(cls.__name__ == name for cls in allowed.places) for name in ("Edge", "Marker"))
        words += ["an edge such as plate.x-"] * edge + ["a marker such as plate.tip"] * marker
    if allowed.references:
        body = allowed.references == (Body,)
        words.append("the name of a body" if body else f"the name of an item ({', '.join(kinds(allowed.references))})")
    if allowed.classes:
        names = ", ".join(sorted(tag_of(cls)[1] for cls in allowed.classes))
        if Constant in allowed.classes:
            words.append("a number")
        words.append(f"a mapping ({names})")
    if allowed.items:
        words.append("a list")
    if allowed.values is not None:
        words.append("a mapping with 'key: value' entries")
    return " or ".join(words)


def kinds(references: tuple[type, ...]) -> list[str]:
    """The types of item a name may refer to."""
    return list(dict.fromkeys(tag_of(cls)[1] for base in references for cls in concrete(base)))


def closest(word: str, known: Iterable[str]) -> str | None:
    """The known name a mistyped word resembles, if any."""
    names = {name.lower(): name for name in known}
    near = difflib.get_close_matches(word.lower(), names, 1, 0.6)
    return names[near[0]] if near else None


def suggestion(word: str, known: Iterable[str]) -> str:
    """The rest of a sentence about an unknown word: what was perhaps meant, and what there is."""
    names = list(known)
    if not names:
        return "; there is none to choose from"
    meant = closest(word, names)
    return (f"; did you mean '{meant}'?" if meant else ";") + f" accepted are {', '.join(names)}"


def explained(details: ErrorDetails, words: str = "") -> str:
    """One pydantic error as a sentence: the value, and what is accepted."""
    context, kind, value = details.get("ctx", {}), details["type"], details["input"]
    if kind in LIMITS:
        key, limit = LIMITS[kind]
        return f"found {shown(value)}; accepted is a value {limit} {context[key]:g}"
    if kind == "literal_error":
        choices = context["expected"].replace("'", "").replace(" or ", ", ").split(", ")
        return f"found {shown(value)}{suggestion(str(value), choices)}"
    cause = context.get("error")
    message = str(cause) if isinstance(cause, LamellaError) else details["msg"].removeprefix("Value error, ")
    if kind == "profile":
        return f"found {shown(value)}; {message}"
    if shown(value) in message or "accepted" in message:
        return message
    words = words or wanted([details])
    return f"found {shown(value)}; " + (f"accepted is {words}" if words else message[0].lower() + message[1:])


def _inside(location: tuple[int | str, ...], data: Any) -> Place:
    """The part of a pydantic location that exists in the data (the rest names members of unions)."""
    found: list[int | str] = []
    here = data
    for key in location:
        if (isinstance(here, dict) and key in here) or (isinstance(here, list) and isinstance(key, int) and key < len(here)):
            found.append(key)
            here = here[key]  # type: ignore[index]  # the key fits the container
    return tuple(found)


def _nearest(problem: str, data: dict[str, Any], place: Place) -> Place:
    """The key a problem of a whole declaration speaks of, or the declaration itself."""
    for word in re.findall(r"[\w+-]+", problem):
        if word in data:
            return (*place, word)
        for key, inner in data.items():
            if isinstance(inner, dict) and word in inner:
                return (*place, key, word)
    return place
