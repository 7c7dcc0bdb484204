"""Second derivative of the strain energy at one point of a surface, see :mod:`lamella.element.plate48.strain`.

The 15 x 15 matrix consists of 5 x 5 blocks of 3 x 3, one for each pair of r_x, r_y, r_xx, r_yy, r_xy. Each block is a sum of few
dyads, so 23 vectors hold all of it: :func:`hessian_factors` computes them, :func:`hessian_entries` multiplies two of their
components out. What the cubed normal adds is in :mod:`lamella.element.plate48.hessian_cubed`.
"""

from __future__ import annotations

from typing import Any

from lamella._jit import inlined
from lamella.element.plate48.hessian_cubed import add_stretch, stretched_factors
from lamella.element.plate48.strain import Cubed, Vector, combined, combined3, dot, inner3, moment_vector, scaled
from lamella.lane import load, store
from lamella.roles import Floats


@inlined
def hessian_factors(
    g: tuple[Vector, ...], m: Vector, d1: Vector, d2: Vector, c: tuple[Any, ...], n: tuple[Any, ...]
) -> tuple[Vector, ...]:
    """The vectors whose dyads make up the Hessian.

    Args:
        g: r_x, r_y, r_xx, r_yy, r_xy.
        m: the normal that measures curvature.
        d1: first dual vector.
        d2: second dual vector.
        c: 21 upper entries of the stiffness C.
        n: the six resultants of the geometric part.

    Returns:
        r_x, r_y, m, d1, d2, five products of C with r_x and r_y, four vectors that pair with m in the blocks of r_x, r_y, six
        that do so in the blocks of these with second derivatives, and N_4 m, N_5 m, N_6 m.
    """
    p = moment_vector(g, n)
    gamma1, gamma2 = (dot(g[2], d1), dot(g[3], d1), dot(g[4], d1)), (dot(g[2], d2), dot(g[3], d2), dot(g[4], d2))
    # rows of the coupling (membrane m, bending a) and bending stiffness times the Christoffel symbols
    z11, z12 = inner3(c[3], c[4], c[5], gamma1), inner3(c[3], c[4], c[5], gamma2)
    z21, z22 = inner3(c[8], c[9], c[10], gamma1), inner3(c[8], c[9], c[10], gamma2)
    z31, z32 = inner3(c[12], c[13], c[14], gamma1), inner3(c[12], c[13], c[14], gamma2)
    x1 = (inner3(c[15], c[16], c[17], gamma1), inner3(c[16], c[18], c[19], gamma1), inner3(c[17], c[19], c[20], gamma1))
    x2 = (inner3(c[15], c[16], c[17], gamma2), inner3(c[16], c[18], c[19], gamma2), inner3(c[17], c[19], c[20], gamma2))
    q, p1, p2 = dot(p, m), dot(p, d1), dot(p, d2)
    w11 = 0.5 * (dot(x1, gamma1) - q * dot(d1, d1))
    w12 = 0.5 * (dot(x1, gamma2) - q * dot(d1, d2))
    w22 = 0.5 * (dot(x2, gamma2) - q * dot(d2, d2))
    l11 = combined3(p1, d1, w11, m, -1.0, combined(z11, g[0], z31, g[1]))
    l12 = combined3(p1, d2, w12, m, -1.0, combined(z12, g[0], z32, g[1]))
    l21 = combined3(p2, d1, w12, m, -1.0, combined(z31, g[0], z21, g[1]))
    l22 = combined3(p2, d2, w22, m, -1.0, combined(z32, g[0], z22, g[1]))
    return (
        g[0],
        g[1],
        m,
        d1,
        d2,
        combined(c[0], g[0], c[2], g[1]),
        combined(c[2], g[0], c[11], g[1]),
        combined(c[7], g[0], c[6], g[1]),
        combined(c[11], g[0], c[7], g[1]),
        combined(c[2], g[0], c[1], g[1]),
        l11,
        l12,
        l21,
        l22,
        combined3(c[3], g[0], c[12], g[1], -x1[0], m),
        combined3(c[4], g[0], c[13], g[1], -x1[1], m),
        combined3(c[5], g[0], c[14], g[1], -x1[2], m),
        combined3(c[12], g[0], c[8], g[1], -x2[0], m),
        combined3(c[13], g[0], c[9], g[1], -x2[1], m),
        combined3(c[14], g[0], c[10], g[1], -x2[2], m),
        scaled(n[3], m),
        scaled(n[4], m),
        scaled(n[5], m),
    )


@inlined
def component(vectors: tuple[Vector, ...], k: int) -> tuple[Any, ...]:
    """Component k of the 23 vectors of :func:`hessian_factors`."""
    v = vectors
    return (
        v[0][k], v[1][k], v[2][k], v[3][k], v[4][k], v[5][k], v[6][k], v[7][k], v[8][k], v[9][k], v[10][k], v[11][k],
        v[12][k], v[13][k], v[14][k], v[15][k], v[16][k], v[17][k], v[18][k], v[19][k], v[20][k], v[21][k], v[22][k],
    )  # fmt: skip


@inlined
def hessian_entries(u: tuple[Any, ...], v: tuple[Any, ...], c: tuple[Any, ...]) -> tuple[Any, ...]:
    """The 25 entries of the Hessian for one pair of components, without the multiples of the unit matrix.

    Args:
        u: component of the first (row) vector, from :func:`component`.
        v: component of the second (column) vector.
        c: 21 upper entries of the stiffness.

    Returns:
        d2W / d(g_i)_u d(g_j)_v at position 5 i + j, with g = r_x, r_y, r_xx, r_yy, r_xy.
    """
    nn = u[2] * v[2]
    e33, e34, e35, e44, e45, e55 = c[15] * nn, c[16] * nn, c[17] * nn, c[18] * nn, c[19] * nn, c[20] * nn
    return (
        u[0] * v[5] + u[1] * v[6] + u[10] * v[2] + u[2] * v[10],
        u[0] * v[9] + u[1] * v[8] + u[11] * v[2] + u[2] * v[12],
        u[14] * v[2] - u[20] * v[3],
        u[15] * v[2] - u[21] * v[3],
        u[16] * v[2] - u[22] * v[3],
        u[9] * v[0] + u[8] * v[1] + u[2] * v[11] + u[12] * v[2],
        u[1] * v[7] + u[0] * v[8] + u[13] * v[2] + u[2] * v[13],
        u[17] * v[2] - u[20] * v[4],
        u[18] * v[2] - u[21] * v[4],
        u[19] * v[2] - u[22] * v[4],
        u[2] * v[14] - u[3] * v[20],
        u[2] * v[17] - u[4] * v[20],
        e33,
        e34,
        e35,
        u[2] * v[15] - u[3] * v[21],
        u[2] * v[18] - u[4] * v[21],
        e34,
        e44,
        e45,
        u[2] * v[16] - u[3] * v[22],
        u[2] * v[19] - u[4] * v[22],
        e35,
        e45,
        e55,
    )  # fmt: skip


@inlined
def store25(array: Floats, at: int, h: Any) -> None:
    """Store 25 lanes."""
    store(array, at, h[0])
    store(array, at + 1, h[1])
    store(array, at + 2, h[2])
    store(array, at + 3, h[3])
    store(array, at + 4, h[4])
    store(array, at + 5, h[5])
    store(array, at + 6, h[6])
    store(array, at + 7, h[7])
    store(array, at + 8, h[8])
    store(array, at + 9, h[9])
    store(array, at + 10, h[10])
    store(array, at + 11, h[11])
    store(array, at + 12, h[12])
    store(array, at + 13, h[13])
    store(array, at + 14, h[14])
    store(array, at + 15, h[15])
    store(array, at + 16, h[16])
    store(array, at + 17, h[17])
    store(array, at + 18, h[18])
    store(array, at + 19, h[19])
    store(array, at + 20, h[20])
    store(array, at + 21, h[21])
    store(array, at + 22, h[22])
    store(array, at + 23, h[23])
    store(array, at + 24, h[24])


@inlined
def store_diagonal(array: Floats, at: int, u: Any, c: Any, n: Any) -> None:
    """Store the Hessian of a component with itself, which has the multiples of the unit matrix."""
    store25(array, at, hessian_entries(u, u, c))
    store(array, at, load(array, at) + n[0])
    store(array, at + 1, load(array, at + 1) + n[2])
    store(array, at + 5, load(array, at + 5) + n[2])
    store(array, at + 6, load(array, at + 6) + n[1])


@inlined
def store_hessian(
    work: Floats, at: int, step: int, g: Any, m: Vector, d1: Vector, d2: Vector, c: Any, n: Any, cubed: Cubed
) -> None:
    """Store the Hessian of a Gauss point, one group of 25 for each pair of components xx, xy, xz, yy, yz, zz.

    The arguments are those of :func:`hessian_factors`.
    """
    factors = hessian_factors(g, m, d1, d2, c, n)
    if cubed is not None:
        factors = stretched_factors(factors, g, m, d1, d2, c, n)
    x, y, z = component(factors, 0), component(factors, 1), component(factors, 2)
    store_diagonal(work, at, x, c, n)
    store25(work, at + step, hessian_entries(x, y, c))
    store25(work, at + 2 * step, hessian_entries(x, z, c))
    store_diagonal(work, at + 3 * step, y, c, n)
    store25(work, at + 4 * step, hessian_entries(y, z, c))
    store_diagonal(work, at + 5 * step, z, c, n)
    if cubed is not None:
        add_stretch(work, at, step, g, m, d1, d2, c, n)
