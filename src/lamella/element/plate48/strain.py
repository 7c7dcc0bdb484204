"""Kirchhoff-Love strains at one point of a surface, with the gradient and Hessian of the strain energy.

All functions are ordinary expressions: their arguments are numbers, NumPy arrays or, in compiled kernels, lanes. A vector is a
tuple of three of them. With the derivatives g = (r_x, r_y, r_xx, r_yy, r_xy) by the parameters of the surface, the six strains

    s = (1/2 (r_x.r_x - A11), 1/2 (r_y.r_y - A22), r_x.r_y - A12,   r_xx.m - B11, r_yy.m - B22, r_xy.m - B12)

are the components of the Green-Lagrange strain and of the change of curvature. The normal m that measures curvature is the exact
unit normal n0 or, in the second definition, ``cubed``, n / |n|^3 = n0 / J^2 with n = r_x x r_y and J = |n|. With the dual vectors
d1, d2 of the surface (d_i.r_j = delta_ij, d_i.n0 = 0) and the Christoffel symbols gamma_a^i = g_a . d_i of the three second
derivatives g_a, the first variation is, for m = n0,

    ds_a = m . (dg_a - gamma_a^1 dr_x - gamma_a^2 dr_y),     dm = -d_i (m . dr_i),

so that all bending terms act along m. The energy W = 1/2 s.C s has the resultants N = C s, P = sum_a N_a g_a and

    dW/dg . dg = N_1 r_x.dr_x + ... + sum_a N_a ds_a,
    d2W/dg2    = grad s . C . grad s  +  sum_k N_k (second variation of s_k);

    second variation of the bending part: - sum_a N_a (m.dr_i)(d_i.dg_a) twice (symmetrised)
                                          + (P.d_i)(d_j.dr_i)(m.dr_j) twice - (P.m)(d_i.d_j)(m.dr_i)(m.dr_j).

The cubed normal also shrinks as the surface is stretched, dJ = J d_i.dr_i, which adds

    to dm:    - 2 m (d_i.dr_i),                             to ds_a:    - 2 (g_a.m)(d_i.dr_i),
    to the second variation, whose last term becomes -3 (P.m)(d_i.d_j)(m.dr_i)(m.dr_j) / m.m:
              - 2 (d_i.dr_i) (sum_a N_a m.dg_a - (P.d_j)(m.dr_j)) twice
              + 4 (P.m)(d_i.dr_i)(d_j.dr_j) + 2 (P.m)(d_j.dr_i)(d_i.dr_j).

Sources: Ciarlet, An Introduction to Differential Geometry (2005), sec. 2.4-2.6 (variation of the fundamental forms); the cubed
normal: Dmitrochenko and Pogorelov, Multibody Syst. Dyn. 10, 17-43 (2003); Dufva and Shabana, Proc. IMechE K 219, 345-355 (2005).
"""

from __future__ import annotations

from typing import Any, Literal

from lamella._jit import inlined
from lamella.lane import sqrt

Vector = tuple[Any, Any, Any]

Cubed = Literal[True] | None
"""True measures curvature with n / |n|^3, None with n0. A kernel is compiled for each of the two types, without the branches of
the other."""


@inlined
def dot(u: Vector, v: Vector) -> Any:
    """Scalar product."""
    return u[0] * v[0] + u[1] * v[1] + u[2] * v[2]


@inlined
def cross(u: Vector, v: Vector) -> Vector:
    """Vector product."""
    return (u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0])


@inlined
def scaled(factor: Any, u: Vector) -> Vector:
    """``factor`` u."""
    return (factor * u[0], factor * u[1], factor * u[2])


@inlined
def combined(a: Any, u: Vector, b: Any, v: Vector) -> Vector:
    """Sum a u + b v."""
    return (a * u[0] + b * v[0], a * u[1] + b * v[1], a * u[2] + b * v[2])


@inlined
def combined3(a: Any, u: Vector, b: Any, v: Vector, c: Any, w: Vector) -> Vector:
    """Sum a u + b v + c w."""
    return (a * u[0] + b * v[0] + c * w[0], a * u[1] + b * v[1] + c * w[1], a * u[2] + b * v[2] + c * w[2])


@inlined
def inner3(c0: Any, c1: Any, c2: Any, u: Vector) -> Any:
    """Sum c0 u_0 + c1 u_1 + c2 u_2."""
    return c0 * u[0] + c1 * u[1] + c2 * u[2]


@inlined
def difference(u: Vector, v: Vector) -> Vector:
    """Difference u - v."""
    return (u[0] - v[0], u[1] - v[1], u[2] - v[2])


@inlined
def surface_frame(r_x: Vector, r_y: Vector, cubed: Cubed = None) -> tuple[Vector, Vector, Vector]:
    """Normal m, which is n0 or n / |n|^3, and the dual vectors d1, d2 (d_i . r_j = delta_ij, d_i . m = 0)."""
    n = cross(r_x, r_y)
    inverse = 1.0 / sqrt(dot(n, n))
    n0 = scaled(inverse, n)
    d1, d2 = scaled(inverse, cross(r_y, n0)), scaled(inverse, cross(n0, r_x))
    if cubed is None:
        return n0, d1, d2
    return scaled(inverse * inverse, n0), d1, d2


@inlined
def normal_change(dr_x: Vector, dr_y: Vector, m: Vector, d1: Vector, d2: Vector, cubed: Cubed) -> Vector:
    """The variation dm of the normal by dr_x and dr_y."""
    tilt = combined(-dot(m, dr_x), d1, -dot(m, dr_y), d2)
    if cubed is None:
        return tilt
    return combined(1.0, tilt, -2.0 * (dot(d1, dr_x) + dot(d2, dr_y)), m)


@inlined
def strains(g: tuple[Vector, ...], m: Vector, reference: tuple[Any, ...]) -> tuple[Any, ...]:
    """The six strains s.

    Args:
        g: r_x, r_y, r_xx, r_yy, r_xy.
        m: the normal that measures curvature.
        reference: A11/2, A22/2, A12, B11, B22, B12 of the reference surface, B with the same normal.
    """
    return (
        0.5 * dot(g[0], g[0]) - reference[0],
        0.5 * dot(g[1], g[1]) - reference[1],
        dot(g[0], g[1]) - reference[2],
        dot(g[2], m) - reference[3],
        dot(g[3], m) - reference[4],
        dot(g[4], m) - reference[5],
    )


@inlined
def extrapolated_strains(
    g: tuple[Vector, ...], g_previous: tuple[Vector, ...], reference: tuple[Any, ...], cubed: Cubed
) -> tuple[Any, ...]:
    """Strains of g by linear extrapolation from g_previous: s(g_previous) + (ds/dg)(g_previous) . (g - g_previous).

    Their resultants, used in the geometric stiffness only, save Newton iterations of thin shells (mixed integration point:
    Magisano, Leonetti, Garcea, Int. J. Numer. Meth. Eng. 109, 2017). The membrane strains are quadratic: their extrapolation is
    s(g) - 1/2 dg.dg.
    """
    m, d1, d2 = surface_frame(g_previous[0], g_previous[1], cubed)
    dr_x, dr_y = difference(g[0], g_previous[0]), difference(g[1], g_previous[1])
    dm = normal_change(dr_x, dr_y, m, d1, d2, cubed)
    return (
        0.5 * (dot(g[0], g[0]) - dot(dr_x, dr_x)) - reference[0],
        0.5 * (dot(g[1], g[1]) - dot(dr_y, dr_y)) - reference[1],
        dot(g[0], g[1]) - dot(dr_x, dr_y) - reference[2],
        dot(g[2], m) + dot(g_previous[2], dm) - reference[3],
        dot(g[3], m) + dot(g_previous[3], dm) - reference[4],
        dot(g[4], m) + dot(g_previous[4], dm) - reference[5],
    )


@inlined
def resultants(c: tuple[Any, ...], s: tuple[Any, ...]) -> tuple[Any, ...]:
    """N = C s, with the 21 upper entries of the symmetric C, row by row."""
    return (
        c[0] * s[0] + c[1] * s[1] + c[2] * s[2] + c[3] * s[3] + c[4] * s[4] + c[5] * s[5],
        c[1] * s[0] + c[6] * s[1] + c[7] * s[2] + c[8] * s[3] + c[9] * s[4] + c[10] * s[5],
        c[2] * s[0] + c[7] * s[1] + c[11] * s[2] + c[12] * s[3] + c[13] * s[4] + c[14] * s[5],
        c[3] * s[0] + c[8] * s[1] + c[12] * s[2] + c[15] * s[3] + c[16] * s[4] + c[17] * s[5],
        c[4] * s[0] + c[9] * s[1] + c[13] * s[2] + c[16] * s[3] + c[18] * s[4] + c[19] * s[5],
        c[5] * s[0] + c[10] * s[1] + c[14] * s[2] + c[17] * s[3] + c[19] * s[4] + c[20] * s[5],
    )


@inlined
def energy_density(n: tuple[Any, ...], s: tuple[Any, ...]) -> Any:
    """W = 1/2 N . s."""
    return 0.5 * (n[0] * s[0] + n[1] * s[1] + n[2] * s[2] + n[3] * s[3] + n[4] * s[4] + n[5] * s[5])


@inlined
def moment_vector(g: tuple[Vector, ...], n: tuple[Any, ...]) -> Vector:
    """P = N_4 r_xx + N_5 r_yy + N_6 r_xy."""
    return (
        n[3] * g[2][0] + n[4] * g[3][0] + n[5] * g[4][0],
        n[3] * g[2][1] + n[4] * g[3][1] + n[5] * g[4][1],
        n[3] * g[2][2] + n[4] * g[3][2] + n[5] * g[4][2],
    )


@inlined
def gradient(g: tuple[Vector, ...], m: Vector, d1: Vector, d2: Vector, n: tuple[Any, ...], cubed: Cubed) -> tuple[Vector, ...]:
    """dW/dg: five vectors, the derivatives by r_x, r_y, r_xx, r_yy, r_xy."""
    p = moment_vector(g, n)
    h_x, h_y = combined(n[0], g[0], n[2], g[1]), combined(n[2], g[0], n[1], g[1])
    if cubed is not None:
        shrink = -2.0 * dot(p, m)
        h_x, h_y = combined(1.0, h_x, shrink, d1), combined(1.0, h_y, shrink, d2)
    return (
        difference(h_x, scaled(dot(p, d1), m)),
        difference(h_y, scaled(dot(p, d2), m)),
        scaled(n[3], m),
        scaled(n[4], m),
        scaled(n[5], m),
    )
