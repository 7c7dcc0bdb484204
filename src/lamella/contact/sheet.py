"""The points of a shell that may touch, as arrays for the kernels, and where they are."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from lamella._jit import inlined
from lamella.contact.gap import CYLINDER, PLANE, Obstacle, positive
from lamella.element.plate48.strain import Vector, combined, dot
from lamella.lane import WIDTH, aligned, chosen, load_at, number_at, spread, sqrt, store_at
from lamella.math.gauss import gauss_rule
from lamella.roles import Floats, Ints

if TYPE_CHECKING:
    from lamella.body.mesh import PlateMesh

N_GAUSS = 3
"""Gauss points in each direction for the area of a cell."""


class Sheet(NamedTuple):
    """Arrays of a shell.

    Args:
        coords: coordinate of each element vector's component, (element, vector, component) flat.
        scale: factor from global to element coordinates, (element, vector) flat.
        columns: shape functions, (vector, point) flat, points filled up to whole lanes by the last one.
        rows: the same as (point, vector), vectors filled up.
        area: reference area of each point [m^2], (element, point) flat.
        areas: the same with points filled up by zeros.
        half_thickness: of each element [m].
        is_corner: 1 for positions, 0 for other vectors, filled up to whole lanes.
        largest: largest value of each shape function at the points.
        corners: largest sum of the values of the functions of positions.
        n_element, n_vector, n_point: counts.
        vectors, points: counts filled up to whole lanes.
        per_node: vectors at a node, the first of which is the position.
    """

    coords: Ints
    scale: Floats
    columns: Floats
    rows: Floats
    area: Floats
    areas: Floats
    half_thickness: Floats
    is_corner: Floats
    largest: Floats
    corners: float
    n_element: int
    n_vector: int
    n_point: int
    vectors: int
    points: int
    per_node: int


def places(n: int) -> tuple[Floats, Floats]:
    """xi, eta of the midpoints of n x n cells of the unit square, xi fastest, shapes (n n,)."""
    middle = (np.arange(n) + 0.5) / n
    return np.tile(middle, n), np.repeat(middle, n)


def sheet_of(mesh: PlateMesh, n: int) -> Sheet:
    """The n x n points of each element of a shell: midpoints of equal cells, each with the reference area of its cell."""
    n_element, n_vector = len(mesh.coords), mesh.element.n_shape
    S = mesh.element.shape(*places(n))[0]
    vectors, points = -(-n_vector // WIDTH) * WIDTH, -(-n * n // WIDTH) * WIDTH
    columns, rows = aligned(n_vector * points), aligned(n * n * vectors)
    columns.reshape(n_vector, points)[:] = np.concatenate([S, np.repeat(S[-1:], points - n * n, axis=0)]).T
    rows.reshape(n * n, vectors)[:, :n_vector] = S
    factors = np.ones(n_element) if mesh.thickness_factors is None else mesh.thickness_factors
    largest, per_node = np.abs(S).max(axis=0), mesh.element.vectors_per_node
    area, is_corner = cell_areas(mesh, n), aligned(vectors)
    is_corner[:n_vector:per_node] = 1.0
    return Sheet(
        np.ascontiguousarray(mesh.coords).reshape(-1),
        np.ascontiguousarray(mesh.scale[:, ::3]).reshape(-1),
        columns,
        rows,
        area.reshape(-1),
        _filled_up(area, points),
        0.5 * mesh.laminate.h * factors,
        is_corner,
        largest,
        float(np.abs(S[:, ::per_node]).sum(axis=1).max()),
        n_element,
        n_vector,
        n * n,
        vectors,
        points,
        per_node,
    )


def _filled_up(values: Floats, points: int) -> Floats:
    """(element, point) with points filled up by zeros, flat."""
    out = aligned(len(values) * points)
    out.reshape(-1, points)[:, : values.shape[1]] = values
    return out


def cell_areas(mesh: PlateMesh, n: int) -> Floats:
    """Reference area of each of n x n cells of the elements [m^2], shape (n_element, n n)."""
    s, w = gauss_rule(N_GAUSS)
    fine = (np.arange(n)[:, None] + s).reshape(-1) / n
    S_xi, S_eta = mesh.element.shape(np.tile(fine, len(fine)), np.repeat(fine, len(fine)))[1:3]
    vectors = (mesh.reference * mesh.scale).reshape(len(mesh.reference), -1, 3)
    density = np.linalg.norm(np.cross(np.einsum("pa,eac->epc", S_xi, vectors), np.einsum("pa,eac->epc", S_eta, vectors)), axis=-1)
    cells = density.reshape(-1, n, N_GAUSS, n, N_GAUSS)
    return np.einsum("ejaib,a,b->eji", cells, w / n, w / n).reshape(len(vectors), -1)


@inlined
def gather(q: Floats, sheet: Sheet, element: int, work: Floats, to: int) -> None:
    """Scaled vectors of an element to work[to:], (component, vector)."""
    n, first = sheet.n_vector, element * sheet.n_vector
    for k in range(n):
        factor = number_at(sheet.scale, first + k)
        for c in range(3):
            work[to + c * n + k] = factor * number_at(q, number_at(sheet.coords, 3 * (first + k) + c))


@inlined
def interpolate(sheet: Sheet, work: Floats, source: int, to: int) -> None:
    """Vectors of an element at its points, to work[to:], (component, point); two vectors at a time, whose sums do not wait."""
    n, points = sheet.n_vector, sheet.points
    for p in range(0, points, WIDTH):
        x, y, z = spread(0.0), spread(0.0), spread(0.0)
        u, v, w = spread(0.0), spread(0.0), spread(0.0)
        for k in range(source, source + n, 2):
            at = (k - source) * points + p
            S, T = load_at(sheet.columns, at), load_at(sheet.columns, at + points)
            x, y, z = x + number_at(work, k) * S, y + number_at(work, k + n) * S, z + number_at(work, k + 2 * n) * S
            u, v, w = u + number_at(work, k + 1) * T, v + number_at(work, k + n + 1) * T, w + number_at(work, k + 2 * n + 1) * T
        store_at(work, to + p, x + u)
        store_at(work, to + points + p, y + v)
        store_at(work, to + 2 * points + p, z + w)


@inlined
def _extent(kind: int, u: Vector, a: Vector) -> Any:
    """Length of what counts of a vector: across a cylinder's axis, along a plane's normal."""
    along = dot(u, a)
    if kind == PLANE:
        return chosen(along, along, -along)
    square = dot(u, u)
    if kind == CYLINDER:
        square = square - along * along / dot(a, a)
    return sqrt(positive(square))


@inlined
def near(sheet: Sheet, obstacle: Obstacle, reach: float, c: Vector, a: Vector, work: Floats, source: int) -> bool:
    """Whether a point of the element may touch.

    With the mean m of the corners, s - m = sum S_k (r_k - m) + sum S_l e_l over corners and other vectors. So no point is further
    from m than the largest |r_k - m| times the largest sum of |S_k|, and the sum of the largest |S_l| times |e_l|; all lengths
    taken across the axis of a cylinder, or along the normal of a plane, where a wide element is as slim as it looks.
    """
    n, step, to = sheet.n_vector, sheet.per_node, source + 6 * sheet.n_vector
    m = (0.0, 0.0, 0.0)
    for k in range(source, source + n, step):
        m = combined(1.0, m, step / n, (work[k], work[k + n], work[k + 2 * n]))
    for k in range(0, n, WIDTH):
        at, corner = source + k, load_at(sheet.is_corner, k)
        e = (load_at(work, at), load_at(work, at + n), load_at(work, at + 2 * n))
        store_at(work, to + k, _extent(obstacle.kind, combined(1.0, e, -corner, m), a))
    far, rest = 0.0, 0.0
    for k in range(0, n, step):
        far = max(far, work[to + k])
        for i in range(k + 1, k + step):
            rest += sheet.largest[i] * work[to + i]
    y = combined(1.0, m, -1.0, c)
    away = dot(a, y) if obstacle.kind == PLANE else _extent(obstacle.kind, y, a)
    return away - sheet.corners * far - rest < reach
