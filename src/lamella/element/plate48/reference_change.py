"""The derivative of a force, and of its potential, by a parameter that changes the elements: sizes, reference and stiffness.

With the scale S from global to element coordinates, e = S q, and the force f = S (ds/dg)^T N of the resultants N, a dash for the
derivative by the parameter and y the change of g that belongs to e' = S' q,

    f' = S' (ds/dg)^T N + S ((ds/dg)^T N' + (d(ds/dg))^T N),      N' = C (s' + c sdot') + C' (s + c sdot)

where s' = (ds/dg) y less the change of the reference's constants, and sdot' = (dsdot/dg) y + (ds/dg) y' with the change y' that
belongs to S' v. It costs as much as two forces, and loses no digits where the parameter stretches the membrane, as the difference
of forces does. Where coordinates and velocities follow the parameter by q' and v', e' = S' q + S q' and S' v + S v' take their
place: that saves the product of the tangent with q'. The potential W = 1/2 s.C s changes by W' = N.s' + 1/2 s.C' s.
"""

from __future__ import annotations

from lamella._jit import inlined, kernel, shared
from lamella.element.plate48.damping_kernels import strain_rates, weighted6
from lamella.element.plate48.interpolation import (
    constants_at,
    interpolate_eta,
    interpolate_xi,
    reference,
    spread_eta,
    spread_xi,
    stiffness,
)
from lamella.element.plate48.strain import (
    Cubed,
    energy_density,
    gradient,
    normal_change,
    resultants,
    strains,
    surface_frame,
)
from lamella.element.plate48.tangent_product import (
    Time,
    frame_change,
    gradient_change,
    keep_point,
    keep_rates,
    point_size,
    rates_change,
    summed,
)
from lamella.lane import WIDTH, load, number_at, put_at, spread, store
from lamella.roles import Floats, Ints


def work_size(n: int) -> int:
    """Lanes of work space: coordinates and their changes, and six sets of sums on lines."""
    return 96 + 6 * 36 * n


@inlined
def _gather_both(
    q: Floats, dq: Floats, moves: bool, scaled: bool, index: Ints, scale_change: Floats, scale: Floats, block: int, work: Floats
) -> None:
    """S q to the beginning of ``work``; behind it S' q if the scale changes, and S dq with it if coordinates move."""
    first, beside = 48 * WIDTH * block, 48 * WIDTH
    for k in range(48 * WIDTH):
        at = number_at(index, first + k)
        here, factor, change = number_at(q, at), number_at(scale, first + k), 0.0
        if scaled:
            change = number_at(scale_change, first + k) * here
        if moves:
            change += number_at(dq, at) * factor
        put_at(work, k, here * factor)
        put_at(work, beside + k, change)


@shared
def reference_change(
    q: Floats,
    v: Floats,
    dq: Floats,
    dv: Floats,
    moves: bool,
    time: Time,
    elastic: bool,
    scaled: bool,
    scale_change: Floats,
    share: Floats,
    change: Floats,
    index: Ints,
    scale: Floats,
    sections: Floats,
    table: Floats,
    n: int,
    cubed: Cubed,
    work: Floats,
    points: Floats,
    f: Floats,
) -> None:
    """f' / S, f (block, 48), of the viscous force with retardation time c = ``time``, of the elastic one, or of both; without a
    retardation time of the elastic one.

    Args:
        dq, dv: how coordinates and velocities follow the parameter, if they do (``moves``).
        scaled: whether the scale changes; where it does not, coordinates must move.
        scale_change, share: S' and S' / S, packed as ``scale`` is.
        change: of the sections.
        points: keeps what products with the tangent here need, with alpha_q = 1, as :func:`.tangent_product.tangent_points` does,
            unless it is empty.
        others: as in :mod:`lamella.element.plate48.kernels`.
    """
    lines, beside, rates, rates_beside, sums = 96, 96 + 36 * n, 96 + 72 * n, 96 + 108 * n, 96 + 144 * n
    more = sums + 36 * n
    keeps, size = len(points) > 0, point_size(time)
    for block in range(index.size // (48 * WIDTH)):
        _gather_both(q, dq, moves, scaled, index, scale_change, scale, block, work)
        interpolate_eta(work, 0, lines, table, n)
        interpolate_eta(work, 48, beside, table, n)
        if time is not None:
            _gather_both(v, dv, moves, scaled, index, scale_change, scale, block, work)
            interpolate_eta(work, 0, rates, table, n)
            interpolate_eta(work, 48, rates_beside, table, n)
        for j in range(n):
            for i in range(n):
                g, y = interpolate_xi(work, lines, table, i, j), interpolate_xi(work, beside, table, i, j)
                at, to = constants_at(sections, block, n, i, j), ((block * n + j) * n + i) * size
                c, dc = stiffness(sections, at), stiffness(change, at)
                m, d1, d2 = frame = surface_frame(g[0], g[1], cubed)
                turned = frame_change(y, frame, cubed)
                s, ds = strains(g, m, reference(sections, at)), strain_rates(g, y, m, turned[0])
                ds = weighted6(1.0, ds, -1.0, reference(change, at))
                if time is not None:
                    weight = 1.0 if elastic else 0.0
                    g_rate, y_rate = interpolate_xi(work, rates, table, i, j), interpolate_xi(work, rates_beside, table, i, j)
                    m_rate = normal_change(g_rate[0], g_rate[1], m, d1, d2, cubed)
                    s = weighted6(weight, s, time, strain_rates(g, g_rate, m, m_rate))
                    ds = weighted6(weight, ds, time, rates_change(g, g_rate, y, m_rate, frame, turned, cubed))
                    if keeps:
                        keep_rates(points, to, g_rate, m_rate)
                    m_rate = normal_change(y_rate[0], y_rate[1], m, d1, d2, cubed)
                    ds = weighted6(1.0, ds, time, strain_rates(g, y_rate, m, m_rate))
                res = resultants(c, s)
                if keeps:
                    keep_point(points, to, g, res)
                dres = weighted6(1.0, resultants(c, ds), 1.0, resultants(dc, s))
                if scaled:
                    spread_xi(gradient(g, m, d1, d2, res, cubed), work, sums + j * 36, table, i, i == 0)
                h = summed(gradient(g, m, d1, d2, dres, cubed), gradient_change(g, y, res, frame, turned, cubed))
                spread_xi(h, work, more + j * 36, table, i, i == 0)
        if not scaled:
            spread_eta(work, more, table, n, f, block * 48)
            continue
        spread_eta(work, sums, table, n, f, block * 48)
        spread_eta(work, more, table, n, work, 0)
        for k in range(48):
            store(f, block * 48 + k, load(work, k) + load(share, block * 48 + k) * load(f, block * 48 + k))


@kernel
def energy_change(
    q: Floats,
    dq: Floats,
    scaled: bool,
    scale_change: Floats,
    change: Floats,
    index: Ints,
    scale: Floats,
    sections: Floats,
    table: Floats,
    n: int,
    cubed: Cubed,
    work: Floats,
    out: Floats,
    changes: Floats,
) -> None:
    """W of each element, out (block,), and W', changes (block,), with coordinates that follow the parameter by ``dq``.

    Arguments as above.
    """
    lines, beside = 96, 96 + 36 * n
    for block in range(index.size // (48 * WIDTH)):
        _gather_both(q, dq, True, scaled, index, scale_change, scale, block, work)
        interpolate_eta(work, 0, lines, table, n)
        interpolate_eta(work, 48, beside, table, n)
        total, total_change = spread(0.0), spread(0.0)
        for j in range(n):
            for i in range(n):
                g, y = interpolate_xi(work, lines, table, i, j), interpolate_xi(work, beside, table, i, j)
                at = constants_at(sections, block, n, i, j)
                m, d1, d2 = surface_frame(g[0], g[1], cubed)
                s = strains(g, m, reference(sections, at))
                ds = strain_rates(g, y, m, normal_change(y[0], y[1], m, d1, d2, cubed))
                ds = weighted6(1.0, ds, -1.0, reference(change, at))
                c = stiffness(sections, at)
                more = weighted6(2.0, resultants(c, ds), 1.0, resultants(stiffness(change, at), s))
                total, total_change = total + energy_density(resultants(c, s), s), total_change + energy_density(more, s)
        store(out, block, total)
        store(changes, block, total_change)
