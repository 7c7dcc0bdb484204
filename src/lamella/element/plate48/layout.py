"""What all force blocks of Plate48 share: element tables for the kernels, and the constants of the Gauss points."""

from __future__ import annotations

from typing import get_args

import numpy as np

from lamella.element.block import ElementBlock, Range
from lamella.element.packing import packed
from lamella.element.plate48.section import Curvature, Section
from lamella.element.plate48.shape import PLATE48, gauss_points, hermite_table, product_order, shape_at_gauss_points
from lamella.element.plate48.strain import Cubed
from lamella.element.plate48.surface import derivatives_at_points, reference_surface
from lamella.errors import ModelError
from lamella.roles import Floats, Ints, MatrixFreeBlock

UPPER = np.triu_indices(6)
KernelArguments = tuple[Ints, Floats, Floats, Floats, int, Cubed]


def seen(arguments: KernelArguments, blocks: Range) -> KernelArguments:
    """The arguments for some blocks of elements."""
    if blocks.is_all:
        return arguments
    index, scale, sections, table, n, cubed = arguments
    return blocks.of(index), blocks.of(scale), blocks.of(sections), table, n, cubed


class Plate48Block(ElementBlock, MatrixFreeBlock):  # pyright: ignore[reportIncompatibleVariableOverride]
    """Element tables of a group of Plate48 elements, packed for the kernels.

    Args:
        name: name of the body, for messages.
        coords: global coordinate of each element coordinate, in element order, shape (n_element, 48).
        scale: factors from global to element coordinates, l_x^px l_y^py, shape (n_element, 48).
        reference: global coordinates of the stress-free configuration, shape (n_element, 48).
        rows: row (a, b, component) of each entry of the tangent buffer of an element, shape (n_entry,).
        columns: its column.

    Raises:
        ModelError: the shapes do not agree.
    """

    def __init__(self, name: str, coords: Ints, scale: Floats, reference: Floats, rows: Ints, columns: Ints) -> None:
        super().__init__(name, PLATE48, product_order(), coords, scale, reference, rows, columns)

    def kernel_arguments(self, tables: list[GaussTables]) -> list[KernelArguments]:
        """Index, scale, sections, table, number of points and normal for each part of the section."""
        return [(self._index, self._scale, part.sections, part.table, part.n, part.cubed) for part in tables]


class GaussTables:
    """Constants of the Gauss points for the kernels.

    Args:
        block: the elements.
        section: the section; its ``membrane_gauss`` is not regarded.
        n_gauss: points in each direction.

    Raises:
        ModelError: the reference surface has no area.
    """

    def __init__(self, block: Plate48Block, section: Section, n_gauss: int) -> None:
        weights = gauss_points(n_gauss)[2]
        at_points = derivatives_at_points(shape_at_gauss_points(PLATE48, n_gauss), block.rest)
        surface = reference_surface(block.name, at_points, section.direction)
        self.cubed: Cubed = section.cubed
        self.transform = surface.strain_transform(self.cubed)
        factor = (weights * surface.area)[..., None, None]
        self.stiffness = self.transform.swapaxes(-1, -2) @ section.by_element @ self.transform * factor
        constants = surface.constants(self.cubed)
        if section.prestrain is not None:  # the strains of the kernels are counted from a reference that is shorter by it
            constants[..., :3] -= np.linalg.solve(surface.transform, section.prestrain[:, None])[..., 0]
        self.sections = packed(np.concatenate([self.stiffness[..., *UPPER], constants], axis=-1))
        self.table, self.n = hermite_table(n_gauss), n_gauss


def gauss_tables(block: Plate48Block, section: Section | Floats, n_gauss: int) -> list[GaussTables]:
    """The tables of the section's parts: of all of it, or of bending and of the in-plane forces.

    Args:
        block: the elements.
        section: the section, or its stiffness alone, shape (6, 6) or (n_element, 6, 6).
        n_gauss: points in each direction, but for ``section.membrane_gauss``.

    Raises:
        ModelError: the stiffness has a wrong shape, is not symmetric or cannot be split, the number of points or the definition
            of curvature is unknown, or the reference surface has no area.
    """
    section, name = Section.of(section), block.name
    stiffness, fewer = section.stiffness, section.membrane_gauss
    if stiffness.shape not in ((6, 6), (block.n_element, 6, 6)):
        raise ModelError(f"{name}: stiffness has shape {stiffness.shape}; accepted is (6, 6) or ({block.n_element}, 6, 6)")
    if not np.allclose(stiffness, stiffness.swapaxes(-1, -2), rtol=1e-9, atol=1e-12 * np.abs(stiffness).max()):
        raise ModelError(f"{name}: the section stiffness is not symmetric")
    if section.curvature not in get_args(Curvature):
        raise ModelError(f"{name}: curvature = '{section.curvature}'; accepted is {' or '.join(get_args(Curvature))}")
    if not 2 <= n_gauss <= 10:
        raise ModelError(f"{name}: n_gauss = {n_gauss}; accepted is 2 to 10 Gauss points in each direction")
    if fewer is not None and not 3 <= fewer <= n_gauss:
        raise ModelError(
            f"{name}: membrane_gauss = {fewer} with n_gauss = {n_gauss}; accepted is 3 to n_gauss: with two points in each "
            "direction some motions in the plane have no stiffness, and more than n_gauss would not be a reduced rule"
        )
    try:
        parts = section.parts(n_gauss)
    except np.linalg.LinAlgError as error:
        raise ModelError(f"{name}: the membrane stiffness A is singular, which membrane_gauss = {fewer} cannot split") from error
    return [GaussTables(block, part, n) for part, n in parts]
