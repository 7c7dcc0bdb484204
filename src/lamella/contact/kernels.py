"""Loops over elements and their points: force, tangent, and the advance of bristles.

The tangent is the force differentiated forward, along the 15 coordinates of (s, p, d_1, d_2, d_3) at once, which fill lanes with one
left over. Elements away from the obstacle are left out by a bound. Buffers (f is force, k is tangent; vectors filled up):

    f    (element, component, vector), then 12 of the body
    k    (element, component i, component j, vector a, vector b)    d f_ia / d e_jb
         then, if the body moves, (element, component i, coordinate r, vector a)    d f_ia / d x_r
                                  (element, coordinate r, component j, vector b)    d f_r / d e_jb
                                  (coordinate r, 16)                                d f_r / d (s, x, -)
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from lamella._jit import inlined, njit
from lamella.contact.gap import Obstacle, distance
from lamella.contact.point import Axes, Force, Law, Relative, components, contact, contact_change, tangential, tuple_sum
from lamella.contact.sheet import Sheet, gather, interpolate, near
from lamella.element.plate48.strain import Vector, combined, combined3, cross, dot, scaled
from lamella.lane import WIDTH, load_at, spread, store_at
from lamella.roles import Floats

DIRECTIONS = 16
"""The coordinates of (s, p, d_1, d_2, d_3), and one to fill up."""
TOTALS = 13
"""Force and torque on the body (3 + 3), normal force, power of friction and of damping, energy, points in contact, largest depth,
points evaluated."""
FIELDS = 8
"""Gap, pressure, slip (3), traction (3) of each point."""
UNITS = np.eye(DIRECTIONS).reshape(-1)


class Body(NamedTuple):
    """The vectors p, d_1, d_2, d_3 of a body in its present place, and their rates, each of shape (12,)."""

    x: Floats
    rate: Floats


@inlined
def _vector(x: Floats, first: int, step: int) -> Vector:
    return (x[first], x[first + step], x[first + 2 * step])


@inlined
def _axes(x: Floats) -> Axes:
    return (_vector(x, 3, 1), _vector(x, 6, 1), _vector(x, 9, 1))


@inlined
def _seen(obstacle: Obstacle, body: Body, s: Vector, sd: Vector, anchors: Floats, pair: int) -> Relative:
    """A point with place s and velocity sd as seen from the obstacle."""
    D, Dd = _axes(body.x), _axes(body.rate)
    y = combined3(1.0, s, -1.0, _vector(body.x, 0, 1), -1.0, tuple_sum(obstacle.centre, D))
    yd = combined3(1.0, sd, -1.0, _vector(body.rate, 0, 1), -1.0, tuple_sum(obstacle.centre, Dd))
    X, held = (0.0, 0.0, 0.0), 0.0
    if anchors.size > 0 and anchors[3 * pair] == anchors[3 * pair]:
        X, held = _vector(anchors, 3 * pair, 1), 1.0
    return Relative(y, yd, tuple_sum(obstacle.axis, D), tuple_sum(obstacle.axis, Dd), D, Dd, X, held)


@inlined
def _prepared(
    q: Floats, v: Floats, moving: bool, body: Body, sheet: Sheet, obstacle: Obstacle, element: int, every: bool, work: Floats
) -> bool:
    """Places and velocities of an element's points in work; False when none can touch."""
    gather(q, sheet, element, work, 0)
    D = _axes(body.x)
    c = combined(1.0, _vector(body.x, 0, 1), 1.0, tuple_sum(obstacle.centre, D))
    reach = obstacle.radius + sheet.half_thickness[element]
    if not every and not near(sheet, obstacle, reach, c, tuple_sum(obstacle.axis, D), work, 0):
        return False
    places = 6 * sheet.n_vector
    interpolate(sheet, work, 0, places)
    if moving:
        gather(v, sheet, element, work, 3 * sheet.n_vector)
        interpolate(sheet, work, 3 * sheet.n_vector, places + 3 * sheet.points)
    return True


@inlined
def _at_point(
    body: Body, moving: bool, sheet: Sheet, obstacle: Obstacle, anchors: Floats, element: int, p: int, work: Floats
) -> Relative:
    first = 6 * sheet.n_vector + p
    sd = (0.0, 0.0, 0.0)
    if moving:
        sd = _vector(work, first + 3 * sheet.points, sheet.points)
    return _seen(obstacle, body, _vector(work, first, sheet.points), sd, anchors, element * sheet.n_point + p)


def work_size(sheet: Sheet) -> int:
    """Numbers of work space: vectors and points of an element with their velocities, and the rows of a point's tangent."""
    return 6 * sheet.n_vector + 6 * sheet.points + 12 * DIRECTIONS


@inlined
def _add_to_element(sheet: Sheet, p: int, h: Vector, f: Floats, first: int) -> None:
    for c in range(3):
        for k in range(0, sheet.vectors, WIDTH):
            at = first + c * sheet.vectors + k
            store_at(f, at, load_at(f, at) + h[c] * load_at(sheet.rows, p * sheet.vectors + k))


@inlined
def _add_to_body(obstacle: Obstacle, c: Force, f: Floats, first: int) -> None:
    for k in range(3):
        f[first + k] -= c.h[k]
        for i in range(3):
            f[first + 3 + 3 * i + k] += obstacle.axis[i] * c.f_a[k] - obstacle.centre[i] * c.h[k] - c.Y[i] * c.tau[k]


@njit
def force(
    q: Floats, v: Floats, moving: bool, body: Body, sheet: Sheet, obstacle: Obstacle, law: Law, anchors: Floats,
    work: Floats, f: Floats, totals: Floats, field: Floats,
) -> None:  # fmt: skip
    """Force, totals, and what each point shows if ``field`` has room for it."""
    f[:] = 0.0
    totals[:] = 0.0
    every = field.size > 0
    end = 3 * sheet.vectors * sheet.n_element
    for element in range(sheet.n_element):
        if not _prepared(q, v, moving, body, sheet, obstacle, element, every, work):
            continue
        reach = obstacle.radius + sheet.half_thickness[element]
        for p in range(sheet.n_point):
            rel = _at_point(body, moving, sheet, obstacle, anchors, element, p, work)
            totals[12] += 1.0
            pair = element * sheet.n_point + p
            apart = distance(obstacle, rel.y, rel.a) - reach
            if every:
                field[pair * FIELDS] = apart
            if apart >= 0.0:
                continue
            area = sheet.area[pair]
            c = contact(obstacle, law, reach, area, rel)
            if every:
                field[pair * FIELDS] = c.at.g
            if c.at.g >= 0.0:  # beyond the end of a cylinder
                continue
            _add_to_element(sheet, p, c.h, f, 3 * sheet.vectors * element)
            if obstacle.moves:
                _add_to_body(obstacle, c, f, end)
            _add_totals(law, area, rel, c, totals)
            if every:
                _show(area, c, field, pair * FIELDS)


@inlined
def _show(area: float, c: Force, field: Floats, at: int) -> None:
    field[at + 1] = c.F * c.size / area
    for k in range(3):
        field[at + 2 + k] = c.slip[k]
        field[at + 5 + k] = -c.tau[k] / area


@inlined
def _add_totals(law: Law, area: float, rel: Relative, c: Force, totals: Floats) -> None:
    turning = cross(rel.y, c.h)
    for k in range(3):
        totals[k] += c.h[k]
        totals[3 + k] += turning[k]
    depth = -c.at.g
    rate = -(dot(c.at.m, rel.yd) + dot(c.at.g_a, rel.ad))
    totals[6] += c.F * c.size
    stored, power = _bristle_energy(law, area, rel, c, rate) if law.bristle else (0.0, 0.0)
    totals[7] += max(dot(c.tau, c.slip) - power, 0.0)
    totals[8] += (c.F - c.elastic) * rate
    totals[9] += c.elastic * depth / (law.exponent + 1.0) + stored
    totals[10] += 1.0
    totals[11] = max(totals[11], depth)


@inlined
def _bristle_energy(law: Law, area: float, rel: Relative, c: Force, rate: float) -> tuple[float, float]:
    """Energy of a bristle, and the power that goes into it: of its stretch, up to where it slides."""
    k = area * law.tangential
    stretch = tangential(c.unit, combined(1.0, rel.y, -1.0, tuple_sum(rel.X, rel.D)))
    length = rel.held * dot(stretch, stretch) ** 0.5
    if length == 0.0:
        return 0.0, 0.0
    limit = law.mu * c.elastic * c.size / k
    growth = rel.held * dot(stretch, c.slip) / length
    if length < limit * (1.0 - 1e-9):
        return 0.5 * k * length**2, k * length * growth
    widening = law.exponent * limit * rate / -c.at.g
    if length < limit * (1.0 + 1e-9):  # as bristles that slide are after each accepted step
        widening = min(growth, widening)
    return 0.5 * k * limit**2, k * limit * widening


@inlined
def _units(r: int, first: int) -> Vector:
    """Lanes of the unit vectors of coordinates r, r + 1, r + 2 among the directions from ``first`` on."""
    return (
        load_at(UNITS, r * DIRECTIONS + first),
        load_at(UNITS, (r + 1) * DIRECTIONS + first),
        load_at(UNITS, (r + 2) * DIRECTIONS + first),
    )


@inlined
def _store3(work: Floats, row: int, u: Vector) -> None:
    for k in range(3):
        store_at(work, row + k * DIRECTIONS, u[k])


@inlined
def _rows(
    obstacle: Obstacle, law: Law, area: float, rel: Relative, c: Force, alpha_q: float, alpha_v: float, work: Floats, rows: int
) -> None:
    """Changes of h and of the forces on d_1, d_2, d_3 along all directions, to work[rows:], (12, DIRECTIONS)."""
    b, alpha = obstacle.centre, obstacle.axis
    directions = DIRECTIONS if obstacle.moves else 3
    for first in range(0, directions, WIDTH):
        D = (_units(6, first), _units(9, first), _units(12, first))
        y = combined3(1.0, _units(0, first), -1.0, _units(3, first), -1.0, tuple_sum(b, D))
        a = tuple_sum(alpha, D)
        dD = (scaled(alpha_q, D[0]), scaled(alpha_q, D[1]), scaled(alpha_q, D[2]))
        dDd = (scaled(alpha_v, D[0]), scaled(alpha_v, D[1]), scaled(alpha_v, D[2]))
        dh, df_a, dtau, dY = contact_change(
            obstacle, law, area, rel, c,
            scaled(alpha_q, y), scaled(alpha_v, y), scaled(alpha_q, a), scaled(alpha_v, a), dD, dDd,
        )  # fmt: skip
        _store3(work, rows + first, dh)
        for i in range(3):
            turned = combined(dY[i], c.tau, c.Y[i], dtau)
            _store3(work, rows + (3 + 3 * i) * DIRECTIONS + first, combined3(-b[i], dh, alpha[i], df_a, -1.0, turned))


@inlined
def _add_element_block(sheet: Sheet, p: int, work: Floats, rows: int, k: Floats, first: int) -> None:
    n, wide, at = sheet.n_vector, sheet.vectors, p * sheet.vectors
    for i in range(3):
        for j in range(3):
            value = work[rows + i * DIRECTIONS + j]
            for a in range(n):
                factor = value * sheet.rows[at + a]
                to = first + ((i * 3 + j) * n + a) * wide
                for b in range(0, wide, WIDTH):
                    store_at(k, to + b, load_at(k, to + b) + factor * load_at(sheet.rows, at + b))


@inlined
def _add_body_blocks(
    sheet: Sheet, p: int, work: Floats, rows: int, k: Floats, columns_first: int, rows_first: int, own: int
) -> None:
    wide, at = sheet.vectors, p * sheet.vectors
    for r in range(12):
        for i in range(3):
            by_body = work[rows + i * DIRECTIONS + 3 + r]
            of_body = -work[rows + r * DIRECTIONS + i] if r < 3 else work[rows + r * DIRECTIONS + i]
            by, of = columns_first + (i * 12 + r) * wide, rows_first + (r * 3 + i) * wide
            for b in range(0, wide, WIDTH):
                S = load_at(sheet.rows, at + b)
                store_at(k, by + b, load_at(k, by + b) + by_body * S)
                store_at(k, of + b, load_at(k, of + b) + of_body * S)
        sign = -1.0 if r < 3 else 1.0
        for b in range(0, DIRECTIONS, WIDTH):
            to = own + r * DIRECTIONS + b
            store_at(k, to, load_at(k, to) + sign * load_at(work, rows + r * DIRECTIONS + b))


@njit
def force_tangent(
    q: Floats, v: Floats, moving: bool, body: Body, sheet: Sheet, obstacle: Obstacle, law: Law, anchors: Floats,
    alpha_q: float, alpha_v: float, work: Floats, f: Floats, k: Floats,
) -> None:  # fmt: skip
    """Force and tangent alpha_q df/dq + alpha_v df/dv."""
    f[:] = 0.0
    k[:] = 0.0
    n, wide, count = sheet.n_vector, sheet.vectors, sheet.n_element
    rows = 6 * n + 6 * sheet.points
    columns_first = 9 * n * wide * count
    rows_first = columns_first + 36 * wide * count
    own = rows_first + 36 * wide * count
    for element in range(count):
        if not _prepared(q, v, moving, body, sheet, obstacle, element, False, work):
            continue
        reach = obstacle.radius + sheet.half_thickness[element]
        for p in range(sheet.n_point):
            rel = _at_point(body, moving, sheet, obstacle, anchors, element, p, work)
            if distance(obstacle, rel.y, rel.a) >= reach:
                continue
            area = sheet.area[element * sheet.n_point + p]
            c = contact(obstacle, law, reach, area, rel)
            if c.at.g >= 0.0:
                continue
            _add_to_element(sheet, p, c.h, f, 3 * wide * element)
            _rows(obstacle, law, area, rel, c, alpha_q, alpha_v, work, rows)
            _add_element_block(sheet, p, work, rows, k, 9 * n * wide * element)
            if obstacle.moves:
                _add_to_body(obstacle, c, f, 3 * wide * count)
                element_at = 36 * wide * element
                _add_body_blocks(sheet, p, work, rows, k, columns_first + element_at, rows_first + element_at, own)


@njit
def advance(q: Floats, body: Body, sheet: Sheet, obstacle: Obstacle, law: Law, anchors: Floats, work: Floats) -> None:
    """Let bristles that are stretched beyond their limit slide, and those of points that do not touch go along with them."""
    for element in range(sheet.n_element):
        first = element * sheet.n_point
        if not _prepared(q, q, False, body, sheet, obstacle, element, False, work):
            anchors[3 * first : 3 * (first + sheet.n_point)] = np.nan
            continue
        reach = obstacle.radius + sheet.half_thickness[element]
        for p in range(sheet.n_point):
            rel = _at_point(body, False, sheet, obstacle, anchors, element, p, work)
            X = components(rel.D, rel.y)
            if rel.held > 0.0 and distance(obstacle, rel.y, rel.a) < reach:
                area = sheet.area[first + p]
                c = contact(obstacle, law, reach, area, rel)
                if c.at.g < 0.0:
                    stretch = tangential(c.unit, combined(1.0, rel.y, -1.0, tuple_sum(rel.X, rel.D)))
                    limit = law.mu * c.elastic * c.size
                    force = area * law.tangential * dot(stretch, stretch) ** 0.5
                    X = rel.X
                    if force > limit:
                        X = components(rel.D, combined(1.0, rel.y, -limit / force, stretch))
            for i in range(3):
                anchors[3 * (first + p) + i] = X[i]
