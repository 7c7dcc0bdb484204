"""Products with the tangents of Plate48 blocks whose strains are exact, without the tangents."""

from __future__ import annotations

from collections.abc import Sequence

from lamella.element.block import ElementBlock, Range
from lamella.element.plate48.layout import KernelArguments, seen
from lamella.element.plate48.tangent_product import Time, point_size, tangent_points, tangent_product
from lamella.lane import WIDTH, aligned
from lamella.roles import Floats, TangentOperator
from lamella.threads import Workspace

POINT, PRODUCT = 50e-9, 50e-9
"""Seconds that it takes to look at a Gauss point of an element, and for a product there."""


class ShellTangent(TangentOperator):
    """The tangent of the elastic or viscous force of elements, or of both.

    Args:
        block: the elements.
        arguments: of the kernels, for each part of the section.
        work: of the kernels.
        time: retardation time c of the viscous force [s], if there is one.
        elastic: whether there is the elastic force.
    """

    def __init__(
        self, block: ElementBlock, arguments: Sequence[KernelArguments], work: Workspace, time: Time = None, elastic: bool = True
    ) -> None:
        self._over_blocks, self._work, self._time, self._elastic = block.over_blocks, work, time, elastic
        lanes = block.n_block * point_size(time) * WIDTH
        self._parts = [(each, aligned(lanes * each[4] ** 2)) for each in arguments]
        self._product = aligned(block.f_coords.size if len(self._parts) > 1 else 0)
        self._weights = 0.0, 0.0

    @property
    def points(self) -> list[Floats]:
        """What is kept of the Gauss points, for each part of the section."""
        return [points for _, points in self._parts]

    def weigh(self, alpha_q: float, alpha_v: float) -> None:
        """Weights of what has been looked at."""
        self._weights = alpha_q, alpha_v

    def look(self, t: float, q: Floats, v: Floats, alpha_q: float, alpha_v: float) -> None:
        """Evaluate what all products at a point need."""
        self._weights = alpha_q, alpha_v
        for arguments, points in self._parts:
            self._look(arguments, points, q, v)

    def _look(self, arguments: KernelArguments, points: Floats, q: Floats, v: Floats) -> None:
        how = self._weights[0], self._time, self._elastic

        def call(blocks: Range) -> None:
            tangent_points(q, v, *how, *seen(arguments, blocks), self._work.array, blocks.of(points))

        self._over_blocks(POINT * arguments[4] ** 2, call)

    def multiply(self, x: Floats, f: Floats) -> None:
        """The product with the exact tangent."""
        first, *others = self._parts
        self._multiply(*first, x, f)
        for part in others:
            self._multiply(*part, x, self._product)
            f += self._product

    def _multiply(self, arguments: KernelArguments, points: Floats, x: Floats, f: Floats) -> None:
        how = *self._weights, self._time, self._elastic

        def call(blocks: Range) -> None:
            tangent_product(x, *how, *seen(arguments, blocks), self._work.array, blocks.of(points), blocks.of(f))

        self._over_blocks(PRODUCT * arguments[4] ** 2, call)
