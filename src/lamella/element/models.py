"""The blocks that an element has, by the name of the strain model."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from lamella.element.base import ElementSpec
from lamella.element.plate48.damping_small import small_damping
from lamella.element.plate48.frame import FrameShellBlock
from lamella.element.plate48.frame_groups import FramePlace
from lamella.element.plate48.inertia import ShellInertia
from lamella.element.plate48.linear import LinearShellBlock
from lamella.element.plate48.section import Section
from lamella.roles import Floats, ForceBlock, Ints

Tables = tuple[Ints, Floats, Floats]
"""Global coordinates, scale and reference of each element, each of shape (n_element, n_coordinate)."""


@dataclass(frozen=True)
class ShellModels:
    """What a shell of one finite element is made of.

    Args:
        element: the finite element.
        strain_models: blocks by the name of the strain model; all take the arguments of :class:`ShellBlock`.
        viscous: Kelvin-Voigt damping on exact strains, with the arguments of :class:`KelvinVoigtBlock`.
        damped: both the exact strain model and this damping, with the same arguments.
        heated: for each elastic block, how it is given temperatures; empty where the element has no such form.
    """

    element: ElementSpec
    strain_models: Mapping[str, Callable[..., ForceBlock]]
    viscous: Callable[..., ForceBlock]
    damped: Callable[..., ForceBlock]
    heated: Mapping[type[ForceBlock], Callable[..., tuple[ForceBlock, ...]]]

    def elastic(
        self, strain: str, name: str, tables: Tables, section: Section | Floats, n_gauss: int, frame_at: FramePlace = "mean"
    ) -> ForceBlock:
        """The elastic block of a strain model; ``frame_at`` is heeded by ``floating`` alone."""
        place: dict[str, Any] = {"frame_at": frame_at} if strain == "floating" else {}
        return self.strain_models[strain](name, *tables, section, n_gauss, **place)

    def shell(
        self, strain: str, name: str, tables: Tables, section: Section | Floats, n_gauss: int, frame_at: FramePlace, time: float
    ) -> list[ForceBlock]:
        """The elastic block and Kelvin-Voigt damping on its strains by the retardation time [s], in one block where possible."""
        if strain == "exact" and time > 0.0:
            return [self.damped(name, *tables, section, time, n_gauss)]
        elastic = self.elastic(strain, name, tables, section, n_gauss, frame_at)
        if isinstance(elastic, LinearShellBlock | FrameShellBlock) and time > 0.0:
            return [elastic, small_damping(elastic, time)]
        return [elastic]

    def inertia(self, name: str, tables: Tables, mass_per_area: float | Floats) -> ShellInertia:
        """The consistent mass matrix."""
        return ShellInertia(name, *tables, mass_per_area, element=self.element)
