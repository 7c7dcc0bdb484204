"""The blocks of Plate36 by the name of the strain model."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from lamella.element.models import ShellModels
from lamella.element.plate36.condensed import CondensedDamped, CondensedDamping, CondensedShell
from lamella.element.plate36.shape import Plate36
from lamella.element.plate48.frame import CorotationalShellBlock, FloatingShellBlock
from lamella.element.plate48.linear import LinearShellBlock
from lamella.roles import ForceBlock

STRAIN_MODELS: dict[str, Callable[..., ForceBlock]] = {
    "exact": CondensedShell,
    "linear": partial(LinearShellBlock, exact=CondensedShell),
    "floating": partial(FloatingShellBlock, exact=CondensedShell),
    "corotational": partial(CorotationalShellBlock, exact=CondensedShell),
}
"""Strain models by the name a plate declares; all take the same arguments."""

SHELL = ShellModels(Plate36(), STRAIN_MODELS, CondensedDamping, CondensedDamped, {})
"""All of them together."""
