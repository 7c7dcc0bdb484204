"""Names in a model file: what ``plate.tip``, ``plate.x-`` or ``cfrp`` refers to, and the order in which items are made."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any

from lamella.body.base import Body, Marker
from lamella.body.plate import Edge
from lamella.body.shell_body import ShellBody
from lamella.io.annotation import Options, field_specs, tag_of
from lamella.io.document import Document, Place, shown
from lamella.io.reader import FAILED, Reader, accepted, kinds, suggestion
from lamella.io.sections import DEFINITIONS, SECTIONS
from lamella.units import ANY

EDGES = ("x-", "x+", "y-", "y+")
CORNERS = ("x-y-", "x+y-", "x+y+", "x-y+")
ORIGIN = "origin"
NAME = re.compile(r"[^\W\d][\w-]*")
BUSY = object()
PROFILES = "profiles"


class Items:
    """The named items of a document, each read when it is first needed.

    Args:
        document: the parsed model file.
    """

    def __init__(self, document: Document) -> None:
        self.document = document
        self.reader = Reader(document, self.lookup)
        self._made: dict[tuple[str, str, str | None], Any] = {}

    def section(self, name: str) -> dict[str, Any]:
        """All items of a section in the order of the file; failed ones are left out."""
        content = self.document.data.get(name)
        if content is None:
            return {}
        if not isinstance(content, dict):
            self.document.problem((name,), f"found {shown(content)}; accepted are 'name: {{...}}' entries")
            return {}
        # What profiles stand for, and so their unit, is told by those who refer to them.
        used = {key for section, key, _ in self._made if section == name} if name == PROFILES else ()
        items = {key: self.item(name, key, ANY if name == PROFILES else None) for key in content if key not in used}
        return {key: item for key, item in items.items() if item is not FAILED}

    def item(self, section: str, name: str, unit: str | None = None) -> Any:
        """The item ``name`` of a section, a profile in the ``unit``, or FAILED."""
        place, key = (section, name), (section, name, unit)
        found = self._made.get(key)
        if found is BUSY:
            self.document.problem(place, f"'{name}' refers to itself")
            return FAILED
        if found is None:
            self._made[key] = BUSY
            found = self._made[key] = self._read(place, unit)
        return found

    def _read(self, place: Place, unit: str | None) -> Any:
        section, name = str(place[0]), str(place[1])
        data = self.document.data[section][name]
        classes = SECTIONS[section].classes_of(data.get("type") if isinstance(data, dict) else None)
        if not NAME.fullmatch(name):
            self.document.problem(
                place, f"the name '{name}' is not accepted; accepted are letters, digits, _ and -, beginning with a letter"
            )
            return FAILED
        has_name = all("name" in field_specs(cls) for cls in classes)
        return self.reader.declared(classes, data, place, {"name": name} if has_name else {}, unit=unit)

    def lookup(self, allowed: Options, text: str, place: Place, unit: str | None = None) -> Any:
        """What ``text`` refers to; FAILED after a problem, None when it is no reference at all."""
        if allowed.places and ("." in text or not allowed.references):
            return self._place(allowed, text, place)
        if allowed.references:
            return self._referred(allowed.references, text, place)
        return self._definition(allowed, text, place, unit)

    def _definition(self, allowed: Options, text: str, place: Place, unit: str | None) -> Any:
        known, definable = [], False
        for section in DEFINITIONS:
            content = self.document.data.get(section)
            names = list(content) if isinstance(content, dict) else []
            if any(cls in SECTIONS[section].classes() for cls in allowed.classes):
                definable = True
                if text in names:
                    return self.item(section, text, unit if section == PROFILES else None)
                known += names
        if definable and NAME.fullmatch(text):
            self.document.problem(place, f"nothing is defined under the name '{text}'{suggestion(text, known)}")
            return FAILED
        return None

    def _referred(self, classes: tuple[type, ...], name: str, place: Place) -> Any:
        """The item of the system called ``name``, which must be of one of ``classes``."""
        content = self.document.data.get("system")
        item = self.item("system", name) if isinstance(content, dict) and name in content else None
        if item is FAILED or isinstance(item, classes):
            return item
        types = kinds(classes)
        if item is None:
            problem = f"there is no {'body' if classes == (Body,) else ' or '.join(types)} '{name}'"
        else:
            problem = f"'{name}' has the type {tag_of(type(item))[1]}"
        self.document.problem(place, problem + suggestion(name, self._names(types)))
        return FAILED

    def _names(self, types: Sequence[str]) -> list[str]:
        """Names of the items of the system of these types, whether they can be read or not."""
        content = self.document.data.get("system")
        items = content.items() if isinstance(content, dict) else ()
        return [name for name, item in items if isinstance(item, dict) and item.get("type") in types]

    def _place(self, allowed: Options, text: str, place: Place) -> Any:
        body_name, dot, name = text.partition(".")
        if not dot:
            self.document.problem(place, f"found '{text}'; accepted is {accepted(allowed)}")
            return FAILED
        body = self._referred((Body,), body_name, place)
        if body is FAILED:
            return FAILED
        found = place_of(body, name)
        if isinstance(found, allowed.places):
            return found
        if found is not None:
            wanted = "an edge" if Edge in allowed.places else "a marker"
            self.document.problem(
                place, f"'{text}' is {'a marker' if isinstance(found, Marker) else 'an edge'}; accepted is {wanted}"
            )
            return FAILED
        corners = CORNERS if isinstance(body, ShellBody) else (ORIGIN,)
        points = dict.fromkeys((*markers_of(body), *corners)) if Marker in allowed.places else ()
        edges = EDGES if isinstance(body, ShellBody) and Edge in allowed.places else ()
        known = [*points, *edges]
        self.document.problem(place, f"'{body_name}' has no marker or edge '{name}'{suggestion(name, known)}")
        return FAILED


def markers_of(body: Body) -> dict[str, tuple[float, ...]]:
    """Named points of a body."""
    return dict(getattr(body, "markers", {}))


def place_of(body: Body, name: str) -> Marker | Edge | None:
    """The marker, corner, edge or origin called ``name`` of a body; None when there is none."""
    markers = markers_of(body)
    if name in markers:
        return Marker(body, name, markers[name])
    if isinstance(body, ShellBody) and name in EDGES:
        return body.edge(name)  # type: ignore[arg-type]  # one of the four
    if isinstance(body, ShellBody) and name in CORNERS:
        return body.corner(name)
    return getattr(body, ORIGIN, None) if name == ORIGIN else None
