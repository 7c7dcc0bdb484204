"""Kelvin-Voigt damping of Plate48, a lane of elements at a time; layouts as in :mod:`lamella.element.plate48.kernels`.

With the rates of the strains sdot = (ds/dg) gdot and the viscous stiffness C, the resultants N_d = C sdot give

    f = (ds/dq)^T N_d,   df/dv = (ds/dq)^T C (ds/dq),   df/dq = sum_k N_d,k d2s_k/dq2 + (ds/dq)^T C (dsdot/dq)

and dissipate N_d . sdot. The last term is not symmetric. The rates vanish in rigid motion, whatever its speed.

With C = c C_e the elastic resultants C_e s are of the same kind: where they are wanted too, they are added to N_d, and 1 to the
weight of (ds/dq)^T C_e (ds/dq), at hardly any cost.
"""

from __future__ import annotations

from typing import Any

from lamella._jit import inlined, inner, shared
from lamella.element.plate48.contraction import contract_eta, contract_xi
from lamella.element.plate48.hessian import store_hessian
from lamella.element.plate48.interpolation import (
    constants_at,
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
    energy_density,
    extrapolated_strains,
    gradient,
    normal_change,
    resultants,
    scaled,
    strains,
    surface_frame,
)
from lamella.lane import WIDTH, load, spread, store
from lamella.roles import Floats, Ints


@inlined
def strain_rates(g: tuple[Vector, ...], v: tuple[Vector, ...], m: Vector, m_rate: Vector) -> tuple[Any, ...]:
    """Rates of the six strains; v = gdot."""
    return (
        dot(g[0], v[0]),
        dot(g[1], v[1]),
        dot(g[0], v[1]) + dot(g[1], v[0]),
        dot(v[2], m) + dot(g[2], m_rate),
        dot(v[3], m) + dot(g[3], m_rate),
        dot(v[4], m) + dot(g[4], m_rate),
    )


@inlined
def _christoffel_rates(d: Vector, gamma1: Vector, gamma2: Vector, b: Vector, v: tuple[Vector, ...], normal: Any) -> Vector:
    """Rates of gamma_a = g_a . d for the three second derivatives, with d one of the dual vectors and b_a = g_a . m.

    d(gamma_a)/dt = d . (gdot_a - gamma_a^1 rdot_x - gamma_a^2 rdot_y) - b_a d . normal,  normal = mdot / m.m
    """
    x, y, n = dot(d, v[0]), dot(d, v[1]), dot(d, normal)
    return (
        dot(d, v[2]) - gamma1[0] * x - gamma2[0] * y - b[0] * n,
        dot(d, v[3]) - gamma1[1] * x - gamma2[1] * y - b[1] * n,
        dot(d, v[4]) - gamma1[2] * x - gamma2[2] * y - b[2] * n,
    )


@inlined
def _projected(g: tuple[Vector, ...], u: Vector) -> Vector:
    """Scalar products of the three second derivatives with u."""
    return (dot(g[2], u), dot(g[3], u), dot(g[4], u))


@inlined
def _store_vector(work: Floats, at: int, u: Vector) -> None:
    store(work, at, u[0])
    store(work, at + 1, u[1])
    store(work, at + 2, u[2])


@inlined
def _store_row(
    c: tuple[Any, ...],
    v: tuple[Vector, ...],
    m: Vector,
    m_rate: Vector,
    gammas: Any,
    duals: Any,
    work: Floats,
    at: int,
    cubed: Cubed,
) -> None:
    """Store C_k . dsdot/dg, five vectors, for the row C_k of the stiffness.

    Args:
        gammas: gamma^1, gamma^2 and their rates.
        duals: b, its rate, d1, d2 and their rates.
        others: as everywhere in this file.
    """
    bending = (c[3], c[4], c[5])
    x, y = combined(c[0], v[0], c[2], v[1]), combined(c[2], v[0], c[1], v[1])
    for_x = combined(dot(bending, gammas[0]), m_rate, dot(bending, gammas[2]), m)
    for_y = combined(dot(bending, gammas[1]), m_rate, dot(bending, gammas[3]), m)
    if cubed is not None:
        twice, twice_rate = 2.0 * dot(bending, duals[0]), 2.0 * dot(bending, duals[1])
        for_x = combined3(1.0, for_x, twice_rate, duals[2], twice, duals[4])
        for_y = combined3(1.0, for_y, twice_rate, duals[3], twice, duals[5])
    _store_vector(work, at, combined(1.0, x, -1.0, for_x))
    _store_vector(work, at + 3, combined(1.0, y, -1.0, for_y))
    _store_vector(work, at + 6, scaled(c[3], m_rate))
    _store_vector(work, at + 9, scaled(c[4], m_rate))
    _store_vector(work, at + 12, scaled(c[5], m_rate))


@inlined
def dual_rate(d: Vector, v: Any, d1: Vector, d2: Vector, m: Vector, normal: Vector) -> Vector:
    """Rate of a dual vector d, - (d . rdot_x) d1 - (d . rdot_y) d2 - (d . mdot / m.m) m."""
    return combined3(-dot(d, v[0]), d1, -dot(d, v[1]), d2, -dot(d, normal), m)


@inlined
def _store_rate_rows(
    g: Any, v: Any, m: Vector, m_rate: Vector, d1: Vector, d2: Vector, c: Any, work: Floats, at: int, cubed: Cubed
) -> Any:
    """Store C dsdot/dg, (6, 5, component), and return the Christoffel symbols and b."""
    gamma1, gamma2, b = _projected(g, d1), _projected(g, d2), _projected(g, m)
    normal = m_rate if cubed is None else scaled(1.0 / dot(m, m), m_rate)
    rates1 = _christoffel_rates(d1, gamma1, gamma2, b, v, normal)
    rates2 = _christoffel_rates(d2, gamma1, gamma2, b, v, normal)
    gammas = (gamma1, gamma2, rates1, rates2)
    b_rate = combined(1.0, _projected(v, m), 1.0, _projected(g, m_rate))
    duals = (b, b_rate, d1, d2, dual_rate(d1, v, d1, d2, m, normal), dual_rate(d2, v, d1, d2, m, normal))
    _store_row((c[0], c[1], c[2], c[3], c[4], c[5]), v, m, m_rate, gammas, duals, work, at, cubed)
    _store_row((c[1], c[6], c[7], c[8], c[9], c[10]), v, m, m_rate, gammas, duals, work, at + 15, cubed)
    _store_row((c[2], c[7], c[11], c[12], c[13], c[14]), v, m, m_rate, gammas, duals, work, at + 30, cubed)
    _store_row((c[3], c[8], c[12], c[15], c[16], c[17]), v, m, m_rate, gammas, duals, work, at + 45, cubed)
    _store_row((c[4], c[9], c[13], c[16], c[18], c[19]), v, m, m_rate, gammas, duals, work, at + 60, cubed)
    _store_row((c[5], c[10], c[14], c[17], c[19], c[20]), v, m, m_rate, gammas, duals, work, at + 75, cubed)
    return gamma1, gamma2, b


@inlined
def scaled21(a: float, c: Any) -> Any:
    """``a`` times the 21 entries of a stiffness."""
    return (
        a * c[0], a * c[1], a * c[2], a * c[3], a * c[4], a * c[5], a * c[6], a * c[7], a * c[8], a * c[9], a * c[10],
        a * c[11], a * c[12], a * c[13], a * c[14], a * c[15], a * c[16], a * c[17], a * c[18], a * c[19], a * c[20],
    )  # fmt: skip


@inlined
def _store_small(work: Floats, at: int, g: Any, m: Vector, d1: Vector, d2: Vector, gammas: Any, cubed: Cubed) -> None:
    """Store the vectors that make up ds/dg; gammas: gamma^1, gamma^2 and b."""
    _store_vector(work, at, g[0])
    _store_vector(work, at + 3, g[1])
    _store_vector(work, at + 6, m)
    _store_vector(work, at + 9, gammas[0])
    _store_vector(work, at + 12, gammas[1])
    if cubed is not None:
        _store_vector(work, at + 15, gammas[2])
        _store_vector(work, at + 18, d1)
        _store_vector(work, at + 21, d2)


@inner
def _merge_pair(work: Floats, small: int, rates: int, symmetric: int, target: int, c: int, d: int, cubed: Cubed) -> None:
    """Add (ds/dg)^T C dsdot/dg to the symmetric part for the components (c, d) and store the 25 entries at ``target``."""
    low, high = min(c, d), max(c, d)
    source = symmetric + (low * (5 - low) // 2 + high) * 25
    r_x, r_y, m = load(work, small + c), load(work, small + 3 + c), load(work, small + 6 + c)
    down, across = (5, 1) if c <= d else (1, 5)
    for v in range(5):
        at, column = rates + 3 * v + d, source + across * v
        y0, y1, y2 = load(work, at), load(work, at + 15), load(work, at + 30)
        y3, y4, y5 = load(work, at + 45), load(work, at + 60), load(work, at + 75)
        s = small + 9
        along1 = load(work, s) * y3 + load(work, s + 1) * y4 + load(work, s + 2) * y5
        along2 = load(work, s + 3) * y3 + load(work, s + 4) * y4 + load(work, s + 5) * y5
        for_x, for_y = r_x * y0 + r_y * y2 - m * along1, r_y * y1 + r_x * y2 - m * along2
        if cubed is not None:
            twice = 2.0 * (load(work, s + 6) * y3 + load(work, s + 7) * y4 + load(work, s + 8) * y5)
            for_x, for_y = for_x - load(work, small + 18 + c) * twice, for_y - load(work, small + 21 + c) * twice
        store(work, target + v, load(work, column) + for_x)
        store(work, target + 5 + v, load(work, column + down) + for_y)
        store(work, target + 10 + v, load(work, column + 2 * down) + m * y3)
        store(work, target + 15 + v, load(work, column + 3 * down) + m * y4)
        store(work, target + 20 + v, load(work, column + 4 * down) + m * y5)


@inlined
def gather_both(q: Floats, v: Floats, index: Ints, scale: Floats, block: int, table: Floats, n: int, work: Floats) -> None:
    """Lines of the positions at lane 48 of work and of the velocities behind them."""
    gather(q, index, scale, block, work, 0)
    interpolate_eta(work, 0, 48, table, n)
    gather(v, index, scale, block, work, 0)
    interpolate_eta(work, 0, 48 + 36 * n, table, n)


@inlined
def weighted6(a: float, s: tuple[Any, ...], b: float, r: tuple[Any, ...]) -> tuple[Any, ...]:
    """Sum a s + b r of six strains or resultants."""
    return (
        a * s[0] + b * r[0], a * s[1] + b * r[1], a * s[2] + b * r[2],
        a * s[3] + b * r[3], a * s[4] + b * r[4], a * s[5] + b * r[5],
    )  # fmt: skip


@shared
def viscous_force(
    q: Floats,
    v: Floats,
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
    power: Floats,
) -> None:
    """Viscous force of the elements, f (block, 48), and the power they dissipate, power (block,).

    The sections hold the elastic stiffness C_e, time is c; with ``elastic`` the elastic force is added.
    """
    lines, rates, sums = 48, 48 + 36 * n, 48 + 72 * n
    for block in range(index.size // (48 * WIDTH)):
        gather_both(q, v, index, scale, block, table, n, work)
        total = spread(0.0)
        for j in range(n):
            for i in range(n):
                g, g_rate = interpolate_xi(work, lines, table, i, j), interpolate_xi(work, rates, table, i, j)
                m, d1, d2 = surface_frame(g[0], g[1], cubed)
                s_rate = strain_rates(g, g_rate, m, normal_change(g_rate[0], g_rate[1], m, d1, d2, cubed))
                at = constants_at(sections, block, n, i, j)
                c = stiffness(sections, at)
                res = resultants(c, s_rate)
                total = total + 2.0 * time * energy_density(res, s_rate)
                res = weighted6(time, res, 0.0, res)
                if elastic:
                    res = weighted6(1.0, res, 1.0, resultants(c, strains(g, m, reference(sections, at))))
                spread_xi(gradient(g, m, d1, d2, res, cubed), work, sums + j * 36, table, i, i == 0)
        spread_eta(work, sums, table, n, f, block * 48)
        store(power, block, total)


@shared
def viscous_tangent(
    q: Floats,
    v: Floats,
    q_previous: Floats,
    extrapolate: bool,
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
    k: Floats,
) -> None:
    """alpha_q df/dq + alpha_v df/dv of the viscous force, all entries, k (block, 2304).

    With ``elastic`` that of the elastic force is added, the resultants of its geometric part extrapolated from ``q_previous``
    if ``extrapolate``.
    """
    lines, rates, previous, small = 48, 48 + 36 * n, 48 + 72 * n, 48 + 108 * n
    weight = time * alpha_v + (alpha_q if elastic else 0.0)
    rows = small + (15 if cubed is None else 24)
    symmetric = rows + 90
    z = symmetric + 150
    partial = z + 15 * n
    hessian = partial + 144 * n
    position = 0
    for block in range(index.size // (48 * WIDTH)):
        gather_both(q, v, index, scale, block, table, n, work)
        if elastic and extrapolate:
            gather(q_previous, index, scale, block, work, 0)
            interpolate_eta(work, 0, previous, table, n)
        for j in range(n):
            for i in range(n):
                g, g_rate = interpolate_xi(work, lines, table, i, j), interpolate_xi(work, rates, table, i, j)
                factor = alpha_q * time
                g_rate = (
                    scaled(factor, g_rate[0]),
                    scaled(factor, g_rate[1]),
                    scaled(factor, g_rate[2]),
                    scaled(factor, g_rate[3]),
                    scaled(factor, g_rate[4]),
                )
                m, d1, d2 = surface_frame(g[0], g[1], cubed)
                m_rate = normal_change(g_rate[0], g_rate[1], m, d1, d2, cubed)
                at = constants_at(sections, block, n, i, j)
                c = stiffness(sections, at)
                gammas = _store_rate_rows(g, g_rate, m, m_rate, d1, d2, c, work, rows, cubed)
                _store_small(work, small, g, m, d1, d2, gammas, cubed)
                s = strain_rates(g, g_rate, m, m_rate)
                if elastic and extrapolate:
                    g_previous = interpolate_xi(work, previous, table, i, j)
                    s = weighted6(1.0, s, alpha_q, extrapolated_strains(g, g_previous, reference(sections, at), cubed))
                elif elastic:
                    s = weighted6(1.0, s, alpha_q, strains(g, m, reference(sections, at)))
                res = resultants(c, s)
                c = scaled21(weight, c)
                store_hessian(work, symmetric, 25, g, m, d1, d2, c, res, cubed)
                for pair in range(9):
                    target = hessian + ((pair * n + i) * n + j) * 25
                    _merge_pair(work, small, rows, symmetric, target, pair // 3, pair % 3, cubed)
        for pair in range(9):
            for i in range(n):
                contract_eta(work, hessian + (pair * n + i) * n * 25, z, partial, table, n, i, False)
            position = contract_xi(work, partial, table, n, k, position, False)


def viscous_work_size(n: int) -> int:
    """Lanes of work space for n x n Gauss points."""
    return 48 + 3 * 36 * n + 24 + 90 + 150 + 15 * n + 144 * n + 9 * n * n * 25 + 36 * n
