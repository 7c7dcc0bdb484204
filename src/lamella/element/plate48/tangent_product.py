"""The product of the exact tangent of elastic and viscous forces with a change x of the coordinates, without the tangent.

At a Gauss point x changes the derivatives g by y, so that with the weights alpha_q, alpha_v of coordinates and velocities, the
resultants N = C_e (s + c sdot) and the force (ds/dg)^T N

    (ds/dg)^T C_e ((alpha_q + c alpha_v) ds + alpha_q c dsdot) + alpha_q (d(ds/dg))^T N

with the changes ds = (ds/dg) y, dsdot = (dsdot/dg) y and d(ds/dg) along y. What does not depend on x is evaluated once for all
products at a point of the motion: g and N, and for viscous forces gdot with mdot. The frame of the surface is evaluated anew from
g, as that takes no longer than to read it. A product takes little longer than the force; layouts as in
:mod:`lamella.element.plate48.kernels`.
"""

from __future__ import annotations

from typing import Any

from lamella._jit import inlined, shared
from lamella.element.plate48.damping_kernels import dual_rate, gather_both, strain_rates, weighted6
from lamella.element.plate48.interpolation import (
    constants_at,
    gather,
    interpolate_eta,
    interpolate_xi,
    reference,
    spread_eta,
    spread_xi,
    stiffness,
    three,
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
from lamella.lane import WIDTH, store
from lamella.roles import Floats, Ints

Frame = tuple[Vector, Vector, Vector]
"""m, d1, d2, or their changes along y."""
Time = float | None
"""Retardation time [s]; kernels are compiled apart for those without."""


@inlined
def frame_change(y: tuple[Vector, ...], frame: Frame, cubed: Cubed) -> Frame:
    """Changes of m, d1 and d2 along y."""
    m, d1, d2 = frame
    dm = normal_change(y[0], y[1], m, d1, d2, cubed)
    normal = dm if cubed is None else scaled(1.0 / dot(m, m), dm)
    return dm, dual_rate(d1, y, d1, d2, m, normal), dual_rate(d2, y, d1, d2, m, normal)


@inlined
def rates_change(
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
def gradient_change(
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
def summed(u: tuple[Vector, ...], v: tuple[Vector, ...]) -> tuple[Vector, ...]:
    """u + v of five vectors."""
    return (
        combined(1.0, u[0], 1.0, v[0]),
        combined(1.0, u[1], 1.0, v[1]),
        combined(1.0, u[2], 1.0, v[2]),
        combined(1.0, u[3], 1.0, v[3]),
        combined(1.0, u[4], 1.0, v[4]),
    )


@inlined
def _keep(points: Floats, at: int, u: Vector) -> None:
    store(points, at, u[0])
    store(points, at + 1, u[1])
    store(points, at + 2, u[2])


@inlined
def _keep5(points: Floats, at: int, g: tuple[Vector, ...]) -> None:
    _keep(points, at, g[0])
    _keep(points, at + 3, g[1])
    _keep(points, at + 6, g[2])
    _keep(points, at + 9, g[3])
    _keep(points, at + 12, g[4])


@inlined
def _kept5(points: Floats, at: int) -> Any:
    return three(points, at), three(points, at + 3), three(points, at + 6), three(points, at + 9), three(points, at + 12)


@shared
def tangent_points(
    q: Floats,
    v: Floats,
    alpha_q: float,
    time: Time,
    elastic: bool,
    index: Ints,
    scale: Floats,
    sections: Floats,
    table: Floats,
    n: int,
    cubed: Cubed,
    work: Floats,
    points: Floats,
) -> None:
    """What all products at (q, v) need, in ``point_size(time)`` lanes of ``points`` for each Gauss point.

    These are g and alpha_q N, and where there is a retardation time c = ``time``, gdot and mdot.
    """
    lines, rates, size = 48, 48 + 36 * n, point_size(time)
    for block in range(index.size // (48 * WIDTH)):
        if time is None:
            gather(q, index, scale, block, work, 0)
            interpolate_eta(work, 0, lines, table, n)
        else:
            gather_both(q, v, index, scale, block, table, n, work)
        for j in range(n):
            for i in range(n):
                g = interpolate_xi(work, lines, table, i, j)
                m, d1, d2 = surface_frame(g[0], g[1], cubed)
                at, to = constants_at(sections, block, n, i, j), ((block * n + j) * n + i) * size
                s = strains(g, m, reference(sections, at))
                s = weighted6(alpha_q if elastic else 0.0, s, 0.0, s)
                if time is not None:
                    g_rate = interpolate_xi(work, rates, table, i, j)
                    m_rate = normal_change(g_rate[0], g_rate[1], m, d1, d2, cubed)
                    s = weighted6(1.0, s, alpha_q * time, strain_rates(g, g_rate, m, m_rate))
                    keep_rates(points, to, g_rate, m_rate)
                keep_point(points, to, g, resultants(stiffness(sections, at), s))


@inlined
def keep_point(points: Floats, at: int, g: tuple[Vector, ...], resultant: tuple[Any, ...]) -> None:
    """Keep g and alpha_q N of a Gauss point."""
    _keep5(points, at, g)
    _keep(points, at + 15, (resultant[0], resultant[1], resultant[2]))
    _keep(points, at + 18, (resultant[3], resultant[4], resultant[5]))


@inlined
def keep_rates(points: Floats, at: int, g_rate: tuple[Vector, ...], m_rate: Vector) -> None:
    """Keep gdot and mdot."""
    _keep5(points, at + 21, g_rate)
    _keep(points, at + 36, m_rate)


@inlined
def point_size(time: Time) -> int:
    """Lanes kept of a Gauss point."""
    return 21 if time is None else 39


@shared
def tangent_product(
    x: Floats,
    alpha_q: float,
    alpha_v: float,
    time: Time,
    elastic: bool,
    index: Ints,
    scale: Floats,
    sections: Floats,
    table: Floats,
    n: int,
    cubed: Cubed,
    work: Floats,
    points: Floats,
    f: Floats,
) -> None:
    """(alpha_q df/dq + alpha_v df/dv) x, f (block, 48), for x in all coordinates, where :func:`tangent_points` has looked.

    Of the viscous force with the retardation time c = ``time``, of the elastic one (``elastic``), or of both.
    """
    lines, sums, size, weight = 48, 48 + 36 * n, point_size(time), alpha_q if elastic else 0.0
    if time is not None:
        weight += time * alpha_v
    for block in range(index.size // (48 * WIDTH)):
        gather(x, index, scale, block, work, 0)
        interpolate_eta(work, 0, lines, table, n)
        for j in range(n):
            for i in range(n):
                y = interpolate_xi(work, lines, table, i, j)
                at, kept = constants_at(sections, block, n, i, j), ((block * n + j) * n + i) * size
                g = _kept5(points, kept)
                m, d1, d2 = frame = surface_frame(g[0], g[1], cubed)
                change = frame_change(y, frame, cubed)
                ds = strain_rates(g, y, m, change[0])
                ds = weighted6(weight, ds, 0.0, ds)
                if time is not None:
                    g_rate, m_rate = _kept5(points, kept + 21), three(points, kept + 36)
                    of_rates = rates_change(g, g_rate, y, m_rate, frame, change, cubed)
                    ds = weighted6(1.0, ds, alpha_q * time, of_rates)
                h = gradient(g, m, d1, d2, resultants(stiffness(sections, at), ds), cubed)
                resultant = three(points, kept + 15) + three(points, kept + 18)
                h = summed(h, gradient_change(g, y, resultant, frame, change, cubed))
                spread_xi(h, work, sums + j * 36, table, i, i == 0)
        spread_eta(work, sums, table, n, f, block * 48)
