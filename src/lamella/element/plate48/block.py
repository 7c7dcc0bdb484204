"""The blocks of Plate48: strain models by name, and inertia."""

from __future__ import annotations

from lamella.element.plate48.exact import ShellBlock
from lamella.element.plate48.frame import CorotationalShellBlock, FloatingShellBlock
from lamella.element.plate48.inertia import ShellInertia
from lamella.element.plate48.linear import LinearShellBlock

__all__ = ["STRAIN_MODELS", "CorotationalShellBlock", "FloatingShellBlock", "LinearShellBlock", "ShellBlock", "ShellInertia"]

StrainModel = type[ShellBlock] | type[LinearShellBlock] | type[FloatingShellBlock] | type[CorotationalShellBlock]

STRAIN_MODELS: dict[str, StrainModel] = {
    "exact": ShellBlock,
    "linear": LinearShellBlock,
    "floating": FloatingShellBlock,
    "corotational": CorotationalShellBlock,
}
"""Strain models by the name a plate declares; all take the same arguments."""
