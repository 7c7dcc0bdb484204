"""Derivatives of the contact force at points, in closed form, a lane of points at a time.

All vary with the point s and the axes d_i of the obstacle's body; with its place p as with -s. With the second derivatives of the
gap, matrices such as

    h_y = -m F_y^T - F g_yy + tau_y,     h_a = -m F_a^T - F g_ya + tau_a,     f_a,y = -g_a F_y^T - F g_ya^T, ...

say how forces vary with y and with a; y = s - p - b_i d_i and a = alpha_i d_i. Friction, of which phi = limit / root, varies as

    d tau = G d u_0 - phi (q dn + n (u.dn)) + q w (u.dn) + u d limit / root,      n = m / |m|,  q = n.u_0,
    G = phi (1 - n n^T) - w u^T,  w = phi u / root^2

and u_0 depends on d_i also by itself, through the place in the body, Y_i = d_i.y, and the end of the bristle, X_i d_i. Rates vary
along with what they are rates of: the weights alpha_q, alpha_v are part of all matrices.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from lamella._jit import inlined
from lamella.contact.gap import Obstacle, hessian
from lamella.contact.matrices import (
    Matrix,
    added,
    dyad,
    multiple,
    onto,
    product,
    summed,
    summed3,
    times,
    transposed,
    with_dyad,
    with_unit,
)
from lamella.contact.point import Force, Law, Relative
from lamella.element.plate48.strain import Vector, combined, combined3, dot, scaled
from lamella.lane import store_at
from lamella.roles import Floats


class Changes(NamedTuple):
    """Derivatives by y and a of h, f_a and tau. By itself d_i changes tau by -``seen`` G Dd_i y^T - ``own``_i G."""

    h_y: Matrix
    h_a: Matrix
    f_y: Matrix
    f_a: Matrix
    tau_y: Matrix
    tau_a: Matrix
    G: Matrix
    seen: Any
    own: Vector


@inlined
def _turned(c: Force, w: Vector, M: Matrix) -> Matrix:
    """Change of tau with that of the normal, for the change M of m."""
    q, along, across = dot(c.unit, c.u0), onto(c.unit, M), onto(c.u, M)
    A = multiple(-c.phi * q, with_dyad(M, scaled(-1.0, c.unit), along))
    A = with_dyad(A, scaled(-c.phi, c.unit), across)
    return multiple(1.0 / c.size, with_dyad(A, scaled(q, w), across))


@inlined
def changes_by_place(obstacle: Obstacle, law: Law, rel: Relative, c: Force, alpha_q: float, alpha_v: float) -> Changes:
    """The matrices at points."""
    m, g_a = c.at.m, c.at.g_a
    yy, ya, aa = hessian(obstacle, c.at, rel.a)
    yy, ya, aa = multiple(alpha_q, yy), multiple(alpha_q, ya), multiple(alpha_q, aa)
    rate_y = combined3(-1.0, times(yy, rel.yd), -1.0, times(ya, rel.ad), -alpha_v, m)
    rate_a = combined3(-1.0, onto(rel.yd, ya), -1.0, times(aa, rel.ad), -alpha_v, g_a)
    F_y, F_a = combined(-alpha_q * c.F_delta, m, c.F_rate, rate_y), combined(-alpha_q * c.F_delta, g_a, c.F_rate, rate_a)
    minus, minus_g = scaled(-1.0, m), scaled(-1.0, g_a)
    h_y, h_a = with_dyad(multiple(-c.F, yy), minus, F_y), with_dyad(multiple(-c.F, ya), minus, F_a)
    f_y, f_a = with_dyad(multiple(-c.F, transposed(ya)), minus_g, F_y), with_dyad(multiple(-c.F, aa), minus_g, F_a)
    w = scaled(c.phi * c.over * c.over, c.u)
    G = with_unit(c.phi, with_dyad(dyad(-1.0, w, c.u), scaled(-c.phi, c.unit), c.unit))
    # u_0 along y: c_v (alpha_v 1 - alpha_q Dd_i D_i^T) + c_s alpha_q 1
    moved = added(added(dyad(1.0, rel.Dd[0], rel.D[0]), dyad(1.0, rel.Dd[1], rel.D[1])), dyad(1.0, rel.Dd[2], rel.D[2]))
    tau_y = summed(c.c_v * alpha_v + c.c_s * alpha_q, G, -alpha_q * c.c_v, product(G, moved))
    tau_y, tau_a = added(tau_y, _turned(c, w, yy)), _turned(c, w, ya)
    share = scaled(law.mu * c.over, c.u)
    tau_y = with_dyad(tau_y, share, combined(c.size, F_y, c.F, onto(c.unit, yy)))
    tau_a = with_dyad(tau_a, share, combined(c.size, F_a, c.F, onto(c.unit, ya)))
    own = combined(c.c_v * alpha_v, c.Y, c.c_s * alpha_q, rel.X)
    return Changes(added(h_y, tau_y), added(h_a, tau_a), f_y, f_a, tau_y, tau_a, G, alpha_q * c.c_v, own)


@inlined
def _store_row(work: Floats, at: int, step: int, u: Vector) -> None:
    store_at(work, at, u[0])
    store_at(work, at + step, u[1])
    store_at(work, at + 2 * step, u[2])


@inlined
def _store(work: Floats, at: int, step: int, A: Matrix) -> None:
    _store_row(work, at, step, A[0])
    _store_row(work, at + 12 * step, step, A[1])
    _store_row(work, at + 24 * step, step, A[2])


@inlined
def _store_turned(
    obstacle: Obstacle, rel: Relative, c: Force, alpha_q: float, i: int, k: int,
    h: Matrix, f: Matrix, tau: Matrix, work: Floats, at: int, step: int,
) -> None:  # fmt: skip
    """The change along d_i of the force -b_k h + alpha_k f_a - Y_k tau on d_k."""
    A = summed3(-obstacle.centre[k], h, obstacle.axis[k], f, -c.Y[k], tau)
    Y = combined(-alpha_q * obstacle.centre[i], rel.D[k], alpha_q if i == k else 0.0, rel.y)
    _store(work, at + (36 * (k + 1) + 3 * (i + 1)) * step, step, with_dyad(A, scaled(-1.0, c.tau), Y))


@inlined
def _store_along(
    obstacle: Obstacle, rel: Relative, c: Force, d: Changes, alpha_q: float, i: int, work: Floats, at: int, step: int
) -> None:
    """All changes along d_i."""
    b, alpha = obstacle.centre[i], obstacle.axis[i]
    direct = with_dyad(multiple(-d.own[i], d.G), scaled(-d.seen, times(d.G, rel.Dd[i])), rel.y)
    h = added(summed(-b, d.h_y, alpha, d.h_a), direct)
    f = summed(-b, d.f_y, alpha, d.f_a)
    tau = added(summed(-b, d.tau_y, alpha, d.tau_a), direct)
    _store(work, at + 3 * (i + 1) * step, step, h)
    _store_turned(obstacle, rel, c, alpha_q, i, 0, h, f, tau, work, at, step)
    _store_turned(obstacle, rel, c, alpha_q, i, 1, h, f, tau, work, at, step)
    _store_turned(obstacle, rel, c, alpha_q, i, 2, h, f, tau, work, at, step)


@inlined
def _store_axis(
    obstacle: Obstacle, rel: Relative, c: Force, d: Changes, alpha_q: float, k: int, work: Floats, at: int, step: int
) -> None:
    """The change along s of the force on d_k."""
    A = summed3(-obstacle.centre[k], d.h_y, obstacle.axis[k], d.f_y, -c.Y[k], d.tau_y)
    _store(work, at + 36 * (k + 1) * step, step, with_dyad(A, scaled(-alpha_q, c.tau), rel.D[k]))


@inlined
def store_changes(
    obstacle: Obstacle, law: Law, rel: Relative, c: Force, alpha_q: float, alpha_v: float, work: Floats, at: int, step: int
) -> None:
    """Derivatives of (h, forces on d_1, d_2, d_3) by (s, d_1, d_2, d_3), (12, 12), to work[at:], ``step`` apart.

    Where the body does not move, those of h by s alone.
    """
    d = changes_by_place(obstacle, law, rel, c, alpha_q, alpha_v)
    _store(work, at, step, d.h_y)
    if obstacle.moves:
        _store_axis(obstacle, rel, c, d, alpha_q, 0, work, at, step)
        _store_axis(obstacle, rel, c, d, alpha_q, 1, work, at, step)
        _store_axis(obstacle, rel, c, d, alpha_q, 2, work, at, step)
        _store_along(obstacle, rel, c, d, alpha_q, 0, work, at, step)
        _store_along(obstacle, rel, c, d, alpha_q, 1, work, at, step)
        _store_along(obstacle, rel, c, d, alpha_q, 2, work, at, step)
