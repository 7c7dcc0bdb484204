"""The gap between a point and an obstacle, with its gradient, and how both change.

With y from the obstacle's centre to the point, the obstacle's axis a and the distance R at which they touch, the gap g(y, a) is

    cylinder   |rho| - R + c(z),    z = a.y / a.a,    rho = y - z a
    sphere     |y| - R
    plane      a.y - R

Beyond its ends, |z| > l/2, a cylinder falls off as its edge of radius r does near the end, c = (|z| - l/2)^2 / (2 r). So the gap
has a continuous gradient there and contact remains conservative: the point slides off over a few times sqrt(2 r depth).

All gradients are exact also where a is not of unit length, which holds only at the solution of the constraints. Vectors are
tuples of three, of numbers for one point or of lanes for several; obstacle and axis are numbers. With n = rho / d, the third
direction t normal to n and a, and the gradients z_y = a / a.a, z_a = (rho - z a) / a.a of z, the second derivatives of a
cylinder's gap are

    yy   t t^T / d + c'' z_y z_y^T
    ya   -a n^T / a.a - z t t^T / d + c'' z_y z_a^T + c' (1 - 2 a a^T / a.a) / a.a
    aa   (z (n a^T + a n^T) - d n n^T) / a.a + z^2 t t^T / d + c'' z_a z_a^T + c' z_aa
"""

from __future__ import annotations

from typing import Any, NamedTuple

from lamella._jit import inlined
from lamella.contact.matrices import Matrix, added, dyad, summed, transposed, with_unit
from lamella.element.plate48.strain import Vector, combined, combined3, cross, dot, scaled
from lamella.lane import chosen, sqrt

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
def positive(x: Any) -> Any:
    """x or 0; what is not a number stays so."""
    return chosen(-x, 0.0, x)


@inlined
def distance(obstacle: Obstacle, y: Vector, a: Vector) -> Any:
    """Distance from axis, centre or plane, which the gap is at least, less R."""
    if obstacle.kind == PLANE:
        return dot(a, y)
    square = dot(y, y)
    if obstacle.kind == CYLINDER:
        along = dot(a, y)
        square = square - along * along / dot(a, a)
    return sqrt(positive(square))


@inlined
def gap(obstacle: Obstacle, reach: float, y: Vector, a: Vector) -> Gap:
    """The gap with its gradients; ``reach`` is R."""
    none = 0.0 * y[0]
    if obstacle.kind == PLANE:
        m = (none + a[0], none + a[1], none + a[2])
        return Gap(dot(a, y) - reach, m, y, m, none, none, none, none)
    if obstacle.kind == SPHERE:
        d = sqrt(dot(y, y))
        n = scaled(1.0 / d, y)
        return Gap(d - reach, n, (none, none, none), n, d, none, none, none)
    aa = dot(a, a)
    z = dot(a, y) / aa
    rho = combined(1.0, y, -z, a)
    d = sqrt(dot(rho, rho))
    n = scaled(1.0 / d, rho)
    beyond = positive(chosen(z, z, -z) - obstacle.half)
    c2 = chosen(beyond, none + 1.0 / obstacle.edge, none)
    c1 = chosen(z, beyond, -beyond) * c2
    m = combined(1.0, n, c1 / aa, a)
    g_a = combined3(-z, n, c1 / aa, rho, -c1 * z / aa, a)
    return Gap(d - reach + 0.5 * c2 * beyond * beyond, m, g_a, n, d, z, c1, c2)


@inlined
def hessian(obstacle: Obstacle, at: Gap, a: Vector) -> tuple[Matrix, Matrix, Matrix]:
    """Second derivatives of the gap by y y, y a and a a."""
    none = 0.0 * at.g
    zero = ((none, none, none), (none, none, none), (none, none, none))
    if obstacle.kind == PLANE:
        return zero, with_unit(none + 1.0, zero), zero
    inverse = 1.0 / at.d
    if obstacle.kind == SPHERE:
        return with_unit(inverse, dyad(-inverse, at.n, at.n)), zero, zero
    per = 1.0 / dot(a, a)
    turned = cross(a, at.n)
    tt = dyad(inverse * per, turned, turned)
    z_y, z_a = scaled(per, a), combined(per * at.d, at.n, -per * at.z, a)
    steep = scaled(at.c2, z_y)
    yy = added(tt, dyad(1.0, steep, z_y))
    ya = summed(-1.0, dyad(1.0, z_y, at.n), -at.z, tt)
    ya = added(ya, added(dyad(1.0, steep, z_a), dyad(-2.0 * at.c1, z_y, z_y)))
    ya = with_unit(at.c1 * per, ya)
    mixed = dyad(at.z, at.n, z_y)
    aa = added(added(mixed, transposed(mixed)), summed(-at.d * per, dyad(1.0, at.n, at.n), at.z * at.z, tt))
    aa = added(aa, dyad(at.c2, z_a, z_a))
    # z_aa = -2 (y a^T + a y^T) / (a.a)^2 - 2 z / a.a + 8 z a a^T / (a.a)^2 with y = d n + z a
    bent = dyad(-2.0 * at.c1 * at.d * per, at.n, z_y)
    aa = added(aa, added(added(bent, transposed(bent)), dyad(4.0 * at.c1 * at.z, z_y, z_y)))
    return yy, ya, with_unit(-2.0 * at.c1 * at.z * per, aa)
