"""Contact force at one point of a sheet, and its exact change.

The obstacle is fixed in a body with the vectors p, d_1, d_2, d_3. With its centre c = p + b_i d_i, its axis a = alpha_i d_i and
y = s - c for the point s of the sheet, the depth delta = -g(y, a) gives the normal force N and the forces f = f_int - f_ext

    F = k A delta^e (1 + alpha delta') >= 0,    f_y = -F m,    f_a = -F g_a,    N = F |m|

(Hunt and Crossley 1975), the gradient of the energy k A delta^(e+1) / (e + 1) where alpha = 0. Friction acts between the point
and the point of the body that is there, Y_i = d_i.y, with the slip v = y' - Y_i d_i' and T = 1 - m m^T / m.m:

    regularised   tau = mu N u / sqrt(u.u + v_d^2),             u = T v
    bristle       tau = u min(1, mu N / |u|),                   u = A T (k_t (y - X_i d_i) + c_t v)

where the bristle is a spring from the point to the place X_i of the body to which it holds. It turns with the body, so that a
sheet that rolls without slip does not stretch it. All forces, with h = f_y + tau:

    on s: h,    on p: -h,    on d_i: -b_i h + alpha_i f_a - Y_i tau

tau does the work tau.v, so force, torque and energy of sheet and body balance exactly.
"""

from __future__ import annotations

from typing import NamedTuple

from lamella._jit import inlined
from lamella.contact.gap import Gap, Obstacle, gap, gap_change
from lamella.element.plate48.strain import Vector, combined, combined3, dot, scaled
from lamella.lane import sqrt

Axes = tuple[Vector, Vector, Vector]


class Law(NamedTuple):
    """The law of contact as the kernels read it.

    Args:
        stiffness: k [N/m^(2 + e)].
        exponent: e.
        damping: alpha [s/m].
        mu: coefficient of friction.
        bristle: whether friction is that of bristles.
        velocity: v_d [m/s].
        tangential: k_t [N/m^3].
        viscous: c_t [N s/m^3].
    """

    stiffness: float
    exponent: float
    damping: float
    mu: float
    bristle: bool
    velocity: float
    tangential: float
    viscous: float


class Relative(NamedTuple):
    """A point of the sheet as seen from the obstacle.

    Args:
        y, yd: from the centre to the point [m], and its rate.
        a, ad: axis, and its rate.
        D, Dd: axes of the body, and their rates.
        X: where the bristle holds, in the axes of the body [m].
        held: 1.0 if it holds anywhere, else 0.0.
    """

    y: Vector
    yd: Vector
    a: Vector
    ad: Vector
    D: Axes
    Dd: Axes
    X: Vector
    held: float


class Force(NamedTuple):
    """Contact at a point.

    Args:
        at: the gap.
        F, F_delta, F_rate: normal law, and its derivatives by depth and rate of depth.
        elastic: F without damping [N].
        size: |m|.
        unit: m / |m|.
        Y: the point in the axes of the body [m].
        slip: T v [m/s].
        u: what friction follows.
        u0: u before the projection.
        norm: the root in the law of friction.
        phi: tau = phi u.
        slides: whether phi depends on the state.
        tau, h, f_a: forces [N].
    """

    at: Gap
    F: float
    F_delta: float
    F_rate: float
    elastic: float
    size: float
    unit: Vector
    Y: Vector
    slip: Vector
    u: Vector
    u0: Vector
    norm: float
    phi: float
    slides: bool
    tau: Vector
    h: Vector
    f_a: Vector


@inlined
def weighted(c: Vector, D: Axes) -> Vector:
    """sum_i c_i D_i."""
    return combined3(c[0], D[0], c[1], D[1], c[2], D[2])


@inlined
def components(D: Axes, y: Vector) -> Vector:
    """D_i . y."""
    return (dot(D[0], y), dot(D[1], y), dot(D[2], y))


@inlined
def tangential(unit: Vector, u: Vector) -> Vector:
    """The part of u normal to ``unit``."""
    return combined(1.0, u, -dot(unit, u), unit)


@inlined
def contact(obstacle: Obstacle, law: Law, reach: float, area: float, rel: Relative) -> Force:
    """Contact at a point whose depth is positive."""
    at = gap(obstacle, reach, rel.y, rel.a)
    depth, rate = -at.g, -(dot(at.m, rel.yd) + dot(at.g_a, rel.ad))
    stiff = law.stiffness * area * depth ** (law.exponent - 1.0)
    growth = max(1.0 + law.damping * rate, 0.0)
    F = stiff * depth * growth
    F_rate = stiff * depth * law.damping if growth > 0.0 else 0.0
    size = sqrt(dot(at.m, at.m))
    unit = scaled(1.0 / size, at.m)
    Y = components(rel.D, rel.y)
    v = combined(1.0, rel.yd, -1.0, weighted(Y, rel.Dd))
    u0 = v
    if law.bristle:
        stretch = combined(1.0, rel.y, -1.0, weighted(rel.X, rel.D))
        u0 = combined(area * law.tangential * rel.held, stretch, area * law.viscous, v)
    u = tangential(unit, u0)
    norm = sqrt(dot(u, u) + law.velocity**2)
    limit = law.mu * F * size
    slides = not law.bristle or norm > limit
    phi = limit / norm if slides else 1.0
    tau = scaled(phi, u)
    h = combined(-F, at.m, 1.0, tau)
    slip = tangential(unit, v)
    F_delta = law.exponent * stiff * growth
    return Force(at, F, F_delta, F_rate, stiff * depth, size, unit, Y, slip, u, u0, norm, phi, slides, tau, h, scaled(-F, at.g_a))


@inlined
def contact_change(
    obstacle: Obstacle, law: Law, area: float, rel: Relative, c: Force,
    dy: Vector, dyd: Vector, da: Vector, dad: Vector, dD: Axes, dDd: Axes,
) -> tuple[Vector, Vector, Vector, Vector]:  # fmt: skip
    """Changes of h, f_a, tau and Y with those of the point and the body."""
    at = c.at
    dg, dm, dg_a = gap_change(obstacle, at, rel.a, dy, da)
    drate = dot(dm, rel.yd) + dot(at.m, dyd) + dot(dg_a, rel.ad) + dot(at.g_a, dad)
    dF = -c.F_delta * dg - c.F_rate * drate
    dh = combined(-1.0, scaled(dF, at.m), -c.F, dm)
    df_a = combined(-1.0, scaled(dF, at.g_a), -c.F, dg_a)
    dY = components(dD, rel.y)
    dY = (dY[0] + dot(rel.D[0], dy), dY[1] + dot(rel.D[1], dy), dY[2] + dot(rel.D[2], dy))
    dv = combined(1.0, dyd, -1.0, weighted(dY, rel.Dd))
    dv = combined(1.0, dv, -1.0, weighted(c.Y, dDd))
    du0 = dv
    if law.bristle:
        dstretch = combined(1.0, dy, -1.0, weighted(rel.X, dD))
        du0 = combined(area * law.tangential * rel.held, dstretch, area * law.viscous, dv)
    dsize = dot(c.unit, dm)
    dunit = scaled(1.0 / c.size, combined(1.0, dm, -1.0, scaled(dsize, c.unit)))
    turned = dot(dunit, c.u0) + dot(c.unit, du0)
    du = combined3(1.0, du0, -dot(c.unit, c.u0), dunit, -1.0, scaled(turned, c.unit))
    dtau = scaled(c.phi, du)
    if c.slides:
        dlimit = law.mu * (c.size * dF + c.F * dsize)
        dphi = (dlimit - c.phi / c.norm * dot(c.u, du)) / c.norm
        dtau = combined(1.0, dtau, 1.0, scaled(dphi, c.u))
    return combined(1.0, dh, 1.0, dtau), df_a, dtau, dY
