"""Length, angle and slide at a point: value, gradient and Hessian in closed form, and their sums over a measure's terms.

The arguments of a term are up to three vectors; ``x`` holds them as rows, (3, 3). The gradient is by their nine components, and
the Hessian is 9 x 9.
"""

from __future__ import annotations

import math

from lamella._jit import inlined, inner, kernel, njit
from lamella.roles import Floats, Ints

LENGTH, ANGLE, SLIDE = 0, 1, 2
"""Kinds of terms: |d|; the angle that turns u into w about t; d . z."""


@inlined
def cross(a: Floats, b: Floats, out: Floats) -> None:
    """out = a x b."""
    out[0] = a[1] * b[2] - a[2] * b[1]
    out[1] = a[2] * b[0] - a[0] * b[2]
    out[2] = a[0] * b[1] - a[1] * b[0]


@inlined
def add_skew(out: Floats, row: int, column: int, factor: float, a: Floats) -> None:
    """Add factor [a x] to the 3 x 3 block at (row, column), where [a x] b = a x b."""
    out[row, column + 1] -= factor * a[2]
    out[row, column + 2] += factor * a[1]
    out[row + 1, column] += factor * a[2]
    out[row + 1, column + 2] -= factor * a[0]
    out[row + 2, column] -= factor * a[1]
    out[row + 2, column + 1] += factor * a[0]


@njit
def length(x: Floats, g: Floats, h: Floats) -> float:
    """|d|, with gradient n = d / |d| and Hessian (1 - n n^T) / |d|."""
    d = x[0]
    size = math.sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2])
    for i in range(3):
        g[i] = d[i] / size
    for i in range(3):
        for j in range(3):
            h[i, j] = ((1.0 if i == j else 0.0) - g[i] * g[j]) / size
    return size


@njit
def slide(x: Floats, g: Floats, h: Floats) -> float:
    """d . z."""
    for i in range(3):
        g[i], g[3 + i] = x[1, i], x[0, i]
        h[i, 3 + i] = h[3 + i, i] = 1.0
    return x[0, 0] * x[1, 0] + x[0, 1] * x[1, 1] + x[0, 2] * x[1, 2]


@inner
def sine_part(x: Floats, g: Floats, h: Floats) -> float:
    """S = |t| D with D = t . (u x w), the sine of the angle times |t|^2 |u| |w| (parts across t)."""
    u, w, t = x[0], x[1], x[2]
    n = math.sqrt(t[0] * t[0] + t[1] * t[1] + t[2] * t[2])
    cross(w, t, g[0:3])
    cross(t, u, g[3:6])
    cross(u, w, g[6:9])
    D = t[0] * g[6] + t[1] * g[7] + t[2] * g[8]
    h[:] = 0.0
    add_skew(h, 0, 3, -n, t)
    add_skew(h, 0, 6, n, w)
    add_skew(h, 3, 6, -n, u)
    for i in range(3):
        for j in range(3):
            e_j = t[j] / n
            h[i, 6 + j] += g[i] * e_j
            h[3 + i, 6 + j] += g[3 + i] * e_j
            h[6 + i, 6 + j] = g[6 + i] * e_j + g[6 + j] * t[i] / n + D * ((1.0 if i == j else 0.0) - t[i] * t[j] / (n * n)) / n
    for i in range(9):
        g[i] *= n
    for i in range(3):
        g[6 + i] += D * t[i] / n
    for i in range(9):
        for j in range(i):
            h[i, j] = h[j, i]
    return n * D


@inner
def cosine_part(x: Floats, g: Floats, h: Floats) -> float:
    """C = (t x u) . (t x w) = t^2 u.w - (u.t)(w.t), the cosine of the angle times |t|^2 |u| |w| (parts across t)."""
    u, w, t = x[0], x[1], x[2]
    tt = t[0] * t[0] + t[1] * t[1] + t[2] * t[2]
    uw = u[0] * w[0] + u[1] * w[1] + u[2] * w[2]
    ut = u[0] * t[0] + u[1] * t[1] + u[2] * t[2]
    wt = w[0] * t[0] + w[1] * t[1] + w[2] * t[2]
    h[:] = 0.0
    for i in range(3):
        g[i] = tt * w[i] - wt * t[i]
        g[3 + i] = tt * u[i] - ut * t[i]
        g[6 + i] = 2.0 * uw * t[i] - wt * u[i] - ut * w[i]
        for j in range(3):
            same = 1.0 if i == j else 0.0
            h[i, 3 + j] = tt * same - t[i] * t[j]
            h[i, 6 + j] = 2.0 * w[i] * t[j] - t[i] * w[j] - wt * same
            h[3 + i, 6 + j] = 2.0 * u[i] * t[j] - t[i] * u[j] - ut * same
            h[6 + i, 6 + j] = 2.0 * uw * same - u[i] * w[j] - w[i] * u[j]
    for i in range(9):
        for j in range(i):
            h[i, j] = h[j, i]
    return tt * uw - ut * wt


@njit
def angle(x: Floats, g: Floats, h: Floats, scratch: Floats) -> float:
    """atan2(S, C) in (-pi, pi], the angle that turns u into w about t; ``scratch`` is (20, 9)."""
    s_g, c_g, s_h, c_h = scratch[0], scratch[1], scratch[2:11], scratch[11:20]
    s, c = sine_part(x, s_g, s_h), cosine_part(x, c_g, c_h)
    rho2 = s * s + c * c
    for i in range(9):
        g[i] = (c * s_g[i] - s * c_g[i]) / rho2
    a, b = (s * s - c * c) / (rho2 * rho2), 2.0 * s * c / (rho2 * rho2)
    for i in range(9):
        for j in range(9):
            mixed = a * (s_g[i] * c_g[j] + c_g[i] * s_g[j]) + b * (c_g[i] * c_g[j] - s_g[i] * s_g[j])
            h[i, j] = (c * s_h[i, j] - s * c_h[i, j]) / rho2 + mixed
    return math.atan2(s, c)


@njit
def evaluate(
    first_term: Ints,
    kinds: Ints,
    factors: Floats,
    centres: Floats,
    constants: Floats,
    weights: Floats,
    first_weight: Ints,
    vectors: Ints,
    first_vector: Ints,
    q: Floats,
    second: bool,
    scratch: Floats,
    terms: Floats,
    value: Floats,
    gradient: Floats,
    hessian: Floats,
) -> None:
    """Values, gradients and (when ``second``) Hessians of all measures.

    Args:
        first_term: first term of each measure and the end, shape (n + 1,).
        kinds, factors, centres: of each term; an angle is taken within pi of its centre.
        constants: constant parts of each term's arguments, shape (n_term, 3, 3).
        weights: of each term, argument by argument, for each of the measure's vectors; ``first_weight`` (n_term + 1,).
        vectors: first coordinate of each vector of each measure; ``first_vector`` (n + 1,).
        q: coordinates.
        second: whether Hessians are wanted.
        scratch: work space, shape (36, 9).
        terms: value of each term without its factor, shape (n_term,).
        value: (n,).
        gradient: by the coordinates of each measure's vectors, one measure after the other, shape (3 n_vectors,).
        hessian: full matrices, one measure after the other.
    """
    x, g, h, rest = scratch[0:3, 0:3], scratch[3], scratch[4:13], scratch[13:33]
    at = 0
    for m in range(value.size):
        start, count = first_vector[m], first_vector[m + 1] - first_vector[m]
        n = 3 * count
        value[m] = 0.0
        gradient[3 * start : 3 * start + n] = 0.0
        if second:
            hessian[at : at + n * n] = 0.0
        for term in range(first_term[m], first_term[m + 1]):
            w = weights[first_weight[term] : first_weight[term + 1]].reshape((3, count))
            for a in range(3):
                for i in range(3):
                    total = constants[term, a, i]
                    for k in range(count):
                        total += w[a, k] * q[vectors[start + k] + i]
                    x[a, i] = total
            g[:] = 0.0
            h[:] = 0.0
            if kinds[term] == LENGTH:
                found = length(x, g, h)
            elif kinds[term] == SLIDE:
                found = slide(x, g, h)
            else:
                found = angle(x, g, h, rest)
                found -= 2.0 * math.pi * round((found - centres[term]) / (2.0 * math.pi))
            factor, terms[term] = factors[term], found
            value[m] += factor * found
            for k in range(count):
                for a in range(3):
                    share = factor * w[a, k]
                    if share == 0.0:
                        continue
                    for i in range(3):
                        gradient[3 * (start + k) + i] += share * g[3 * a + i]
                    if second:
                        for other in range(count):
                            for b in range(3):
                                both = share * w[b, other]
                                if both != 0.0:
                                    for i in range(3):
                                        for j in range(3):
                                            hessian[at + (3 * k + i) * n + 3 * other + j] += both * h[3 * a + i, 3 * b + j]
        if second:
            at += n * n


@kernel
def rates(owner: Ints, gradients: Floats, coords: Ints, v: Floats, out: Floats) -> None:
    """Rates of all measures for velocities v (n_q,)."""
    out[:] = 0.0
    for i in range(len(owner)):
        out[owner[i]] += gradients[i] * v[coords[i]]


@kernel
def share_out(shares: Floats, F: Floats, owner: Ints, gradients: Floats, out: Floats) -> None:
    """Forces F of the measures, each with its share, along their gradients."""
    for i in range(len(owner)):
        out[i] = shares[owner[i]] * F[owner[i]] * gradients[i]
