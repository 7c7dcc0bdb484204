"""Where declarations are, and when their modules are imported: a model is made of a few of a hundred kinds."""

from __future__ import annotations

import importlib
import pkgutil
import re
from functools import cache
from types import ModuleType

import lamella

USERS = (
    "bench",
    "cli",
    "differentiation",
    "examples",
    "fmu",
    "io",
    "optimisation",
    "study",
    "sweep",
    "templates",
    "verification",
    "viz",
)
"""Folders that use declarations and hold none of a system."""

ANALYSES = ("lamella.io.linear_analysis", "lamella.io.static_analysis")


def tag_of_name(name: str) -> str:
    """What a model file calls a class: ``point_force`` for ``PointForce``."""
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", name).lower()


def public_class(tag: object) -> type | None:
    """The public class of this tag, of which nothing but its own module is imported; None when there is none."""
    name = _public_names().get(str(tag))
    found = getattr(lamella, name) if name else None
    return found if isinstance(found, type) else None


@cache
def _public_names() -> dict[str, str]:
    return {tag_of_name(name): name for name in lamella.__all__}


@cache
def import_subclasses(cls: type) -> None:
    """Import every module that may hold subclasses of an abstract class: those of its folder, or all for a declaration."""
    package, *path = cls.__module__.split(".")
    if package != lamella.__name__:
        return
    if len(path) < 2 or path[0] in USERS:
        import_catalogue()
    else:
        _import_all_of(importlib.import_module(f"lamella.{path[0]}"))


@cache
def import_catalogue() -> None:
    """Import every module of the folders that may hold declarations, so that their classes are known."""
    for name in ANALYSES:
        importlib.import_module(name)
    for folder in pkgutil.iter_modules(lamella.__path__, "lamella."):
        if folder.ispkg and folder.name.removeprefix("lamella.") not in USERS:
            _import_all_of(importlib.import_module(folder.name))


def _import_all_of(folder: ModuleType) -> None:
    for module in pkgutil.walk_packages(folder.__path__, f"{folder.__name__}."):
        importlib.import_module(module.name)
