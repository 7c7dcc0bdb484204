"""Loops over elements and Gauss points of Plate48: energy, force and tangent for a lane of elements at a time.

The shape functions are products phi_a(xi) phi_b(eta) of cubic Hermite polynomials, so that all sums over functions and Gauss
points are done one direction after the other (sum factorisation). Element coordinates are ordered (a, b, component); arrays are
flat and hold lanes of numbers, one for each element of a block, and are counted in lanes (``WIDTH`` numbers):

    sections   (block, Gauss point, 27)       21 upper entries of the stiffness, with weight, and 6 constants of the reference
    index      (block, 48)                    global coordinate of each element coordinate
    scale      (block, 48)                    factor from global to element coordinates
    table      (point, derivative 0 1 2, 4)  cubic Hermite polynomials at the Gauss points
    cubed      the normal that measures curvature, see :mod:`lamella.element.plate48.strain`
    work       see :func:`work_size`
"""

from __future__ import annotations

from lamella._jit import inner, kernel, shared
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
    energy_density,
    extrapolated_strains,
    gradient,
    resultants,
    strains,
    surface_frame,
)
from lamella.lane import WIDTH, spread, store
from lamella.roles import Floats, Ints


@kernel
def energy(
    q: Floats, index: Ints, scale: Floats, sections: Floats, table: Floats, n: int, cubed: Cubed, work: Floats, out: Floats
) -> None:
    """Strain energy of each element, out (block,)."""
    for block in range(index.size // (48 * WIDTH)):
        gather(q, index, scale, block, work, 0)
        interpolate_eta(work, 0, 48, table, n)
        total = spread(0.0)
        for j in range(n):
            for i in range(n):
                g = interpolate_xi(work, 48, table, i, j)
                at = constants_at(sections, block, n, i, j)
                m = surface_frame(g[0], g[1], cubed)[0]
                s = strains(g, m, reference(sections, at))
                total = total + energy_density(resultants(stiffness(sections, at), s), s)
        store(out, block, total)


@shared
def force(
    q: Floats, index: Ints, scale: Floats, sections: Floats, table: Floats, n: int, cubed: Cubed, work: Floats, f: Floats
) -> None:
    """Elastic force dW/de, f (block, 48)."""
    sums = 48 + 36 * n
    for block in range(index.size // (48 * WIDTH)):
        gather(q, index, scale, block, work, 0)
        interpolate_eta(work, 0, 48, table, n)
        for j in range(n):
            for i in range(n):
                g = interpolate_xi(work, 48, table, i, j)
                at = constants_at(sections, block, n, i, j)
                m, d1, d2 = surface_frame(g[0], g[1], cubed)
                s = strains(g, m, reference(sections, at))
                h = gradient(g, m, d1, d2, resultants(stiffness(sections, at), s), cubed)
                spread_xi(h, work, sums + j * 36, table, i, i == 0)
        spread_eta(work, sums, table, n, f, block * 48)


@inner
def _points_of_block(
    sections: Floats,
    block: int,
    table: Floats,
    n: int,
    cubed: Cubed,
    work: Floats,
    lines: int,
    previous: int,
    sums: int,
    hessian: int,
) -> None:
    """Gradients and Hessians at the Gauss points of a block; previous < 0 takes the resultants at the state itself."""
    step = n * n * 25
    for j in range(n):
        for i in range(n):
            g = interpolate_xi(work, lines, table, i, j)
            at = constants_at(sections, block, n, i, j)
            c, constants = stiffness(sections, at), reference(sections, at)
            m, d1, d2 = surface_frame(g[0], g[1], cubed)
            res = resultants(c, strains(g, m, constants))
            spread_xi(gradient(g, m, d1, d2, res, cubed), work, sums + j * 36, table, i, i == 0)
            if previous >= 0:
                g_previous = interpolate_xi(work, previous, table, i, j)
                res = resultants(c, extrapolated_strains(g, g_previous, constants, cubed))
            store_hessian(work, hessian + (i * n + j) * 25, step, g, m, d1, d2, c, res, cubed)


@shared
def force_tangent(
    q: Floats,
    q_previous: Floats,
    extrapolate: bool,
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
    """Elastic force, f (block, 48), and upper triangle of its tangent, k (block, 1176).

    With ``extrapolate``, the resultants of the geometric part are extrapolated from ``q_previous``.
    """
    lines = 48
    previous = lines + 36 * n if extrapolate else -1
    sums = lines + 72 * n
    z = sums + 36 * n
    partial = z + 15 * n
    hessian = partial + 144 * n
    position = 0
    for block in range(index.size // (48 * WIDTH)):
        gather(q, index, scale, block, work, 0)
        interpolate_eta(work, 0, lines, table, n)
        if extrapolate:
            gather(q_previous, index, scale, block, work, 0)
            interpolate_eta(work, 0, previous, table, n)
        _points_of_block(sections, block, table, n, cubed, work, lines, previous, sums, hessian)
        spread_eta(work, sums, table, n, f, block * 48)
        for pair in range(6):
            symmetric = pair == 0 or pair == 3 or pair == 5
            for i in range(n):
                contract_eta(work, hessian + (pair * n + i) * n * 25, z, partial, table, n, i, symmetric)
            position = contract_xi(work, partial, table, n, k, position, symmetric)


def work_size(n: int) -> int:
    """Lanes of work space for n x n Gauss points: coordinates, three sets of sums on lines, contraction buffers, Hessians."""
    return 48 + 3 * 36 * n + 15 * n + 144 * n + 6 * n * n * 25
