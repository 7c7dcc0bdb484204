"""What force blocks of elements share: tables in lanes, and the map of their buffers to global coordinates."""

from __future__ import annotations

from collections.abc import Callable
from copy import copy
from functools import partial
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from lamella import threads
from lamella.element.base import ElementSpec
from lamella.element.packing import Number, n_blocks, packed, packed_indices, packed_targets, unpacked
from lamella.errors import ModelError
from lamella.lane import WIDTH
from lamella.roles import Floats, ForceBlock, Ints, TangentTables


class Range:
    """Some consecutive blocks of elements, as what a kernel is to see of each array.

    Args:
        first, end: the blocks.
        n_block: number of all.
    """

    def __init__(self, first: int, end: int, n_block: int) -> None:
        self.first, self.end, self.n_block, self.is_all = first, end, n_block, end - first == n_block
        self.known: dict[int, Any] = {}
        """Tables with what kernels see of them, by the tables' identity."""

    def of(self, array: NDArray[Number]) -> NDArray[Number]:
        """The part of a flat array, which has equally many entries for each block."""
        if self.is_all:
            return array
        size = len(array) // self.n_block
        return array[self.first * size : self.end * size]


class ElementBlock(ForceBlock):
    """A group of equal elements, packed for kernels that compute a lane of them at a time.

    Args:
        name: name of the body, for messages.
        element: the finite element, with n coordinates.
        order: place in element order of each coordinate in the order of the kernels, shape (n,).
        coords: global coordinate of each element coordinate, in element order, shape (n_element, n).
        scale: factors from global to element coordinates, l_x^px l_y^py, shape (n_element, n).
        reference: global coordinates of the stress-free configuration, shape (n_element, n).
        rows: row of each entry of the tangent buffer of an element, a coordinate in the kernels' order, shape (n_entry,).
        columns: its column.

    Raises:
        ModelError: the shapes do not agree.
    """

    def __init__(
        self,
        name: str,
        element: ElementSpec,
        order: Ints,
        coords: Ints,
        scale: Floats,
        reference: Floats,
        rows: Ints,
        columns: Ints,
    ) -> None:
        self.name, self.element, self.order, self.rows, self.columns = name, element, order, rows, columns
        if not coords.shape == scale.shape == reference.shape == (len(coords), len(order)):
            raise ModelError(
                f"{name}: element tables have shapes {coords.shape}, {scale.shape}, {reference.shape}; "
                f"each must be (n, {len(order)})"
            )
        self.rest = np.asarray(reference, float) * scale
        self._lay_out(np.asarray(coords, np.int64)[:, order], np.asarray(scale, float)[:, order])

    def _lay_out(self, coords: Ints, scale: Floats) -> None:
        """Pack coordinates and factors, in the order of the kernels."""
        self.element_scale = scale
        self.n_element, self.n_block = len(coords), n_blocks(len(coords))
        self._all, self._ranges = Range(0, self.n_block, self.n_block), {}
        self._index, self._scale = packed_indices(coords), packed(scale)
        self._targets = packed_targets(coords)
        self.f_coords, self.f_scale = self._targets, self._scale

    def _taken(self, elements: Ints, coords: Ints) -> Self:
        """A block of some of the elements, which works in the same places, with coordinates (n, n_coordinate) for them."""
        found = copy(self)
        found.rest = self.rest[elements]
        found._lay_out(coords, self.element_scale[elements])
        return found

    @property
    def n_k(self) -> int:
        """Entries of the tangent buffer."""
        return self.n_block * len(self.rows) * WIDTH

    @property
    def k_tables(self) -> TangentTables:  # pyright: ignore[reportIncompatibleVariableOverride]
        """Coordinates, factors, and which of them each entry of the tangent buffer couples."""
        return TangentTables(self._targets, self._scale, self.rows, self.columns, len(self.order))

    # Lists as long as the tangent buffer are made whenever they are asked for, and not kept: they would take three times its
    # memory.

    @property
    def k_rows(self) -> Ints:  # pyright: ignore[reportIncompatibleVariableOverride]
        """Global coordinate of the row of each entry of the tangent buffer, shape (n_k,)."""
        return self.targets_of(self.rows)

    @property
    def k_cols(self) -> Ints:  # pyright: ignore[reportIncompatibleVariableOverride]
        """The same of its column."""
        return self.targets_of(self.columns)

    @property
    def k_scale(self) -> Floats:  # pyright: ignore[reportIncompatibleVariableOverride]
        """Factor of each entry, shape (n_k,)."""
        return self.scale_of(self.rows, self.columns)

    def targets_of(self, places: Ints) -> Ints:
        """Global coordinates of rows or columns of element matrices, packed."""
        return self._of_entries(self._targets, places)

    def scale_of(self, rows: Ints, columns: Ints) -> Floats:
        """Factors of entries of element matrices, packed."""
        return self._of_entries(self._scale, rows) * self._of_entries(self._scale, columns)

    def _of_entries(self, table: NDArray[Number], places: Ints) -> NDArray[Number]:
        """Of a packed table of the element's coordinates, the numbers at some places, packed as well."""
        return table.reshape(self.n_block, len(self.order), WIDTH)[:, places].reshape(-1)

    def over_blocks(self, seconds: float, call: Callable[[Range], None]) -> None:
        """Call a kernel for all blocks of elements: at once, or in threads, each for some of them, where that is faster.

        Args:
            seconds: what the kernel takes for one element.
            call: calls it for some of the blocks.
        """
        if self.n_block * WIDTH * seconds < threads.WORTHWHILE or len(ranges := threads.cut(self.n_block, WIDTH * seconds)) == 1:
            call(self._all)  # small models are not asked more
        else:
            threads.run([partial(call, self._range(ends)) for ends in ranges])

    def _range(self, ends: tuple[int, int]) -> Range:
        """The blocks from the first to the end, with what kernels have seen of tables."""
        if ends not in self._ranges:
            self._ranges[ends] = Range(*ends, self.n_block)
        return self._ranges[ends]

    @property
    def depends_on_time_alone(self) -> bool:
        return not len(self.rows) and not self.depends_on_velocity

    def matrices(self, k: Floats) -> Floats:
        """Matrices in unscaled coordinates and element order, shape (n_element, n, n), from the buffer of a symmetric tangent."""
        values = unpacked(k * self.k_scale, self.n_element)
        rows, columns = self.order[self.rows], self.order[self.columns]
        matrices = np.empty((self.n_element, len(self.order), len(self.order)))
        matrices[:, rows, columns] = values
        matrices[:, columns, rows] = values
        return matrices
