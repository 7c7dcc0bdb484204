"""Element arrays in lanes, as the kernels read them: (block, entry, WIDTH), the last block filled up."""

from __future__ import annotations

from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from lamella.lane import WIDTH, aligned
from lamella.roles import Floats, Ints

Number = TypeVar("Number", bound=np.generic)


def n_blocks(n_element: int) -> int:
    """Blocks of ``WIDTH`` that hold ``n_element`` elements."""
    return -(-n_element // WIDTH)


def _grouped(values: np.ndarray) -> np.ndarray:
    """(block WIDTH, ...) to (block, ..., WIDTH)."""
    return np.moveaxis(values.reshape(-1, WIDTH, *values.shape[1:]), 1, -1)


def packed(values: Floats) -> Floats:
    """Numbers of elements, shape (n_element, ...), for the kernels; the last element is repeated. Flat and aligned."""
    missing = n_blocks(len(values)) * WIDTH - len(values)
    full = _grouped(np.concatenate([values, np.repeat(values[-1:], missing, axis=0)]))
    out = aligned(full.size)
    out[:] = full.reshape(-1)
    return out


def packed_indices(indices: Ints) -> Ints:
    """As :func:`packed` for indices that the kernels read: the last element is repeated. Flat."""
    missing = n_blocks(len(indices)) * WIDTH - len(indices)
    return np.ascontiguousarray(_grouped(np.concatenate([indices, np.repeat(indices[-1:], missing, axis=0)]))).reshape(-1)


def packed_targets(coords: Ints) -> Ints:
    """As :func:`packed` for coordinates that the assembly reads: -1 for elements that only fill up. Flat."""
    missing = n_blocks(len(coords)) * WIDTH - len(coords)
    filler = np.full((missing, *coords.shape[1:]), -1, np.int64)
    return np.ascontiguousarray(_grouped(np.concatenate([coords, filler]))).reshape(-1)


def unpacked(values: NDArray[Number], n_element: int) -> NDArray[Number]:
    """Back from the kernels' layout to (n_element, entry)."""
    blocks = n_blocks(n_element)
    return values.reshape(blocks, -1, WIDTH).transpose(0, 2, 1).reshape(blocks * WIDTH, -1)[:n_element]
