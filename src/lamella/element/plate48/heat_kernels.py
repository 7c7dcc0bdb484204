"""Heated Plate48, a lane of elements at a time: thermal strain, its force by temperature, and flux that follows the normal.

Temperatures are bilinear on an element: T_N at its four nodes, then T_M, eight values ordered (field, b, a) with node (a, b) at
xi = a, eta = b. Layouts are those of :mod:`lamella.element.plate48.kernels`, and

    corners    (point, 2)             1 - s and s at the Gauss points of one direction
    strain     (block, point, 2, 6)   thermal strains s_T for T_N = 1 and for T_M = 1, in the parameters
    stress     (block, point, 2, 6)   C s_T with weight: thermal resultants
"""

from __future__ import annotations

from lamella._jit import inlined, njit
from lamella.element.plate48.interpolation import N_SECTION, gather, interpolate_eta, interpolate_xi, spread_eta, spread_xi
from lamella.element.plate48.strain import Cubed, Vector, dot, gradient, scaled, surface_frame
from lamella.lane import WIDTH, load, spread, sqrt, store
from lamella.roles import Floats, Ints


@inlined
def _corner(corners: Floats, i: int, j: int, k: int) -> float:
    """Bilinear function of node k = 2 b + a at Gauss point (i, j)."""
    return corners[2 * i + k % 2] * corners[2 * j + k // 2]


@njit
def set_reference(
    q: Floats, index: Ints, corners: Floats, n: int, cold: Floats, strain: Floats, work: Floats, sections: Floats
) -> None:
    """The six reference constants of each Gauss point: those without heat, cold (block, point, 6), plus the thermal strain."""
    for block in range(index.size // (8 * WIDTH)):
        for k in range(8 * WIDTH):
            work[k] = q[index[8 * WIDTH * block + k]]
        for j in range(n):
            for i in range(n):
                point = (block * n + j) * n + i
                mean, slope = spread(0.0), spread(0.0)
                for k in range(4):
                    w = _corner(corners, i, j, k)
                    mean, slope = mean + w * load(work, k), slope + w * load(work, 4 + k)
                for m in range(6):
                    warm = load(strain, 12 * point + m) * mean + load(strain, 12 * point + 6 + m) * slope
                    store(sections, N_SECTION * point + 21 + m, load(cold, 6 * point + m) + warm)


@inlined
def _scaled5(w: float, h: tuple[Vector, ...]) -> tuple[Vector, ...]:
    return (scaled(w, h[0]), scaled(w, h[1]), scaled(w, h[2]), scaled(w, h[3]), scaled(w, h[4]))


@inlined
def _six(array: Floats, at: int) -> tuple[Floats, ...]:
    return (
        load(array, at), load(array, at + 1), load(array, at + 2), load(array, at + 3), load(array, at + 4), load(array, at + 5),
    )  # fmt: skip


@njit
def thermal_tangent(
    q: Floats, index: Ints, scale: Floats, table: Floats, corners: Floats, n: int, cubed: Cubed, stress: Floats, factor: float,
    work: Floats, k: Floats,
) -> None:  # fmt: skip
    """-factor (ds/dq)^T C ds_T/dT, k (block, 8, 48): the derivative of the elastic force by each temperature."""
    lines, sums = 48, 48 + 36 * n
    for block in range(index.size // (48 * WIDTH)):
        gather(q, index, scale, block, work, 0)
        interpolate_eta(work, 0, lines, table, n)
        for j in range(n):
            for i in range(n):
                at = 12 * ((block * n + j) * n + i)
                g = interpolate_xi(work, lines, table, i, j)
                normal, d1, d2 = surface_frame(g[0], g[1], cubed)
                mean = gradient(g, normal, d1, d2, _six(stress, at), cubed)
                slope = gradient(g, normal, d1, d2, _six(stress, at + 6), cubed)
                for m in range(4):
                    w = -factor * _corner(corners, i, j, m)
                    spread_xi(_scaled5(w, mean), work, sums + m * 36 * n + 36 * j, table, i, i == 0)
                    spread_xi(_scaled5(w, slope), work, sums + (4 + m) * 36 * n + 36 * j, table, i, i == 0)
        for m in range(8):
            spread_eta(work, sums + m * 36 * n, table, n, k, (8 * block + m) * 48)


def thermal_work_size(n: int) -> int:
    """Lanes of work space for n x n Gauss points."""
    return 48 + 9 * 36 * n


@inlined
def _lit(x: Floats, width: float) -> tuple[Floats, Floats]:
    """A smooth max(x, 0), (x + sqrt(x^2 + width^2)) / 2, and its derivative."""
    root = sqrt(x * x + width * width)
    return 0.5 * (x + root), 0.5 + 0.5 * x / root


@njit
def solar_flux(
    q: Floats, index: Ints, scale: Floats, table: Floats, corners: Floats, n: int, area: Floats, light: Floats,
    upper: Floats, lower: Floats, width: float, work: Floats, f: Floats, absorbed: Floats,
) -> None:  # fmt: skip
    """Heat that light brings to the temperatures, f (block, 8) with negative sign, and absorbed (block,) [W].

    Args:
        area: weight of each Gauss point, (block, point).
        light: direction in which the light travels, times the flux, (3,).
        upper, lower: what a unit flux absorbed on the side z > 0 (z < 0) gives to T_N and T_M, times absorptivity, (2,).
        width: smoothing of the switch between the sides.
    """
    flux = sqrt(light[0] * light[0] + light[1] * light[1] + light[2] * light[2])
    for block in range(index.size // (48 * WIDTH)):
        gather(q, index, scale, block, work, 0)
        interpolate_eta(work, 0, 48, table, n)
        for m in range(8):
            store(f, 8 * block + m, spread(0.0))
        total = spread(0.0)
        for j in range(n):
            for i in range(n):
                a = load(area, (block * n + j) * n + i)
                g = interpolate_xi(work, 48, table, i, j)
                n0 = surface_frame(g[0], g[1])[0]
                x = -(light[0] * n0[0] + light[1] * n0[1] + light[2] * n0[2])
                top, bottom = a * _lit(x, width * flux)[0], a * _lit(-x, width * flux)[0]
                mean, slope = upper[0] * top + lower[0] * bottom, upper[1] * top + lower[1] * bottom
                total = total + mean
                for m in range(4):
                    w, at = _corner(corners, i, j, m), 8 * block + m
                    store(f, at, load(f, at) - w * mean)
                    store(f, at + 4, load(f, at + 4) - w * slope)
        store(absorbed, block, total)


@njit
def solar_tangent(
    q: Floats, index: Ints, scale: Floats, table: Floats, corners: Floats, n: int, area: Floats, light: Floats,
    upper: Floats, lower: Floats, width: float, factor: float, work: Floats, k: Floats,
) -> None:  # fmt: skip
    """factor df/dq of :func:`solar_flux`, k (block, 8, 48): d(-light.n0) = (light.d_i)(n0.dr_i)."""
    flux = sqrt(light[0] * light[0] + light[1] * light[1] + light[2] * light[2])
    lines, sums = 48, 48 + 36 * n
    for block in range(index.size // (48 * WIDTH)):
        gather(q, index, scale, block, work, 0)
        interpolate_eta(work, 0, lines, table, n)
        zero = (spread(0.0), spread(0.0), spread(0.0))
        for j in range(n):
            for i in range(n):
                a = load(area, (block * n + j) * n + i)
                g = interpolate_xi(work, lines, table, i, j)
                n0, d1, d2 = surface_frame(g[0], g[1])
                s = (light[0], light[1], light[2])
                x = -dot(s, n0)
                top, bottom = a * _lit(x, width * flux)[1], a * _lit(-x, width * flux)[1]
                h = (scaled(dot(s, d1), n0), scaled(dot(s, d2), n0), zero, zero, zero)
                for field in range(2):
                    by_angle = upper[field] * top - lower[field] * bottom
                    for m in range(4):
                        w = -factor * _corner(corners, i, j, m) * by_angle
                        at = sums + (4 * field + m) * 36 * n + 36 * j
                        spread_xi(_scaled5(w, h), work, at, table, i, i == 0)
        for m in range(8):
            spread_eta(work, sums + m * 36 * n, table, n, k, (8 * block + m) * 48)
