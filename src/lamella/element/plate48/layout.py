"""What all force blocks of Plate48 share: element tables for the kernels, and the constants of the Gauss points."""

from __future__ import annotations

import numpy as np

from lamella.element.block import ElementBlock
from lamella.element.packing import packed
from lamella.element.plate48.section import Section
from lamella.element.plate48.shape import Plate48, gauss_points, hermite_table, product_order
from lamella.element.plate48.surface import derivatives_at_points, reference_surface, strain_transform_6
from lamella.errors import ModelError
from lamella.roles import Floats, Ints


class Plate48Block(ElementBlock):
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
        super().__init__(name, Plate48(), product_order(), coords, scale, reference, rows, columns)


class GaussTables:
    """Constants of the Gauss points for the kernels.

    Args:
        block: the elements.
        section: the section, or its stiffness alone, shape (6, 6) or (n_element, 6, 6).
        n_gauss: points in each direction.

    Raises:
        ModelError: the stiffness has a wrong shape or is not symmetric, or the reference surface has no area.
    """

    def __init__(self, block: Plate48Block, section: Section | Floats, n_gauss: int) -> None:
        section = Section.of(section)
        stiffness = section.stiffness
        if stiffness.shape not in ((6, 6), (block.n_element, 6, 6)):
            raise ModelError(
                f"{block.name}: stiffness has shape {stiffness.shape}; accepted is (6, 6) or ({block.n_element}, 6, 6)"
            )
        if not np.allclose(stiffness, stiffness.swapaxes(-1, -2), rtol=1e-9, atol=1e-12 * np.abs(stiffness).max()):
            raise ModelError(f"{block.name}: the section stiffness is not symmetric")
        if not 2 <= n_gauss <= 10:
            raise ModelError(f"{block.name}: n_gauss = {n_gauss}; accepted is 2 to 10 Gauss points in each direction")
        xi, eta, weights = gauss_points(n_gauss)
        surface = reference_surface(block.name, derivatives_at_points(Plate48().shape(xi, eta), block.rest), section.direction)
        transform = strain_transform_6(surface.transform)
        at_points = transform.swapaxes(-1, -2) @ section.by_element @ transform * (weights * surface.area)[..., None, None]
        upper = np.triu_indices(6)
        halved = surface.first * np.array([0.5, 0.5, 1.0])
        if section.prestrain is not None:  # the strains of the kernels are counted from a reference that is shorter by it
            halved = halved - np.linalg.solve(surface.transform, section.prestrain[:, None])[..., 0]
        self.sections = packed(np.concatenate([at_points[..., upper[0], upper[1]], halved, surface.second], axis=-1))
        self.table, self.n = hermite_table(n_gauss), n_gauss
