"""The blocks of Plate48: strain models by name, their heated forms, and inertia."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from lamella.element.models import ShellModels
from lamella.element.plate48.damping import DampedShellBlock, KelvinVoigtBlock
from lamella.element.plate48.exact import ShellBlock
from lamella.element.plate48.frame import CorotationalShellBlock, FloatingShellBlock, FrameShellBlock
from lamella.element.plate48.heated import ThermalCouplingBlock
from lamella.element.plate48.heated_small import FrameHeatBlock, HeatedFrameBlock, LinearHeatBlock, group_heat
from lamella.element.plate48.inertia import ShellInertia
from lamella.element.plate48.linear import LinearShellBlock
from lamella.element.plate48.shape import PLATE48
from lamella.element.plate48.thermal_matrices import HeatedElements
from lamella.roles import ForceBlock

__all__ = [
    "HEATED",
    "SHELL",
    "STRAIN_MODELS",
    "CorotationalShellBlock",
    "FloatingShellBlock",
    "HeatedElements",
    "LinearShellBlock",
    "ShellBlock",
    "ShellInertia",
]

StrainModel = type[ShellBlock] | type[LinearShellBlock] | type[FloatingShellBlock] | type[CorotationalShellBlock]

STRAIN_MODELS: dict[str, StrainModel] = {
    "exact": ShellBlock,
    "linear": LinearShellBlock,
    "floating": FloatingShellBlock,
    "corotational": CorotationalShellBlock,
}
"""Strain models by the name a plate declares; all take the same arguments."""

HeatedBlocks = tuple[ForceBlock, ...]
"""The block that takes the place of an elastic one, and what is added to it."""


def _heated_exact(block: ForceBlock, elements: HeatedElements) -> HeatedBlocks:
    shell = elements.shell()
    return shell, ThermalCouplingBlock(block.name, shell, elements.coords)


def _heated_damped(block: DampedShellBlock, elements: HeatedElements) -> HeatedBlocks:
    own = elements.name, elements.coords, elements.scale, elements.reference, elements.section
    return *_heated_exact(block, elements), KelvinVoigtBlock(*own, block.time, elements.n_gauss)


def _heated_linear(block: LinearShellBlock, elements: HeatedElements) -> HeatedBlocks:
    return block, LinearHeatBlock(elements)


def _heated_in_frames(block: FrameShellBlock, elements: HeatedElements) -> HeatedBlocks:
    shell = HeatedFrameBlock(block.name, block.groups, group_heat(elements, block.groups))
    return shell, FrameHeatBlock(shell)


HEATED: dict[type[ForceBlock], Callable[[Any, HeatedElements], HeatedBlocks]] = {
    ShellBlock: _heated_exact,
    DampedShellBlock: _heated_damped,
    LinearShellBlock: _heated_linear,
    FloatingShellBlock: _heated_in_frames,
    CorotationalShellBlock: _heated_in_frames,
}
"""For each strain model, how its block is given temperatures."""

SHELL = ShellModels(PLATE48, STRAIN_MODELS, KelvinVoigtBlock, DampedShellBlock, HEATED)
"""All of them together."""
