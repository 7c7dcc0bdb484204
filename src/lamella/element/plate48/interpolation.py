"""From element coordinates to the Gauss points and back, one direction after the other, for a lane of elements at a time.

Arrays are flat; the layouts are those of :mod:`lamella.element.plate48.kernels`.
"""

from __future__ import annotations

from typing import Any

from lamella._jit import inlined
from lamella.lane import WIDTH, load, number_at, put_at, spread, store
from lamella.roles import Floats, Ints

N_SECTION = 27
"""Constants of a Gauss point: stiffness (21) and reference (6)."""


@inlined
def constants_at(sections: Floats, block: int, n: int, i: int, j: int) -> int:
    """Where the constants of Gauss point (i, j) of a block begin; where all elements are alike there are those of one block."""
    own = block if len(sections) > n * n * N_SECTION * WIDTH else 0
    return ((own * n + j) * n + i) * N_SECTION


@inlined
def gather(q: Floats, index: Ints, scale: Floats, block: int, work: Floats, target: int) -> None:
    """Element coordinates of a block, scaled, to work[target:]."""
    first, to = 48 * WIDTH * block, WIDTH * target
    for k in range(48 * WIDTH):
        put_at(work, to + k, number_at(q, number_at(index, first + k)) * number_at(scale, first + k))


@inlined
def interpolate_eta(work: Floats, source: int, target: int, table: Floats, n: int) -> None:
    """Contract element coordinates with phi_b(eta_j): work[target:] gets (j, derivative, a, component)."""
    for j in range(n):
        for d in range(3):
            t = (3 * j + d) * 4
            for a in range(4):
                for c in range(3):
                    e = source + 12 * a + c
                    value = table[t] * load(work, e) + table[t + 1] * load(work, e + 3)
                    value = value + table[t + 2] * load(work, e + 6) + table[t + 3] * load(work, e + 9)
                    store(work, target + ((3 * j + d) * 4 + a) * 3 + c, value)


@inlined
def _sum_a(work: Floats, at: int, t0: float, t1: float, t2: float, t3: float) -> Any:
    """One vector: sum over a of a number times the vector of function a."""
    return (
        t0 * load(work, at) + t1 * load(work, at + 3) + t2 * load(work, at + 6) + t3 * load(work, at + 9),
        t0 * load(work, at + 1) + t1 * load(work, at + 4) + t2 * load(work, at + 7) + t3 * load(work, at + 10),
        t0 * load(work, at + 2) + t1 * load(work, at + 5) + t2 * load(work, at + 8) + t3 * load(work, at + 11),
    )


@inlined
def interpolate_xi(work: Floats, source: int, table: Floats, i: int, j: int) -> Any:
    """g = (r_x, r_y, r_xx, r_yy, r_xy) at Gauss point (i, j) from the result of :func:`interpolate_eta`."""
    t, at = 12 * i, source + j * 36
    f0, f1, f2, f3 = table[t], table[t + 1], table[t + 2], table[t + 3]
    s0, s1, s2, s3 = table[t + 4], table[t + 5], table[t + 6], table[t + 7]
    return (
        _sum_a(work, at, s0, s1, s2, s3),
        _sum_a(work, at + 12, f0, f1, f2, f3),
        _sum_a(work, at, table[t + 8], table[t + 9], table[t + 10], table[t + 11]),
        _sum_a(work, at + 24, f0, f1, f2, f3),
        _sum_a(work, at + 12, s0, s1, s2, s3),
    )


@inlined
def three(array: Floats, at: int) -> Any:
    """Three lanes of an array, as of a vector."""
    return (load(array, at), load(array, at + 1), load(array, at + 2))


@inlined
def stiffness(sections: Floats, s: int) -> Any:
    """The 21 upper entries of the stiffness of a Gauss point."""
    first = three(sections, s) + three(sections, s + 3) + three(sections, s + 6) + three(sections, s + 9)
    return first + three(sections, s + 12) + three(sections, s + 15) + three(sections, s + 18)


@inlined
def reference(sections: Floats, s: int) -> Any:
    """The six constants of the reference surface at a Gauss point."""
    return three(sections, s + 21) + three(sections, s + 24)


@inlined
def spread_xi(h: Any, work: Floats, at: int, table: Floats, i: int, fresh: bool) -> None:
    """Add dW/dg at a Gauss point to the sums (derivative by eta, a, component) over the points of one line eta = const."""
    for a in range(4):
        f, s, c = table[12 * i + a], table[12 * i + 4 + a], table[12 * i + 8 + a]
        for k in range(3):
            w = at + 3 * a + k
            v0 = s * h[0][k] + c * h[2][k]
            v1 = f * h[1][k] + s * h[4][k]
            v2 = f * h[3][k]
            if not fresh:
                v0, v1, v2 = v0 + load(work, w), v1 + load(work, w + 12), v2 + load(work, w + 24)
            store(work, w, v0)
            store(work, w + 12, v1)
            store(work, w + 24, v2)


@inlined
def spread_eta(work: Floats, source: int, table: Floats, n: int, f: Floats, target: int) -> None:
    """Force of the element coordinates (a, b, component) from the sums of :func:`spread_xi`."""
    for a in range(4):
        for c in range(3):
            w, t = source + 3 * a + c, target + 12 * a + c
            f0, f1, f2, f3 = spread(0.0), spread(0.0), spread(0.0), spread(0.0)
            for j in range(n):
                for d in range(3):
                    v, k = load(work, w + (3 * j + d) * 12), (3 * j + d) * 4
                    f0 = f0 + table[k] * v
                    f1 = f1 + table[k + 1] * v
                    f2 = f2 + table[k + 2] * v
                    f3 = f3 + table[k + 3] * v
            store(f, t, f0)
            store(f, t + 3, f1)
            store(f, t + 6, f2)
            store(f, t + 9, f3)
