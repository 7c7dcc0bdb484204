"""What all force blocks of Plate48 share: element tables for the kernels, and the constants of the Gauss points."""

from __future__ import annotations

from functools import cached_property
from typing import ClassVar, Self, get_args

import numpy as np

from lamella.element.block import ElementBlock, Range
from lamella.element.packing import packed, unpacked
from lamella.element.plate48.section import Curvature, Section
from lamella.element.plate48.shape import PLATE48, gauss_points, hermite_table, product_order, shape_at_gauss_points
from lamella.element.plate48.strain import Cubed
from lamella.element.plate48.surface import derivatives_at_points, reference_surface
from lamella.element.plate48.surface_kernels import N_SECTION, pack_sections
from lamella.errors import ModelError
from lamella.lane import WIDTH, aligned
from lamella.numbering import Numbering
from lamella.roles import Bools, Floats, Ints, MatrixFreeBlock

KernelArguments = tuple[Ints, Floats, Floats, Floats, int, Cubed]


def seen(arguments: KernelArguments, blocks: Range) -> KernelArguments:
    """The arguments for some blocks of elements."""
    if blocks.is_all:
        return arguments
    if id(arguments) not in blocks.known:
        index, scale, sections, table, n, cubed = arguments
        part = blocks.of(index), blocks.of(scale), sections_of(sections, n, blocks), table, n, cubed
        blocks.known[id(arguments)] = arguments, part  # which keeps the arguments, so that no others get their identity
    return blocks.known[id(arguments)][1]


def sections_of(sections: Floats, n: int, blocks: Range) -> Floats:
    """The constants of n x n Gauss points that some blocks of elements read: all there are where these are of one block."""
    return sections if len(sections) == n * n * N_SECTION * WIDTH else blocks.of(sections)


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

    arguments: list[KernelArguments]
    """Of the kernels, for each part of the section."""
    same_sections: ClassVar[bool] = True
    """Whether elements that are alike read the same constants; not where these change with the temperature."""

    def acting_on(self, coordinates: Bools, numbering: Numbering | None) -> Self | None:
        """As the role says: the elements that have one of the coordinates."""
        coords = unpacked(self._index, self.n_element)
        elements = np.flatnonzero(coordinates[coords].any(axis=1))
        own = coords[elements]
        return self._taken(elements, numbering.coordinates(own) if numbering else own)

    def repeated(self, n: int, n_q: int) -> Self | None:
        """As the role says."""
        coords = unpacked(self._index, self.n_element)
        first = n_q * np.repeat(np.arange(n), self.n_element)
        return self._taken(np.tile(np.arange(self.n_element), n), np.tile(coords, (n, 1)) + first[:, None])

    def _taken(self, elements: Ints, coords: Ints) -> Self:
        found = super()._taken(elements, coords)
        found.arguments = []
        for _, _, sections, table, n, cubed in self.arguments:
            shared = len(sections) == n * n * N_SECTION * WIDTH
            own = sections if shared else packed(unpacked(sections, self.n_element)[elements])
            found.arguments.append((found._index, found._scale, own, table, n, cubed))
        found._make_buffers()
        return found

    def _make_buffers(self) -> None:
        """Make the arrays that depend on the number of elements."""

    def kernel_arguments(self, tables: list[GaussTables]) -> list[KernelArguments]:
        """Index, scale, sections, table, number of points and normal for each part of the section."""
        return [(self._index, self._scale, part.sections, part.table, part.n, part.cubed) for part in tables]


class GaussTables:
    """Constants of the Gauss points for the kernels: of each element, or of one block where all are alike.

    Args:
        block: the elements.
        section: the section; its ``membrane_gauss`` is not regarded.
        n_gauss: points in each direction.

    Raises:
        ModelError: the reference surface has no area.
    """

    def __init__(self, block: Plate48Block, section: Section, n_gauss: int) -> None:
        stiffness = section.stiffness.reshape(-1, 6, 6)
        may_share = block.same_sections and len(stiffness) == 1
        rest = block.rest[:1] if may_share and block.element.repeats(block.rest) else block.rest
        at_points = derivatives_at_points(shape_at_gauss_points(PLATE48, n_gauss), rest)
        self._surface = surface = reference_surface(block.name, at_points, section.direction)
        self.cubed: Cubed = section.cubed
        self._section, self._factor = section, gauss_points(n_gauss)[2] * surface.area
        constants = surface.constants(self.cubed)
        if section.prestrain is not None:  # the strains of the kernels are counted from a reference that is shorter by it
            constants[..., :3] -= np.linalg.solve(surface.transform, section.prestrain[:, None])[..., 0]
        bending = np.ones_like(surface.area) if self.cubed is None else surface.area**2
        tables = surface.transform, stiffness, self._factor, bending, constants
        alike = may_share and surface.repeats
        if alike:
            tables = surface.transform[:1], stiffness, self._factor[:1], bending[:1], constants[:1]
        n_block = 1 if alike else block.n_block
        self.sections = aligned(n_block * WIDTH * n_gauss**2 * N_SECTION)
        pack_sections(*tables, np.empty((3, 3)), self.sections)
        self.table, self.n = hermite_table(n_gauss), n_gauss

    @cached_property
    def transform(self) -> Floats:
        """From the kernels' strains to those of the section, shape (n_element, n_point, 6, 6), or (1, ...) of elements alike."""
        return self._surface.strain_transform(self.cubed)

    @property
    def stiffness(self) -> Floats:
        """Stiffness for the kernels' strains, times weight and area, in the same shape."""
        T = self.transform
        return T.swapaxes(-1, -2) @ self._section.by_element @ T * self._factor[..., None, None]


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
    size = np.abs(stiffness)
    if not np.all(np.abs(stiffness - stiffness.swapaxes(-1, -2)) <= 1e-9 * size + 1e-12 * size.max()):
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
