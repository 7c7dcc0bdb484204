"""Sums of forces that differ by the stiffness of a section alone, at the price of one of them."""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from typing import TypeVar

import numpy as np

from lamella.element.plate48.layout import KernelArguments, Plate48Block
from lamella.element.plate48.surface_kernels import N_SECTION, N_STIFFNESS
from lamella.lane import WIDTH, aligned

Block = TypeVar("Block", bound=Plate48Block)


def weighed_arguments(parts: Sequence[Sequence[KernelArguments]], weights: Sequence[float]) -> list[KernelArguments] | None:
    """The kernels' arguments for the stiffness sum w_i C_i, in which resultants and forces are linear.

    Args:
        parts: arguments of each block, for each part of its section.
        weights: of each block.

    Returns:
        The arguments for each part of the section; None where the blocks differ in elements, reference or Gauss points.
    """
    if len({len(each) for each in parts}) > 1:
        return None
    found = []
    for same in zip(*parts, strict=True):
        index, scale, sections, table, n, cubed = same[0]
        points = [each[2].reshape(-1, N_SECTION, WIDTH) for each in same]
        alike = all(
            np.array_equal(index, other[0])
            and np.array_equal(scale, other[1])
            and np.array_equal(points[0][:, N_STIFFNESS:], own[:, N_STIFFNESS:])
            and (n, cubed) == other[4:]
            for other, own in zip(same[1:], points[1:], strict=True)
        )
        if not alike:
            return None
        total = aligned(sections.size)
        numbers = total.reshape(points[0].shape)
        numbers[:] = points[0]
        numbers[:, :N_STIFFNESS] = sum(w * own[:, :N_STIFFNESS] for w, own in zip(weights, points, strict=True))
        found.append((index, scale, total, table, n, cubed))
    return found


def weighed_block(blocks: Sequence[Block], weights: Sequence[float]) -> Block | None:
    """A block with the force sum w_i f_i of blocks of the same kind; None as for :func:`weighed_arguments`."""
    arguments = weighed_arguments([each.arguments for each in blocks], weights)
    if arguments is None:
        return None
    total = copy(blocks[0])
    total.arguments = arguments
    return total
