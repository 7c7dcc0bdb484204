"""Text of a model file as plain data that remembers its lines; nothing in it is ever executed.

Only YAML's plain types are made (mapping, list, text, number, true/false, null); a tag that asks for an object is refused.
"""

from __future__ import annotations

import json
import math
import re
import reprlib
from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass
from functools import cache, lru_cache
from pathlib import Path
from typing import Any

from ruamel.yaml import YAML
from ruamel.yaml.constructor import SafeConstructor
from ruamel.yaml.error import MarkedYAMLError, YAMLError
from ruamel.yaml.nodes import MappingNode, Node, ScalarNode, SequenceNode

from lamella.errors import ModelFileError

Key = str | int
Place = tuple[Key, ...]
LARGEST = 20_000_000
"""Largest model file read [bytes]."""

MOST_VALUES = 300_000
"""Largest number of values after aliases are expanded; a few lines of nested aliases can ask for billions."""

PLAIN = re.compile(r'-?(0|[1-9]\d*)(\.\d+([eE][-+]?\d+)?)?|"[^"\\\x00-\x1f]*"')
"""A number or a quoted text that means the same in JSON and in YAML."""

_TAG = "tag:yaml.org,2002:"
_short = reprlib.Repr()
_short.maxstring = _short.maxother = 60


def shown(value: object) -> str:
    """A value for a message, as short as it can be told."""
    if value is None:
        return "nothing"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float):
        return "NaN" if math.isnan(value) else f"{value:g}"
    return "a mapping" if isinstance(value, dict) else _short.repr(value)


def key_path(place: Place) -> str:
    """A place in dotted form, for example ``system.plate.mesh[1]``."""
    text = ""
    for key in place:
        text += f"[{key}]" if isinstance(key, int) else f".{key}" if text else key
    return text


@dataclass(frozen=True)
class Problem:
    """Something wrong in a model file."""

    place: Place
    text: str


class Document:
    """A parsed model file.

    Args:
        text: its text.
        name: what messages call it, usually the file's path.
        folder: from which paths in it count.
    """

    def __init__(self, text: str, name: str, folder: Path | None = None) -> None:
        self.name, self.text, self.folder = name, text, folder or Path()
        self.problems: list[Problem] = []
        self._overrides: dict[Place, str] = {}
        self._lines: dict[Place, int] = {}
        self._values = 0
        self.data: Any = self._plain(self._compose(text), (), ())
        if not isinstance(self.data, dict):
            raise ModelFileError(f"{name}: expected 'key: value' lines, found {shown(self.data)} (see 'lamella new')")

    @classmethod
    def read(cls, path: Path) -> Document:
        """Read a file.

        Raises:
            ModelFileError: the file is missing, a folder, not readable, too large, not text or not YAML.
        """
        if path.is_dir():
            raise ModelFileError(f"{path} is a folder; expected is a model file, such as {path / 'model.yaml'}")
        try:
            content = path.read_bytes() if path.stat().st_size <= LARGEST else None
        except OSError as error:
            raise ModelFileError(f"{path} cannot be read: {error.strerror or error}") from error
        if content is None:
            raise ModelFileError(f"{path} has more than {LARGEST // 1_000_000} MB; expected is a model file (text)")
        try:
            text = content.decode("utf-8-sig")
        except UnicodeDecodeError as error:
            raise ModelFileError(f"{path} is not a text file in UTF-8 (byte {error.start}); expected is a model file") from error
        return cls(text, str(path), path.parent)

    def copy(self) -> Document:
        """The document as it is now; overrides and problems of the two are their own."""
        found = copy(self)
        found.problems, found._overrides, found._lines = [*self.problems], {**self._overrides}, {**self._lines}
        return found

    def _compose(self, text: str) -> Node:
        try:
            root = YAML(typ="safe", pure=True).compose(text)
        except MarkedYAMLError as error:
            mark = error.problem_mark or error.context_mark
            line = f"line {mark.line + 1}, column {mark.column + 1}: " if mark else ""
            raise ModelFileError(f"{self.name}, {line}not valid YAML: {_words(error, text)}") from error
        except YAMLError as error:
            raise ModelFileError(f"{self.name} is not a text file of a model: {str(error).splitlines()[0]}") from error
        except RecursionError as error:
            raise ModelFileError(f"{self.name}: lists or mappings are nested too deeply") from error
        if root is None:
            raise ModelFileError(f"{self.name} is empty; 'lamella new' writes a template")
        return root

    def _plain(self, node: Node, place: Place, above: tuple[Node, ...]) -> Any:
        if any(node is ancestor for ancestor in above):
            self.problem(place, "an alias refers to the item it is part of")
            return None
        above = (*above, node)
        self._values += 1
        if self._values > MOST_VALUES:
            raise ModelFileError(f"{self.name} has more than {MOST_VALUES} values once its aliases are expanded")
        if isinstance(node, (MappingNode, SequenceNode)) and node.tag not in (_TAG + "map", _TAG + "seq"):
            self.problem(place, f"the tag {node.tag} is not accepted", node)
            return None
        if isinstance(node, MappingNode):
            return self._mapping(node, place, above)
        if isinstance(node, SequenceNode):
            items = []
            for index, item in enumerate(node.value):
                self._note((*place, index), item)
                items.append(self._plain(item, (*place, index), above))
            return items
        return self._scalar(node, place)

    def _mapping(self, node: MappingNode, place: Place, above: tuple[Node, ...]) -> dict[str, Any]:
        found: dict[str, Any] = {}
        inherited: dict[str, Any] = {}
        for key_node, value_node in node.value:
            key = str(key_node.value)
            if key_node.tag == _TAG + "merge":
                merged = self._plain(value_node, place, above)
                for part in merged if isinstance(merged, list) else [merged]:
                    inherited |= part if isinstance(part, dict) else {}
                continue
            if key in found:
                first = self._lines[(*place, key)]
                self.problem((*place, key), f"the key '{key}' is already given in line {first}", key_node)
                continue
            self._note((*place, key), key_node)
            found[key] = self._plain(value_node, (*place, key), above)
        return inherited | found

    def _scalar(self, node: Node, place: Place) -> Any:
        assert isinstance(node, ScalarNode)
        kind = str(node.tag).removeprefix(_TAG)
        if kind in ("str", "timestamp", "value"):
            return node.value
        if kind == "null":
            return None
        construct = {"int": "construct_yaml_int", "float": "construct_yaml_float", "bool": "construct_yaml_bool"}.get(kind)
        if construct is None:
            self.problem(place, f"the tag {node.tag} is not accepted", node)
            return node.value
        try:
            value = getattr(_constructor(), construct)(node)
        except ValueError:
            return node.value
        return value

    def _note(self, place: Place, node: Node) -> None:
        self._lines[place] = node.start_mark.line + 1

    def problem(self, place: Place, text: str, node: Node | None = None) -> None:
        """Keep a problem; all of a file are reported together."""
        if node is not None:
            self._note(place, node)
        if Problem(place, text) not in self.problems:
            self.problems.append(Problem(place, text))

    def override(self, place: Place, value: Any, said: str) -> None:
        """Replace or add the value at ``place``; messages about it show ``said``."""
        self.data = _replaced(self.data, place, value)
        self._overrides[place] = said

    def where(self, place: Place) -> str:
        """The override or line and key of a place, for messages."""
        for length in range(len(place), 0, -1):
            if place[:length] in self._overrides:
                return f"--set {self._overrides[place[:length]]}"
        added = next((said for target, said in self._overrides.items() if place and target[: len(place)] == place), None)
        if added is not None and place not in self._lines:
            return f"--set {added}"
        for length in range(len(place), 0, -1):
            if place[:length] in self._lines:
                return f"line {self._lines[place[:length]]}, {key_path(place)}"
        return key_path(place) or "file"

    def line(self, place: Place) -> int:
        """Line of the nearest place above ``place`` that has one; 0 for the file as a whole."""
        return next((self._lines[place[:n]] for n in range(len(place), 0, -1) if place[:n] in self._lines), 0)

    def check(self) -> None:
        """Raise all problems found so far as one error."""
        if not self.problems:
            return
        ordered = sorted(self.problems, key=lambda problem: self.line(problem.place))
        texts = [f"{self.where(problem.place)}: {problem.text}" for problem in ordered]
        if len(texts) == 1:
            raise ModelFileError(f"{self.name}, {texts[0]}")
        raise ModelFileError(f"{self.name}: {len(texts)} errors\n" + "\n".join(f"  {text}" for text in texts))


def plain_value(text: str) -> Any:
    """The value of a piece of YAML such as ``[8, 8]``, ``0.5ms`` or ``true``.

    Numbers and quoted text, which studies and gradients give by the hundred, are JSON as well, which is read at once.
    """
    if PLAIN.fullmatch(text):
        return json.loads(text)
    document = Document(f"value: {text}", f"'{text}'")
    document.check()
    return document.data["value"]


@lru_cache(maxsize=4)
def parsed(text: str, name: str, folder: Path | None = None) -> Document:
    """The document of a text, of which the last few are kept: studies and gradients read the same one again and again.

    It is not to be written to; take a copy.
    """
    return Document(text, name, folder)


@cache
def _constructor() -> SafeConstructor:
    return YAML(typ="safe", pure=True).constructor


def _words(error: MarkedYAMLError, text: str) -> str:
    problem, mark = str(error.problem or error.context), error.problem_mark
    if "\\t" in problem or (mark and "\t" in text.splitlines()[min(mark.line, text.count("\n"))][: mark.column + 1]):
        return "a tab is used to indent; accepted are spaces only"
    if problem == "mapping values are not allowed here":
        return "a ':' is not allowed here; quote a text that holds ': ', or check the indentation"
    context = f" {error.context}" if error.context else ""
    return problem + context


def _replaced(data: Any, place: Place, value: Any) -> Any:
    """A copy of ``data`` along ``place`` only, with the new value (aliases share parts, which must stay as they are)."""
    if not place:
        return value
    key, rest = place[0], place[1:]
    if isinstance(data, list):
        copy: Sequence[Any] = [*data]
        assert isinstance(key, int)
        copy[key] = _replaced(data[key], rest, value)  # type: ignore[index]
        return copy
    source = data if isinstance(data, dict) else {}
    return {**source, key: _replaced(source.get(str(key)), rest, value)}


KINDS = {"lamella": ("a model", "run"), "study": ("a study", "study"), "optimize": ("an optimisation", "optimize")}
"""What a file is by the key of its first line, and the command that runs it."""


def refuse_other_kind(document: Document, key: str) -> None:
    """Refuse a file without the ``key`` of its first line that has the one of another kind.

    Raises:
        ModelFileError: it has; the message names the command for it.
    """
    for other, (name, command) in KINDS.items():
        if other in document.data:
            runs = f"'lamella {command} {document.name}' runs it"
            raise ModelFileError(f"{document.name} is {name} file; {runs}, {KINDS[key][0]} file begins with '{key}: 1'")
