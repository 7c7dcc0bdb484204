"""Compiled check of a factorisation of a symmetric matrix, of which the upper triangle is listed."""

from __future__ import annotations

from lamella._jit import kernel
from lamella.assembly.operator import Places
from lamella.lane import number_at
from lamella.roles import Floats, Ints
from lamella.solve.null_space_kernels import largest


@kernel
def residual(indptr: Ints, indices: Places, k: Floats, b: Floats, x: Floats, rest: Floats) -> None:
    """rest = b - K x. Rows begin with their diagonal."""
    for i in range(len(x)):
        rest[i] = b[i]
    for i in range(len(x)):
        first, mine = indptr[i], x[i]
        total = k[first] * mine
        for e in range(first + 1, indptr[i + 1]):
            j, entry = number_at(indices, e), number_at(k, e)
            total += entry * number_at(x, j)
            rest[j] -= entry * mine
        rest[i] -= total


@kernel
def backward_error(
    indptr: Ints, indices: Places, k: Floats, magnitude: Floats, b: Floats, x: Floats, rest: Floats
) -> tuple[float, int]:
    """Largest |b - K x| / (|x| + 1) of a matrix scaled to a diagonal of 1, and its row; not a number when x is not finite."""
    residual(indptr, indices, k, b, x, rest)
    error, worst, size, _ = largest(magnitude, rest, x)
    return error / (size + 1.0), worst
