"""Matrices of three rows, tuples of vectors, for compiled kernels; entries are numbers or lanes."""

from __future__ import annotations

from typing import Any

from lamella._jit import inlined
from lamella.element.plate48.strain import Vector, combined, combined3, dot, scaled

Matrix = tuple[Vector, Vector, Vector]


@inlined
def dyad(factor: Any, u: Vector, v: Vector) -> Matrix:
    """``factor`` u v^T."""
    return (scaled(factor * u[0], v), scaled(factor * u[1], v), scaled(factor * u[2], v))


@inlined
def with_dyad(A: Matrix, u: Vector, v: Vector) -> Matrix:
    """A + u v^T."""
    return (combined(1.0, A[0], u[0], v), combined(1.0, A[1], u[1], v), combined(1.0, A[2], u[2], v))


@inlined
def with_unit(factor: Any, A: Matrix) -> Matrix:
    """A + ``factor`` 1."""
    return (
        (A[0][0] + factor, A[0][1], A[0][2]),
        (A[1][0], A[1][1] + factor, A[1][2]),
        (A[2][0], A[2][1], A[2][2] + factor),
    )


@inlined
def multiple(factor: Any, A: Matrix) -> Matrix:
    """``factor`` A."""
    return (scaled(factor, A[0]), scaled(factor, A[1]), scaled(factor, A[2]))


@inlined
def summed(a: Any, A: Matrix, b: Any, B: Matrix) -> Matrix:
    """a A + b B."""
    return (combined(a, A[0], b, B[0]), combined(a, A[1], b, B[1]), combined(a, A[2], b, B[2]))


@inlined
def summed3(a: Any, A: Matrix, b: Any, B: Matrix, c: Any, C: Matrix) -> Matrix:
    """a A + b B + c C."""
    return (
        combined3(a, A[0], b, B[0], c, C[0]),
        combined3(a, A[1], b, B[1], c, C[1]),
        combined3(a, A[2], b, B[2], c, C[2]),
    )


@inlined
def added(A: Matrix, B: Matrix) -> Matrix:
    """A + B."""
    return summed(1.0, A, 1.0, B)


@inlined
def transposed(A: Matrix) -> Matrix:
    """A^T."""
    return ((A[0][0], A[1][0], A[2][0]), (A[0][1], A[1][1], A[2][1]), (A[0][2], A[1][2], A[2][2]))


@inlined
def times(A: Matrix, u: Vector) -> Vector:
    """A u."""
    return (dot(A[0], u), dot(A[1], u), dot(A[2], u))


@inlined
def onto(u: Vector, A: Matrix) -> Vector:
    """u^T A."""
    return combined3(u[0], A[0], u[1], A[1], u[2], A[2])


@inlined
def product(A: Matrix, B: Matrix) -> Matrix:
    """A B."""
    return (onto(A[0], B), onto(A[1], B), onto(A[2], B))
