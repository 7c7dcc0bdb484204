"""The gap between a point and an obstacle, with its gradient, and how both change.

With y from the obstacle's centre to the point, the obstacle's axis a and the distance R at which they touch, the gap g(y, a) is

    cylinder   |rho| - R + c(z),    z = a.y / a.a,    rho = y - z a
    sphere     |y| - R
    plane      a.y - R

Beyond its ends, |z| > l/2, a cylinder falls off as its edge of radius r does near the end, c = (|z| - l/2)^2 / (2 r). So the gap
has a continuous gradient there and contact remains conservative: the point slides off over a few times sqrt(2 r depth).

All gradients are exact also where a is not of unit length, which holds only at the solution of the constraints. Vectors are
tuples of three; the arguments of functions called ``..._change`` are numbers for the point itself and lanes for the changes.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from lamella._jit import inlined
from lamella.element.plate48.strain import Vector, combined, combined3, dot, scaled
from lamella.lane import spread, sqrt

CYLINDER, SPHERE, PLANE = 0, 1, 2


class Obstacle(NamedTuple):
    """An obstacle as the kernels read it.

    Args:
        kind: ``CYLINDER``, ``SPHERE`` or ``PLANE``.
        radius: [m]; 0 for a plane.
        half: half the length of a cylinder [m].
        edge: radius of its edges [m].
        centre: the centre in the axes of the body [m].
        axis: unit vector along the axis, or the outward normal of a plane, in the axes of the body.
        moves: whether the body has coordinates.
    """

    kind: int
    radius: float
    half: float
    edge: float
    centre: tuple[float, float, float]
    axis: tuple[float, float, float]
    moves: bool


class Gap(NamedTuple):
    """The gap at a point.

    Args:
        g: gap [m].
        m: gradient by y, a unit vector but at the edges of a cylinder.
        g_a: gradient by a [m].
        n: unit vector from the axis or centre to the point.
        d: distance from the axis or centre [m].
        z: place along the axis [m].
        c1, c2: first and second derivative of c by z.
    """

    g: float
    m: Vector
    g_a: Vector
    n: Vector
    d: float
    z: float
    c1: float
    c2: float


@inlined
def distance(obstacle: Obstacle, y: Vector, a: Vector) -> float:
    """Distance from axis, centre or plane, which the gap is at least, less R."""
    if obstacle.kind == PLANE:
        return dot(a, y)
    square = dot(y, y)
    if obstacle.kind == CYLINDER:
        square -= dot(a, y) ** 2 / dot(a, a)
    return sqrt(max(square, 0.0))


@inlined
def gap(obstacle: Obstacle, reach: float, y: Vector, a: Vector) -> Gap:
    """The gap with its gradients; ``reach`` is R."""
    zero = (0.0, 0.0, 0.0)
    if obstacle.kind == PLANE:
        return Gap(dot(a, y) - reach, a, y, a, 0.0, 0.0, 0.0, 0.0)
    if obstacle.kind == SPHERE:
        d = sqrt(dot(y, y))
        n = scaled(1.0 / d, y)
        return Gap(d - reach, n, zero, n, d, 0.0, 0.0, 0.0)
    aa = dot(a, a)
    z = dot(a, y) / aa
    rho = combined(1.0, y, -z, a)
    d = sqrt(dot(rho, rho))
    n = scaled(1.0 / d, rho)
    beyond = abs(z) - obstacle.half
    if beyond <= 0.0:
        return Gap(d - reach, n, scaled(-z, n), n, d, z, 0.0, 0.0)
    c2 = 1.0 / obstacle.edge
    c1 = beyond * c2 if z > 0.0 else -beyond * c2
    m = combined(1.0, n, c1 / aa, a)
    g_a = combined3(-z, n, c1 / aa, rho, -c1 * z / aa, a)
    return Gap(d - reach + 0.5 * c2 * beyond**2, m, g_a, n, d, z, c1, c2)


@inlined
def gap_change(obstacle: Obstacle, at: Gap, a: Vector, dy: Vector, da: Vector) -> tuple[Any, Vector, Vector]:
    """Changes of g, m and g_a with changes dy, da."""
    dg = dot(at.m, dy) + dot(at.g_a, da)
    if obstacle.kind == PLANE:
        return dg, da, dy
    if obstacle.kind == SPHERE:
        zero = spread(0.0)
        return dg, scaled(1.0 / at.d, combined(1.0, dy, -1.0, scaled(dg, at.n))), (zero, zero, zero)
    aa = dot(a, a)
    y = combined(at.d, at.n, at.z, a)
    daa = 2.0 * dot(a, da)
    dz = (dot(a, dy) + dot(y, da) - at.z * daa) / aa
    drho = combined3(1.0, dy, -1.0, scaled(dz, a), -at.z, da)
    dn = scaled(1.0 / at.d, combined(1.0, drho, -1.0, scaled(dot(at.n, drho), at.n)))
    dg_a = combined(-1.0, scaled(dz, at.n), -at.z, dn)
    if at.c1 == 0.0:
        return dg, dn, dg_a
    # m = n + c1 a / aa and g_a = -z n + c1 z_a with the gradient z_a = (rho - z a) / aa of z
    z_a = scaled(1.0 / aa, combined(at.d, at.n, -at.z, a))
    dz_a = scaled(1.0 / aa, combined3(1.0, drho, -1.0, scaled(dz, a), -at.z, da))
    dz_a = combined(1.0, dz_a, -1.0 / aa, scaled(daa, z_a))
    dm = combined3(1.0, dn, at.c1 / aa, da, 1.0, scaled((at.c2 * dz - at.c1 * daa / aa) / aa, a))
    return dg, dm, combined3(1.0, dg_a, at.c2, scaled(dz, z_a), at.c1, dz_a)
