"""The force of a moment on the two tangents of a thin shell at a point, and its derivative.

With the tangents a_1 = r_x, a_2 = r_y, J = |a_1 x a_2|, the normal n0 = a_1 x a_2 / J and the dual tangents d_1 = a_2 x n0 / J,
d_2 = n0 x a_1 / J, the material frame (t_1, t_2, n0) lies symmetrically in the tangents: t_1 + t_2 has the direction of
a_1/|a_1| + a_2/|a_2|. Its angular velocity is

    w = n0 x n0' + 1/2 sum_i n0.(a_i x a_i')/|a_i|^2 n0 = sum_i W_i a_i'
      = sum_i [b_i (n0.a_i') + 1/2 n0 (c_i.a_i')],      b_1 = -a_2/J,  b_2 = a_1/J,  c_i = n0 x a_i / |a_i|^2

that is the turning of the normal, as in Kirchhoff's theory, with the mean of the rates at which the two tangents turn in the
tangent plane (drilling). A moment m does the virtual work m . delta w, so its force on a_i is

    F_i = W_i^T m = n0 (b_i.m) + 1/2 c_i (n0.m)

with dn0 = -sum_j d_j (n0.da_j) and dJ = J sum_j d_j.da_j in its derivative. Vectors are tuples of three numbers, so that
nothing is allocated at a point.
"""

from __future__ import annotations

import math

from lamella._jit import inlined, inner, njit
from lamella.roles import Floats, Ints

FIXED, MATERIAL, ALONG_X, ALONG_Y = 0, 1, 2, 3
"""What the components of a moment refer to: inertial axes, the material frame, or (first component) the tangent r_x or r_y."""

Vector = tuple[float, float, float]
Pair = tuple[Vector, Vector]


@inlined
def dot(u: Vector, v: Vector) -> float:
    """u . v."""
    return u[0] * v[0] + u[1] * v[1] + u[2] * v[2]


@inlined
def cross(u: Vector, v: Vector) -> Vector:
    """u x v."""
    return (u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0])


@inlined
def scaled(x: float, u: Vector) -> Vector:
    """x u."""
    return (x * u[0], x * u[1], x * u[2])


@inlined
def combined(x: float, u: Vector, y: float, v: Vector) -> Vector:
    """x u + y v."""
    return (x * u[0] + y * v[0], x * u[1] + y * v[1], x * u[2] + y * v[2])


@inlined
def unit(u: Vector) -> Vector:
    """u / |u|."""
    return scaled(1 / math.sqrt(dot(u, u)), u)


@inlined
def tangent_pair(tangents: Floats, p: int) -> Pair:
    """a_1 and a_2 at point p."""
    return (
        (tangents[p, 0, 0], tangents[p, 0, 1], tangents[p, 0, 2]),
        (tangents[p, 1, 0], tangents[p, 1, 1], tangents[p, 1, 2]),
    )


@inlined
def material_frame(a: Pair) -> tuple[Vector, float, Pair, Pair]:
    """n0, J, b_i and c_i."""
    normal = cross(a[0], a[1])
    J = math.sqrt(dot(normal, normal))
    n0 = scaled(1 / J, normal)
    b = (scaled(-1 / J, a[1]), scaled(1 / J, a[0]))
    c = (scaled(1 / dot(a[0], a[0]), cross(n0, a[0])), scaled(1 / dot(a[1], a[1]), cross(n0, a[1])))
    return n0, J, b, c


@inlined
def moment_vector(kind: int, components: Vector, a: Pair, n0: Vector) -> Vector:
    """The moment in inertial axes."""
    if kind == FIXED:
        return components
    if kind == ALONG_X:
        return scaled(components[0], unit(a[0]))
    if kind == ALONG_Y:
        return scaled(components[0], unit(a[1]))
    middle = unit(combined(1.0, unit(a[0]), 1.0, unit(a[1])))  # (t_1 + t_2) / sqrt 2
    across = cross(n0, middle)  # (t_2 - t_1) / sqrt 2
    half = math.sqrt(0.5)
    plane = combined(half * (components[0] + components[1]), middle, half * (components[1] - components[0]), across)
    return combined(1.0, plane, components[2], n0)


@inlined
def spin_force(b_i: Vector, c_i: Vector, n0: Vector, m: Vector) -> Vector:
    """W_i^T m."""
    return combined(dot(b_i, m), n0, 0.5 * dot(n0, m), c_i)


@inlined
def moment_gradient(kind: int, j: int, u: Vector, a_j: Vector, b_j: Vector, c_j: Vector, n0: Vector, m: Vector) -> Vector:
    """(dm/da_j)^T u; dm/da_j is 0 for fixed axes, -[m x] W_j for the material frame, |m| d(a_j/|a_j|)/da_j along a tangent."""
    if kind == MATERIAL:
        return spin_force(b_j, c_j, n0, cross(m, u))
    if kind == ALONG_X + j:
        along = unit(a_j)
        share = dot(m, along) / math.sqrt(dot(a_j, a_j))
        return combined(share, u, -share * dot(along, u), along)
    return (0.0, 0.0, 0.0)


@inner
def moment_forces(kind: int, components: Vector, tangents: Floats, F: Floats) -> None:
    """Forces of a moment on the tangents.

    Args:
        kind: what the components refer to.
        components: the moment [N m] (or per length [N]).
        tangents: r_x, r_y at each point, shape (n, 2, 3).
        F: result F_i, shape (n, 2, 3).
    """
    for p in range(tangents.shape[0]):
        a = tangent_pair(tangents, p)
        n0, _, b, c = material_frame(a)
        m = moment_vector(kind, components, a, n0)
        for i in range(2):
            F_i = spin_force(b[i], c[i], n0, m)
            for row in range(3):
                F[p, i, row] = F_i[row]


@njit
def group_forces(
    kind: int, components: Vector, factor: float, q: Floats, coords: Ints, slopes: Floats, shares: Floats,
    tangents: Floats, F: Floats, f: Floats,
) -> None:  # fmt: skip
    """f = factor sum_points S^T F(S q) of groups of points.

    Args:
        kind, components: the moment, as in :func:`moment_forces`.
        factor: of the force.
        q: all coordinates.
        coords: first coordinate of each vector of each group, shape (n_groups, n).
        slopes: weights of the vectors in the tangents, shape (n_groups, 2 n_points, n).
        shares: the same times the weight of the point, transposed, shape (n_groups, n, 2 n_points).
        tangents, F: results r_x, r_y and F_i of each point, shape (n_groups, n_points, 2, 3).
        f: result, shape (n_groups, n, 3).
    """
    n_groups, n_rows, n = slopes.shape
    for g in range(n_groups):
        for row in range(n_rows):
            for c in range(3):
                total = 0.0
                for k in range(n):
                    total += slopes[g, row, k] * q[coords[g, k] + c]
                tangents[g, row // 2, row % 2, c] = total
        moment_forces(kind, components, tangents[g], F[g])
        for k in range(n):
            for c in range(3):
                total = 0.0
                for row in range(n_rows):
                    total += shares[g, k, row] * F[g, row // 2, row % 2, c]
                f[g, k, c] = factor * total


@njit
def moment_tangents(kind: int, components: Vector, tangents: Floats, H: Floats) -> None:
    """Derivatives of the forces of a moment by the tangents.

    H_ij = dF_i/da_j = -(b_i.m)(d_j n0^T + n0 d_j^T) - 1/2 (c_i (m.d_j) + (m.n0) (d_j x a_i)/|a_i|^2) n0^T
           + (n0/J) (m^T for ij = 21, -m^T for ij = 12) + 1/2 (m.n0) ([n0 x] - 2 c_i a_i^T)/|a_i|^2 (for i = j)
           + W_i^T dm/da_j

    Args:
        kind: what the components refer to.
        components: the moment [N m] (or per length [N]).
        tangents: r_x, r_y at each point, shape (n, 2, 3).
        H: result H_ij, shape (n, i: 2, j: 2, 3, 3).
    """
    for p in range(tangents.shape[0]):
        a = tangent_pair(tangents, p)
        n0, J, b, c = material_frame(a)
        m = moment_vector(kind, components, a, n0)
        d = (scaled(1 / J, cross(a[1], n0)), scaled(1 / J, cross(n0, a[0])))
        for i in range(2):
            s, square = dot(b[i], m), dot(a[i], a[i])
            share = 0.5 * dot(m, n0) / square
            for j in range(2):
                tilt = combined(-0.5 * dot(m, d[j]), c[i], -share, cross(d[j], a[i]))
                left = combined(1.0, tilt, -s, d[j])
                right = combined((i - j) / J, m, -s, d[j])
                right = combined(1.0, right, 1.0, moment_gradient(kind, j, b[i], a[j], b[j], c[j], n0, m))
                by_n0 = moment_gradient(kind, j, n0, a[j], b[j], c[j], n0, m)
                for row in range(3):
                    for col in range(3):
                        H[p, i, j, row, col] = left[row] * n0[col] + n0[row] * right[col] + 0.5 * c[i][row] * by_n0[col]
            for row in range(3):
                before, after = (row + 2) % 3, (row + 1) % 3
                H[p, i, i, before, after] += share * n0[row]
                H[p, i, i, after, before] -= share * n0[row]
                for col in range(3):
                    H[p, i, i, row, col] -= 2 * share * c[i][row] * a[i][col]
