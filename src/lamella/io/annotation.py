"""What the type annotations of the declarations say about the values a model file may give."""

from __future__ import annotations

import collections.abc
import inspect
import types
from dataclasses import MISSING, dataclass
from functools import cache
from typing import Annotated, Any, Literal, Union, get_args, get_origin, get_type_hints

from pydantic.dataclasses import is_pydantic_dataclass
from pydantic.fields import FieldInfo

from lamella.body.base import Marker
from lamella.body.plate import Edge
from lamella.declaration import KINDS, given_fields
from lamella.io.catalogue import import_subclasses, tag_of_name
from lamella.roles import Declaration
from lamella.units import OfProfile

PLACES = (Marker, Edge)
"""Classes that a model file writes as text ``body.place``."""

SEQUENCES = (list, tuple, collections.abc.Sequence)
MAPPINGS = (dict, collections.abc.Mapping)


@dataclass(frozen=True)
class FieldSpec:
    """A field of a declaration: its name, annotation, and whether it must be given."""

    name: str
    annotation: Any
    required: bool
    default: Any = None


@dataclass(frozen=True)
class Options:
    """The alternatives of an annotation, sorted by how a model file writes them.

    Args:
        classes: declarations, written as mappings.
        places: markers and edges, written as ``body.place``.
        references: bodies, joints and other items of the system, written by their name.
        items: annotations of the items of a sequence that holds declarations or references; one for each place of a tuple.
        repeated: True when a sequence has any number of items of the one annotation in ``items``.
        values: annotation of the values of a mapping that holds declarations, references or lists of one length.
        plain: annotations of plain values.
    """

    classes: tuple[type, ...]
    places: tuple[type, ...]
    references: tuple[type, ...]
    items: tuple[Any, ...]
    repeated: bool
    values: Any
    plain: tuple[Any, ...]

    @property
    def structured(self) -> bool:
        return bool(self.classes or self.places or self.references or self.items or self.values is not None)


def concrete(base: type) -> tuple[type, ...]:
    """All declarations among ``base`` and its subclasses, in the order of modules, whichever was imported first."""
    if inspect.isabstract(base):
        import_subclasses(base)
    found = dict.fromkeys([base] if is_pydantic_dataclass(base) and not inspect.isabstract(base) else [])
    for child in sorted(base.__subclasses__(), key=lambda cls: cls.__module__):
        found |= dict.fromkeys(concrete(child))
    return tuple(found)


def in_files(cls: type) -> bool:
    """Whether a model file can hold a declaration."""
    return not getattr(cls, "python_only", False)


@cache
def field_specs(cls: type) -> dict[str, FieldSpec]:
    """The fields of a declaration that can be given, by name and in order."""
    hints = get_type_hints(cls, include_extras=True)
    specs = {}
    for field in given_fields(cls):
        default = field.default
        if field.default_factory is not MISSING:
            default = field.default_factory()
        if isinstance(default, FieldInfo):
            default = MISSING if default.is_required() else default.get_default(call_default_factory=True)
        specs[field.name] = FieldSpec(field.name, hints[field.name], default is MISSING, None if default is MISSING else default)
    return specs


@cache
def tag_of(cls: type) -> tuple[str, str]:
    """The key and value that choose a class in a model file: its field ``kind`` if that says no more, else ``type: its_name``."""
    spec = field_specs(cls).get("kind")
    if spec is not None and get_origin(spec.annotation) is Literal and len(get_args(spec.annotation)) == 1:
        return "kind", get_args(spec.annotation)[0]
    return "type", tag_of_name(cls.__name__)


def options(annotation: Any) -> Options:
    """Sort the alternatives of an annotation."""
    return _options(annotation, len(KINDS))


@cache
def _options(annotation: Any, n_kinds: int) -> Options:
    """The same, kept while there are as many declarations."""
    classes: list[type] = []
    places: list[type] = []
    references: list[type] = []
    items: tuple[Any, ...] = ()
    plain: list[Any] = []
    repeated, values = False, None
    for member in _members(annotation):
        bare = _bare(member)
        origin, inner = get_origin(bare), get_args(bare)
        if isinstance(bare, type) and bare in PLACES:
            places.append(bare)
        elif isinstance(bare, type) and origin is None and issubclass(bare, Declaration):
            references.append(bare)
        elif isinstance(bare, type) and origin is None and concrete(bare):
            classes += [cls for cls in concrete(bare) if cls not in classes and in_files(cls)]
        elif origin in SEQUENCES and any(part is not Ellipsis and options(part).structured for part in inner):
            repeated = Ellipsis in inner or origin is not tuple
            items = tuple(part for part in inner if part is not Ellipsis)
        elif origin in MAPPINGS and (options(inner[1]).structured or fixed_length(inner[1])):
            values = inner[1]
        else:
            plain.append(member)
    return Options(tuple(classes), tuple(places), tuple(references), items, repeated, values, tuple(plain))


@cache
def of_profile(annotation: Any) -> OfProfile | None:
    """Whether and how the unit of a field follows that of the profile it belongs to."""
    return next((mark for mark in getattr(annotation, "__metadata__", ()) if isinstance(mark, OfProfile)), None)


def _members(annotation: Any) -> list[Any]:
    """The members of a union, looked for through ``Annotated``."""
    bare = _bare(annotation)
    if get_origin(bare) in (Union, types.UnionType):
        return [member for part in get_args(bare) for member in _members(part)]
    return [annotation]


def same_shape(annotations: tuple[Any, ...], data: Any) -> Any:
    """The union of the plain alternatives that are lists or not, as the data is, so that messages speak of these alone."""
    alike = [a for a in annotations if (get_origin(_bare(a)) in SEQUENCES + MAPPINGS) == isinstance(data, (list, dict))]
    if data is not None:
        alike = [a for a in alike if a not in (None, types.NoneType)]
    return Union[tuple(alike or annotations)]  # noqa: UP007  # made from data


def fixed_length(annotation: Any) -> int | None:
    """The number of items of a tuple of fixed length, None for anything else."""
    bare = _bare(annotation)
    parts = get_args(bare)
    return len(parts) if get_origin(bare) is tuple and Ellipsis not in parts else None


def _bare(annotation: Any) -> Any:
    while get_origin(annotation) is Annotated:
        annotation = get_args(annotation)[0]
    return annotation
