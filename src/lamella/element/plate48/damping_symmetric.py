"""A symmetric matrix near the tangent of Kelvin-Voigt damping, which costs what the tangent of the elastic force costs.

With the weights alpha_q, alpha_v of coordinates and velocities and the resultants N of the force, the tangent is

    S + alpha_q c R,      S = (alpha_v c + alpha_q) (ds/dq)^T C (ds/dq) + alpha_q sum_k N_k d2s_k/dq2
                          R = (ds/dq)^T C (dsdot/dq)

(without elastic force alpha_v c alone weighs the first). R, which is left out, is small beside S by the turn of a step.
"""

from __future__ import annotations

from lamella._jit import shared
from lamella.element.plate48.contraction import contract_eta, contract_xi
from lamella.element.plate48.damping_kernels import gather_both, scaled21, strain_rates, weighted6
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
    extrapolated_strains,
    gradient,
    normal_change,
    resultants,
    strains,
    surface_frame,
)
from lamella.lane import WIDTH
from lamella.roles import Floats, Ints


@shared
def symmetric_tangent(
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
    f: Floats,
    k: Floats,
) -> None:
    """Viscous force, f (block, 48), and upper triangle of the part S of its tangent, k (block, 1176).

    With ``elastic`` both have the elastic force as well, whose resultants in S are extrapolated from ``q_previous`` if
    ``extrapolate``.
    """
    lines, rates, previous, sums = 48, 48 + 36 * n, 48 + 72 * n, 48 + 108 * n
    z = sums + 36 * n
    partial = z + 15 * n
    hessian = partial + 144 * n
    step, position = n * n * 25, 0
    weight = time * alpha_v + (alpha_q if elastic else 0.0)
    for block in range(index.size // (48 * WIDTH)):
        gather_both(q, v, index, scale, block, table, n, work)
        if elastic and extrapolate:
            gather(q_previous, index, scale, block, work, 0)
            interpolate_eta(work, 0, previous, table, n)
        for j in range(n):
            for i in range(n):
                g, g_rate = interpolate_xi(work, lines, table, i, j), interpolate_xi(work, rates, table, i, j)
                m, d1, d2 = surface_frame(g[0], g[1], cubed)
                s_rate = strain_rates(g, g_rate, m, normal_change(g_rate[0], g_rate[1], m, d1, d2, cubed))
                at = constants_at(sections, block, n, i, j)
                c, constants = stiffness(sections, at), reference(sections, at)
                s = s_geometric = weighted6(time, s_rate, 0.0, s_rate)
                if elastic:
                    s = s_geometric = weighted6(time, s_rate, 1.0, strains(g, m, constants))
                    if extrapolate:
                        g_previous = interpolate_xi(work, previous, table, i, j)
                        s_geometric = weighted6(time, s_rate, 1.0, extrapolated_strains(g, g_previous, constants, cubed))
                spread_xi(gradient(g, m, d1, d2, resultants(c, s), cubed), work, sums + j * 36, table, i, i == 0)
                res = resultants(c, weighted6(alpha_q, s_geometric, 0.0, s_geometric))
                store_hessian(work, hessian + (i * n + j) * 25, step, g, m, d1, d2, scaled21(weight, c), res, cubed)
        spread_eta(work, sums, table, n, f, block * 48)
        for pair in range(6):
            symmetric = pair == 0 or pair == 3 or pair == 5
            for i in range(n):
                contract_eta(work, hessian + (pair * n + i) * n * 25, z, partial, table, n, i, symmetric)
            position = contract_xi(work, partial, table, n, k, position, symmetric)


def work_size(n: int) -> int:
    """Lanes of work space for n x n Gauss points."""
    return 48 + 4 * 36 * n + 15 * n + 144 * n + 6 * n * n * 25
