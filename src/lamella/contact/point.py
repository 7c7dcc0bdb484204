"""Contact force at a point of a sheet, or at a lane of points.

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

from typing import Any, NamedTuple

from lamella._jit import inlined
from lamella.contact.gap import Gap, positive
from lamella.element.plate48.strain import Vector, combined, combined3, dot, scaled
from lamella.lane import chosen, power, sqrt

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
    held: Any


class Force(NamedTuple):
    """Contact at a point; all forces vanish where its area is zero.

    Args:
        at: the gap.
        F, F_delta, F_rate: normal law, and its derivatives by depth and rate of depth.
        elastic: F without damping [N].
        rate: of depth [m/s].
        size: |m|.
        unit: m / |m|.
        Y: the point in the axes of the body [m].
        slip: T v [m/s].
        u: what friction follows, T u0.
        u0: c_v v + c_s (y - X_i d_i).
        c_v, c_s: its factors.
        phi: tau = phi u.
        over: 1 / root in the law of friction where phi depends on the state, else 0.
        tau, h, f_a: forces [N].
    """

    at: Gap
    F: Any
    F_delta: Any
    F_rate: Any
    elastic: Any
    rate: Any
    size: Any
    unit: Vector
    Y: Vector
    slip: Vector
    u: Vector
    u0: Vector
    c_v: Any
    c_s: Any
    phi: Any
    over: Any
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
def contact(law: Law, at: Gap, area: Any, rel: Relative) -> Force:
    """Contact at a point with this gap; an area of zero where it does not touch."""
    depth, rate = positive(-at.g), -(dot(at.m, rel.yd) + dot(at.g_a, rel.ad))
    root = sqrt(depth) if law.exponent == 1.5 else power(depth, law.exponent - 1.0)
    stiff = law.stiffness * area * root
    growth = positive(1.0 + law.damping * rate)
    elastic = stiff * depth
    F = elastic * growth
    F_rate = chosen(growth, law.damping * elastic, 0.0 * elastic)
    size = sqrt(dot(at.m, at.m))
    unit = scaled(1.0 / size, at.m)
    Y = components(rel.D, rel.y)
    v = combined(1.0, rel.yd, -1.0, weighted(Y, rel.Dd))
    c_v, c_s = 1.0 + 0.0 * area, 0.0 * area
    u0 = v
    if law.bristle:
        c_v, c_s = law.viscous * area, law.tangential * area * rel.held
        u0 = combined(c_v, v, c_s, combined(1.0, rel.y, -1.0, weighted(rel.X, rel.D)))
    u = tangential(unit, u0)
    norm = sqrt(dot(u, u) + law.velocity * law.velocity)
    limit = law.mu * F * size
    over = 1.0 / norm
    phi = limit * over
    if law.bristle:
        over, phi = chosen(norm - limit, over, 0.0 * norm), chosen(norm - limit, phi, 1.0 + 0.0 * norm)
    tau = scaled(phi, u)
    h = combined(-F, at.m, 1.0, tau)
    return Force(
        at, F, law.exponent * stiff * growth, F_rate, elastic, rate, size, unit, Y, tangential(unit, v), u, u0, c_v, c_s,
        phi, over, tau, h, scaled(-F, at.g_a),
    )  # fmt: skip


@inlined
def due_to_velocity(law: Law, area: Any, rel: Relative, c: Force) -> Force:
    """The contact ``c``, its forces tau, h, f_a and F less those at rest in the same place."""
    o = (0.0 * area, 0.0 * area, 0.0 * area)
    still = contact(law, c.at, area, Relative(rel.y, o, rel.a, o, rel.D, (o, o, o), rel.X, rel.held))
    tau, h = combined(1.0, c.tau, -1.0, still.tau), combined(1.0, c.h, -1.0, still.h)
    return Force(
        c.at, c.F - still.F, c.F_delta, c.F_rate, c.elastic, c.rate, c.size, c.unit, c.Y, c.slip, c.u, c.u0, c.c_v, c.c_s,
        c.phi, c.over, tau, h, combined(1.0, c.f_a, -1.0, still.f_a),
    )  # fmt: skip
