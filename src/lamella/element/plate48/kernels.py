"""Loops over elements and Gauss points of Plate48: energy, force and tangent of eight elements at a time.

The shape functions are products phi_a(xi) phi_b(eta) of cubic Hermite polynomials, so that all sums over functions and Gauss
points are done one direction after the other (sum factorisation). Element coordinates are ordered (a, b, component); arrays are
flat and hold groups of eight numbers, one for each element of a block:

    sections   (block, Gauss point, 27, 8)   21 upper entries of the stiffness, with weight, and 6 constants of the reference
    index      (block, 48, 8)                global coordinate of each element coordinate
    scale      (block, 48, 8)                factor from global to element coordinates
    table      (point, derivative 0 1 2, 4)  cubic Hermite polynomials at the Gauss points
    work       see :func:`work_size`
"""

from __future__ import annotations

from lamella._jit import njit
from lamella.element.plate48.contraction import contract_eta, contract_xi
from lamella.element.plate48.hessian import hessian_factors, store_hessian
from lamella.element.plate48.interpolation import (
    N_SECTION,
    gather,
    interpolate_eta,
    interpolate_xi,
    reference,
    spread_eta,
    spread_xi,
    stiffness,
)
from lamella.element.plate48.strain import (
    energy_density,
    extrapolated_strains,
    gradient,
    resultants,
    strains,
    surface_frame,
)
from lamella.lane import spread, store
from lamella.roles import Floats, Ints


@njit
def energy(q: Floats, index: Ints, scale: Floats, sections: Floats, table: Floats, n: int, work: Floats, out: Floats) -> None:
    """Strain energy of each element, out (block, 8)."""
    for block in range(index.size // 384):
        gather(q, index, scale, block, work, 0)
        interpolate_eta(work, 0, 384, table, n)
        total = spread(0.0)
        for j in range(n):
            for i in range(n):
                g = interpolate_xi(work, 384, table, i, j)
                at = ((block * n + j) * n + i) * N_SECTION * 8
                n0 = surface_frame(g[0], g[1])[0]
                s = strains(g, n0, reference(sections, at))
                total = total + energy_density(resultants(stiffness(sections, at), s), s)
        store(out, block * 8, total)


@njit
def force(q: Floats, index: Ints, scale: Floats, sections: Floats, table: Floats, n: int, work: Floats, f: Floats) -> None:
    """Elastic force dW/de, f (block, 48, 8)."""
    sums = 384 + 288 * n
    for block in range(index.size // 384):
        gather(q, index, scale, block, work, 0)
        interpolate_eta(work, 0, 384, table, n)
        for j in range(n):
            for i in range(n):
                g = interpolate_xi(work, 384, table, i, j)
                at = ((block * n + j) * n + i) * N_SECTION * 8
                n0, d1, d2 = surface_frame(g[0], g[1])
                s = strains(g, n0, reference(sections, at))
                h = gradient(g, n0, d1, d2, resultants(stiffness(sections, at), s))
                spread_xi(h, work, sums + j * 288, table, i, i == 0)
        spread_eta(work, sums, table, n, f, block * 384)


@njit
def _points_of_block(
    sections: Floats, block: int, table: Floats, n: int, work: Floats, lines: int, previous: int, sums: int, hessian: int
) -> None:
    """Gradients and Hessians at the Gauss points of a block; previous < 0 takes the resultants at the state itself."""
    step = n * n * 200
    for j in range(n):
        for i in range(n):
            g = interpolate_xi(work, lines, table, i, j)
            at = ((block * n + j) * n + i) * N_SECTION * 8
            c, constants = stiffness(sections, at), reference(sections, at)
            n0, d1, d2 = surface_frame(g[0], g[1])
            res = resultants(c, strains(g, n0, constants))
            spread_xi(gradient(g, n0, d1, d2, res), work, sums + j * 288, table, i, i == 0)
            if previous >= 0:
                g_previous = interpolate_xi(work, previous, table, i, j)
                res = resultants(c, extrapolated_strains(g, g_previous, constants))
            store_hessian(work, hessian + (i * n + j) * 200, step, hessian_factors(g, n0, d1, d2, c, res), c, res)


@njit
def force_tangent(
    q: Floats,
    q_previous: Floats,
    extrapolate: bool,
    index: Ints,
    scale: Floats,
    sections: Floats,
    table: Floats,
    n: int,
    work: Floats,
    f: Floats,
    k: Floats,
) -> None:
    """Elastic force, f (block, 48, 8), and upper triangle of its tangent, k (block, 1176, 8).

    With ``extrapolate``, the resultants of the geometric part are extrapolated from ``q_previous``.
    """
    lines = 384
    previous = lines + 288 * n if extrapolate else -1
    sums = lines + 576 * n
    z = sums + 288 * n
    partial = z + 120 * n
    hessian = partial + 1152 * n
    position = 0
    for block in range(index.size // 384):
        gather(q, index, scale, block, work, 0)
        interpolate_eta(work, 0, lines, table, n)
        if extrapolate:
            gather(q_previous, index, scale, block, work, 0)
            interpolate_eta(work, 0, previous, table, n)
        _points_of_block(sections, block, table, n, work, lines, previous, sums, hessian)
        spread_eta(work, sums, table, n, f, block * 384)
        for pair in range(6):
            symmetric = pair == 0 or pair == 3 or pair == 5
            for i in range(n):
                contract_eta(work, hessian + (pair * n + i) * n * 200, z, partial, table, n, i, symmetric)
            position = contract_xi(work, partial, table, n, k, position, symmetric)


def work_size(n: int) -> int:
    """Numbers of work space for n x n Gauss points: coordinates, three sets of sums on lines, contraction buffers, Hessians."""
    return 384 + 3 * 288 * n + 120 * n + 1152 * n + 6 * n * n * 200
