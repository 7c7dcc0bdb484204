"""The blocks of Plate48: strain models by name, and inertia."""

from __future__ import annotations

from lamella.element.plate48.exact import ShellBlock
from lamella.element.plate48.inertia import ShellInertia
from lamella.element.plate48.linear import LinearShellBlock

__all__ = ["STRAIN_MODELS", "LinearShellBlock", "ShellBlock", "ShellInertia"]

STRAIN_MODELS: dict[str, type[ShellBlock] | type[LinearShellBlock]] = {"exact": ShellBlock, "linear": LinearShellBlock}
"""Strain models by the name a plate declares; all take the same arguments."""
