"""What the cubed normal m = n / |n|^3 adds to the Hessian of :mod:`lamella.element.plate48.hessian`.

With b_a = g_a . m, its bending strains vary by m . dg_a - (gamma_a^i m + 2 b_a d_i) . dr_i. In the blocks of two second
derivatives nothing is new; those of r_i with a second derivative take terms in d_i that pair with m, and those of r_i with r_j
also dyads with d_1 and d_2:

    r_x r_x:  e1 d1 + d1 e1,     r_x r_y:  e1 d2 + d1 e2 + 2 q (d2 d1 - d1 d2),     r_y r_y:  e2 d2 + d2 e2

    e1 = (2 b.C b + 3 q) d1 - 2 (C_1 . b) r_x - 2 (C_3 . b) r_y,     e2 = (2 b.C b + 3 q) d2 - 2 (C_3 . b) r_x - 2 (C_2 . b) r_y

with q = P . m, the rows C_1, C_2, C_3 of the coupling of membrane and bending, and the bending stiffness in b . C b.
"""

from __future__ import annotations

from typing import Any

from lamella._jit import inlined
from lamella.element.plate48.strain import Vector, combined, combined3, dot, inner3, moment_vector
from lamella.lane import load, store
from lamella.roles import Floats


@inlined
def _along(g: tuple[Vector, ...], u: Vector) -> Vector:
    """Scalar products of the three second derivatives with u."""
    return (dot(g[2], u), dot(g[3], u), dot(g[4], u))


@inlined
def _bent(c: tuple[Any, ...], b: Vector) -> Vector:
    """The bending stiffness times b."""
    return (inner3(c[15], c[16], c[17], b), inner3(c[16], c[18], c[19], b), inner3(c[17], c[19], c[20], b))


@inlined
def stretched_factors(
    factors: tuple[Vector, ...],
    g: tuple[Vector, ...],
    m: Vector,
    d1: Vector,
    d2: Vector,
    c: tuple[Any, ...],
    n: tuple[Any, ...],
) -> tuple[Vector, ...]:
    """The factors of the Hessian with the terms that pair with m; the other arguments are those of ``hessian_factors``."""
    p, x = moment_vector(g, n), _bent(c, _along(g, m))
    q = -0.5 * dot(p, m) * (3.0 / dot(m, m) - 1.0)
    a1, a2 = 2.0 * (dot(p, d1) + dot(x, _along(g, d1))), 2.0 * (dot(p, d2) + dot(x, _along(g, d2)))
    w12 = q * dot(d1, d2)
    f = factors
    return (
        f[0], f[1], f[2], f[3], f[4], f[5], f[6], f[7], f[8], f[9],
        combined3(1.0, f[10], a1, d1, q * dot(d1, d1), m),
        combined3(1.0, f[11], a2, d1, w12, m),
        combined3(1.0, f[12], a1, d2, w12, m),
        combined3(1.0, f[13], a2, d2, q * dot(d2, d2), m),
        combined(1.0, f[14], -2.0 * (x[0] + n[3]), d1),
        combined(1.0, f[15], -2.0 * (x[1] + n[4]), d1),
        combined(1.0, f[16], -2.0 * (x[2] + n[5]), d1),
        combined(1.0, f[17], -2.0 * (x[0] + n[3]), d2),
        combined(1.0, f[18], -2.0 * (x[1] + n[4]), d2),
        combined(1.0, f[19], -2.0 * (x[2] + n[5]), d2),
        f[20], f[21], f[22],
    )  # fmt: skip


@inlined
def _add(array: Floats, at: int, value: Any) -> None:
    store(array, at, load(array, at) + value)


@inlined
def _add_pair(work: Floats, at: int, d1: Vector, d2: Vector, e1: Vector, e2: Vector, q: Any, u: int, v: int) -> None:
    """Add the dyads with d1 and d2 to the blocks of r_x and r_y for the components (u, v)."""
    _add(work, at, e1[u] * d1[v] + d1[u] * e1[v])
    _add(work, at + 1, e1[u] * d2[v] + d1[u] * e2[v] + 2.0 * q * (d2[u] * d1[v] - d1[u] * d2[v]))
    _add(work, at + 5, d2[u] * e1[v] + e2[u] * d1[v] + 2.0 * q * (d1[u] * d2[v] - d2[u] * d1[v]))
    _add(work, at + 6, e2[u] * d2[v] + d2[u] * e2[v])


@inlined
def add_stretch(
    work: Floats, at: int, step: int, g: Any, m: Vector, d1: Vector, d2: Vector, c: tuple[Any, ...], n: tuple[Any, ...]
) -> None:
    """Add the dyads with d1 and d2 to a stored Hessian, whose groups have the order of ``store_hessian``."""
    b, q = _along(g, m), dot(moment_vector(g, n), m)
    z1, z2, z3 = inner3(c[3], c[4], c[5], b), inner3(c[8], c[9], c[10], b), inner3(c[12], c[13], c[14], b)
    own = 2.0 * dot(b, _bent(c, b)) + 3.0 * q
    e1 = combined3(own, d1, -2.0 * z1, g[0], -2.0 * z3, g[1])
    e2 = combined3(own, d2, -2.0 * z3, g[0], -2.0 * z2, g[1])
    _add_pair(work, at, d1, d2, e1, e2, q, 0, 0)
    _add_pair(work, at + step, d1, d2, e1, e2, q, 0, 1)
    _add_pair(work, at + 2 * step, d1, d2, e1, e2, q, 0, 2)
    _add_pair(work, at + 3 * step, d1, d2, e1, e2, q, 1, 1)
    _add_pair(work, at + 4 * step, d1, d2, e1, e2, q, 1, 2)
    _add_pair(work, at + 5 * step, d1, d2, e1, e2, q, 2, 2)
