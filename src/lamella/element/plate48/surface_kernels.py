"""Compiled loops over the points of a reference surface."""

from __future__ import annotations

import math

from lamella._jit import inlined, kernel
from lamella.lane import WIDTH
from lamella.roles import Floats

NO_AREA = 1e-6
"""Sine of the angle between r_x and r_y below which a point has no area."""


@inlined
def cross(a: Floats, b: Floats) -> tuple[float, float, float]:
    """a x b."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@inlined
def dot(a: Floats, b: Floats | tuple[float, float, float]) -> float:
    """a . b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@kernel
def areas(derivatives: Floats, area: Floats) -> None:
    """|r_x x r_y| from r_x and r_y (2, n, 3); -1 where they are parallel."""
    for k in range(len(area)):
        r_x, r_y = derivatives[0, k], derivatives[1, k]
        n = cross(r_x, r_y)
        size = math.sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2])
        area[k] = size if size > NO_AREA * math.sqrt(dot(r_x, r_x) * dot(r_y, r_y)) else -1.0


@kernel
def measure(derivatives: Floats, area: Floats, first: Floats, second: Floats) -> None:
    """Area (n,), metric A11, A22, A12 (n, 3) and curvature B11, B22, B12 (n, 3).

    Args:
        derivatives: r, r_x, r_y, r_xx, r_xy, r_yy, shape (6, n, 3).
        area, first, second: results; an area is -1 where r_x and r_y are parallel.
    """
    for k in range(len(area)):
        r_x, r_y = derivatives[1, k], derivatives[2, k]
        n = cross(r_x, r_y)
        size = math.sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2])
        first[k, 0], first[k, 1], first[k, 2] = dot(r_x, r_x), dot(r_y, r_y), dot(r_x, r_y)
        if not size > NO_AREA * math.sqrt(first[k, 0] * first[k, 1]):
            area[k] = -1.0
            continue
        area[k] = size
        second[k, 0] = dot(derivatives[3, k], n) / size
        second[k, 1] = dot(derivatives[5, k], n) / size
        second[k, 2] = dot(derivatives[4, k], n) / size


@kernel
def strain_transforms(first: Floats, area: Floats, axis: Floats, transform: Floats) -> None:
    """T (n, 3, 3) for local frames whose first axis has the direction axis[0] r_x + axis[1] r_y; see :mod:`.surface`."""
    for k in range(len(area)):
        alpha, beta = axis[0, k], axis[1, k]
        along_x, along_y = alpha * first[k, 0] + beta * first[k, 2], alpha * first[k, 2] + beta * first[k, 1]
        length = math.sqrt(alpha * along_x + beta * along_y)
        a, b, c, d = alpha / length, beta / length, -along_y / (area[k] * length), along_x / (area[k] * length)
        T = transform[k]
        T[0, 0], T[0, 1], T[0, 2] = a * a, b * b, a * b
        T[1, 0], T[1, 1], T[1, 2] = c * c, d * d, c * d
        T[2, 0], T[2, 1], T[2, 2] = 2 * a * c, 2 * b * d, a * d + b * c


@kernel
def find_folds(r_xi: Floats, r_eta: Floats, degenerate: float, normals: Floats) -> tuple[int, int]:
    """Where elements degenerate or fold.

    Args:
        r_xi, r_eta: tangents at the same points of every element, shape (n_point, n_element, 3).
        degenerate: smallest sine of the angle between them.
        normals: workspace (n_point, 3).

    Returns:
        The first places element * n_point + point where the tangents are parallel or vanish, and where the normal turns from
        the element's mean; -1 where there is none.
    """
    thin = turned = -1
    n_point, n_element = r_xi.shape[0], r_xi.shape[1]
    for element in range(n_element):
        sum_x = sum_y = sum_z = 0.0
        for point in range(n_point):
            a, b = r_xi[point, element], r_eta[point, element]
            x, y, z = cross(a, b)
            sum_x, sum_y, sum_z = sum_x + x, sum_y + y, sum_z + z
            normals[point, 0], normals[point, 1], normals[point, 2] = x, y, z
            limit = degenerate * math.sqrt(dot(a, a) * dot(b, b))
            if thin < 0 and not math.sqrt(x * x + y * y + z * z) > limit:
                thin = element * n_point + point
        for point in range(n_point):
            along = normals[point, 0] * sum_x + normals[point, 1] * sum_y + normals[point, 2] * sum_z
            if turned < 0 and along <= 0.0:
                turned = element * n_point + point
    return thin, turned


N_STIFFNESS = 21
"""Numbers of the stiffness of a Gauss point, its upper triangle."""
N_SECTION = 27
"""All numbers of a Gauss point: behind the stiffness six constants of the surface."""


@inlined
def _multiply(C: Floats, row: int, col: int, T: Floats, out: Floats) -> None:
    """out <- C[row : row + 3, col : col + 3] T."""
    for i in range(3):
        for j in range(3):
            out[i, j] = C[row + i, col] * T[0, j] + C[row + i, col + 1] * T[1, j] + C[row + i, col + 2] * T[2, j]


@kernel
def pack_sections(
    transform: Floats, stiffness: Floats, factor: Floats, bending: Floats, constants: Floats, work: Floats, sections: Floats
) -> None:
    """Constants of the Gauss points for the kernels: F^T C F with F = diag(T, b T diag(1, 1, 2)), and those of the surface.

    Args:
        transform: T, shape (n_element, n_point, 3, 3).
        stiffness: C of (eps, kap), shape (1 or n_element, 6, 6).
        factor: factor of the stiffness, shape (n_element, n_point).
        bending: b, shape (n_element, n_point).
        constants: of the surface, shape (n_element, n_point, 6).
        work: workspace (3, 3).
        sections: result: (block, point, number, WIDTH), flat; the last element is repeated.
    """
    n_element, n_point = factor.shape[0], factor.shape[1]
    for k in range(len(sections) // (n_point * N_SECTION)):
        e = min(k, n_element - 1)
        C = stiffness[min(e, len(stiffness) - 1)]
        for g in range(n_point):
            T, x, b = transform[e, g], factor[e, g], bending[e, g]
            at = ((k // WIDTH * n_point + g) * N_SECTION) * WIDTH + k % WIDTH
            for part in range(3):  # membrane, coupling, bending
                row, col = 3 * (part // 2), 3 * ((part + 1) // 2)
                _multiply(C, row, col, T, work)
                for i in range(3):
                    for j in range(0 if part == 1 else i, 3):
                        value = x * (T[0, i] * work[0, j] + T[1, i] * work[1, j] + T[2, i] * work[2, j])
                        if row:
                            value *= 2.0 * b if i == 2 else b
                        if col:
                            value *= 2.0 * b if j == 2 else b
                        r = row + i
                        sections[at + (r * (11 - r) // 2 + col + j) * WIDTH] = value
            for i in range(6):
                sections[at + (N_STIFFNESS + i) * WIDTH] = constants[e, g, i]
