"""The product of the exact tangent of elastic and viscous forces with a change x of the coordinates, without the tangent.

At a Gauss point x changes the derivatives g by y, so that with the weights alpha_q, alpha_v of coordinates and velocities, the
resultants N = C_e (s + c sdot) and the force (ds/dg)^T N

    (ds/dg)^T C_e ((alpha_q + c alpha_v) ds + alpha_q c dsdot) + alpha_q (d(ds/dg))^T N

with the changes ds = (ds/dg) y, dsdot = (dsdot/dg) y and d(ds/dg) along y. One product takes about one and a half times as long
as the force; layouts as in :mod:`lamella.element.plate48.kernels`.
"""

from __future__ import annotations

from typing import Any

from lamella._jit import inlined, shared
from lamella.element.plate48.damping_kernels import dual_rate, gather_both, strain_rates, weighted6
from lamella.element.plate48.interpolation import (
    N_SECTION,
    gather,
    interpolate_eta,
    interpolate_xi,
    reference,
    spread_eta,
    spread_xi,
    stiffness,
)
from lamella.element.plate48.strain import (
    Cubed,
    Vector,
    combined,
    combined3,
    dot,
    gradient,
    moment_vector,
    normal_change,
    resultants,
    scaled,
    strains,
    surface_frame,
)
from lamella.lane import WIDTH
from lamella.roles import Floats, Ints

Frame = tuple[Vector, Vector, Vector]
"""m, d1, d2, or their changes along y."""


@inlined
def _frame_change(y: tuple[Vector, ...], frame: Frame, cubed: Cubed) -> Frame:
    """Changes of m, d1 and d2 along y."""
    m, d1, d2 = frame
    dm = normal_change(y[0], y[1], m, d1, d2, cubed)
    normal = dm if cubed is None else scaled(1.0 / dot(m, m), dm)
    return dm, dual_rate(d1, y, d1, d2, m, normal), dual_rate(d2, y, d1, d2, m, normal)


@inlined
def _rates_change(
    g: tuple[Vector, ...], v: tuple[Vector, ...], y: tuple[Vector, ...], m_rate: Vector, frame: Frame, change: Frame, cubed: Cubed
) -> tuple[Any, ...]:
    """(dsdot/dg) y, the change of the rates of the strains along y; v = gdot."""
    (m, d1, d2), (dm, dd1, dd2) = frame, change
    tilt = combined(dot(dm, v[0]), d1, dot(dm, v[1]), d2)
    dm_rate = combined3(-dot(m, v[0]), dd1, -dot(m, v[1]), dd2, -1.0, tilt)
    if cubed is not None:
        stretch, more = dot(d1, v[0]) + dot(d2, v[1]), dot(dd1, v[0]) + dot(dd2, v[1])
        dm_rate = combined3(1.0, dm_rate, -2.0 * stretch, dm, -2.0 * more, m)
    return (
        dot(y[0], v[0]),
        dot(y[1], v[1]),
        dot(y[0], v[1]) + dot(y[1], v[0]),
        dot(v[2], dm) + dot(y[2], m_rate) + dot(g[2], dm_rate),
        dot(v[3], dm) + dot(y[3], m_rate) + dot(g[3], dm_rate),
        dot(v[4], dm) + dot(y[4], m_rate) + dot(g[4], dm_rate),
    )


@inlined
def _gradient_change(
    g: tuple[Vector, ...], y: tuple[Vector, ...], n: tuple[Any, ...], frame: Frame, change: Frame, cubed: Cubed
) -> tuple[Vector, ...]:
    """(d(ds/dg))^T N, the change of :func:`gradient` along y with the resultants as they are."""
    (m, d1, d2), (dm, dd1, dd2) = frame, change
    p, dp = moment_vector(g, n), moment_vector(y, n)
    h_x = combined3(1.0, combined(n[0], y[0], n[2], y[1]), -(dot(dp, d1) + dot(p, dd1)), m, -dot(p, d1), dm)
    h_y = combined3(1.0, combined(n[2], y[0], n[1], y[1]), -(dot(dp, d2) + dot(p, dd2)), m, -dot(p, d2), dm)
    if cubed is not None:
        shrink, more = -2.0 * dot(p, m), -2.0 * (dot(dp, m) + dot(p, dm))
        h_x, h_y = combined3(1.0, h_x, shrink, dd1, more, d1), combined3(1.0, h_y, shrink, dd2, more, d2)
    return h_x, h_y, scaled(n[3], dm), scaled(n[4], dm), scaled(n[5], dm)


@inlined
def _summed(u: tuple[Vector, ...], v: tuple[Vector, ...]) -> tuple[Vector, ...]:
    return (
        combined(1.0, u[0], 1.0, v[0]),
        combined(1.0, u[1], 1.0, v[1]),
        combined(1.0, u[2], 1.0, v[2]),
        combined(1.0, u[3], 1.0, v[3]),
        combined(1.0, u[4], 1.0, v[4]),
    )


@shared
def tangent_product(
    q: Floats,
    v: Floats,
    x: Floats,
    alpha_q: float,
    alpha_v: float,
    time: float,
    elastic: bool,
    index: Ints,
    scale: Floats,
    sections: Floats,
    table: Floats,
    n: int,
    cubed: Cubed,
    work: Floats,
    f: Floats,
) -> None:
    """(alpha_q df/dq + alpha_v df/dv) x, f (block, 48), for x in the coordinates of q.

    Of the viscous force with the retardation time c = ``time``, of the elastic one (``elastic``), or of both; v is not looked at
    when c is zero.
    """
    lines, rates, changes, sums = 48, 48 + 36 * n, 48 + 72 * n, 48 + 108 * n
    damped, weight = time != 0.0, time * alpha_v + (alpha_q if elastic else 0.0)
    for block in range(index.size // (48 * WIDTH)):
        if damped:
            gather_both(q, v, index, scale, block, table, n, work)
        else:
            gather(q, index, scale, block, work, 0)
            interpolate_eta(work, 0, lines, table, n)
        gather(x, index, scale, block, work, 0)
        interpolate_eta(work, 0, changes, table, n)
        for j in range(n):
            for i in range(n):
                g, y = interpolate_xi(work, lines, table, i, j), interpolate_xi(work, changes, table, i, j)
                frame = surface_frame(g[0], g[1], cubed)
                m, d1, d2 = frame
                change = _frame_change(y, frame, cubed)
                at = ((block * n + j) * n + i) * N_SECTION
                c = stiffness(sections, at)
                ds = strain_rates(g, y, m, change[0])
                ds = weighted6(weight, ds, 0.0, ds)
                if elastic:
                    s = strains(g, m, reference(sections, at))
                    s = weighted6(alpha_q, s, 0.0, s)
                else:
                    s = weighted6(0.0, ds, 0.0, ds)
                if damped:
                    g_rate = interpolate_xi(work, rates, table, i, j)
                    m_rate = normal_change(g_rate[0], g_rate[1], m, d1, d2, cubed)
                    s = weighted6(1.0, s, alpha_q * time, strain_rates(g, g_rate, m, m_rate))
                    rates_change = _rates_change(g, g_rate, y, m_rate, frame, change, cubed)
                    ds = weighted6(1.0, ds, alpha_q * time, rates_change)
                h = gradient(g, m, d1, d2, resultants(c, ds), cubed)
                h = _summed(h, _gradient_change(g, y, resultants(c, s), frame, change, cubed))
                spread_xi(h, work, sums + j * 36, table, i, i == 0)
        spread_eta(work, sums, table, n, f, block * 48)
