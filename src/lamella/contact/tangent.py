"""The tangent of contact.

It is the force differentiated forward, along the 15 coordinates of (s, p, d_1, d_2, d_3) at once, which fill lanes with one left
over. The rows that the points of an element give are kept until all are there; sums over points then stay in registers, and each
entry of the buffer is written once:

    (element, component i, component j, vector a, vector b)      d f_ia / d e_jb
    if the body moves, (element, component i, coordinate r, a)   d f_ia / d x_r
                       (element, coordinate r, component j, b)   d f_r / d e_jb
                       (coordinate r, 16)                        d f_r / d (s, x, -), sums over all elements
"""

from __future__ import annotations

import numpy as np

from lamella._jit import inlined, njit
from lamella.contact.gap import Obstacle, distance
from lamella.contact.kernels import DIRECTIONS, Body, add_to_body, add_to_element, at_point, prepared
from lamella.contact.point import Force, Law, Relative, contact, contact_change, weighted
from lamella.contact.sheet import Sheet
from lamella.element.plate48.strain import Vector, combined, combined3, scaled
from lamella.lane import WIDTH, load_at, spread, store_at
from lamella.roles import Bools, Floats, Ints

UNITS = np.eye(DIRECTIONS).reshape(-1)


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
        y = combined3(1.0, _units(0, first), -1.0, _units(3, first), -1.0, weighted(b, D))
        a = weighted(alpha, D)
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
def _element_block(sheet: Sheet, points: Ints, count: int, work: Floats, rows: int, k: Floats, first: int) -> None:
    """sum_p S_a S_b dh_i/ds_j over the points that touch; nine sums at a time stay in registers."""
    n, wide = sheet.n_vector, sheet.vectors
    step = n * wide
    for a in range(n):
        for b in range(0, wide, WIDTH):
            xx, xy, xz = spread(0.0), spread(0.0), spread(0.0)
            yx, yy, yz = spread(0.0), spread(0.0), spread(0.0)
            zx, zy, zz = spread(0.0), spread(0.0), spread(0.0)
            for i in range(count):
                at, row = points[i] * wide, rows + i * 12 * DIRECTIONS
                S = sheet.rows[at + a] * load_at(sheet.rows, at + b)
                xx, xy, xz = xx + work[row] * S, xy + work[row + 1] * S, xz + work[row + 2] * S
                row += DIRECTIONS
                yx, yy, yz = yx + work[row] * S, yy + work[row + 1] * S, yz + work[row + 2] * S
                row += DIRECTIONS
                zx, zy, zz = zx + work[row] * S, zy + work[row + 1] * S, zz + work[row + 2] * S
            to = first + a * wide + b
            _store_row(k, to, step, (xx, xy, xz))
            _store_row(k, to + 3 * step, step, (yx, yy, yz))
            _store_row(k, to + 6 * step, step, (zx, zy, zz))


@inlined
def _store_row(k: Floats, to: int, step: int, row: Vector) -> None:
    for j in range(3):
        store_at(k, to + j * step, row[j])


@inlined
def _body_blocks(
    sheet: Sheet, points: Ints, count: int, work: Floats, rows: int, k: Floats, by_body: int, of_body: int, own: int
) -> None:
    """Sums over the points that touch: S_a dh_i/dx_r, S_b df_r/ds_j, and df_r/d(s, x), which is added up over elements."""
    wide, size = sheet.vectors, 12 * DIRECTIONS
    for r in range(12):
        sign = -1.0 if r < 3 else 1.0  # the force on p is -h
        for i in range(3):
            for b in range(0, wide, WIDTH):
                by, of = spread(0.0), spread(0.0)
                for m in range(count):
                    S = load_at(sheet.rows, points[m] * wide + b)
                    by = by + work[rows + m * size + i * DIRECTIONS + 3 + r] * S
                    of = of + work[rows + m * size + r * DIRECTIONS + i] * S
                store_at(k, by_body + (i * 12 + r) * wide + b, by)
                store_at(k, of_body + (r * 3 + i) * wide + b, sign * of)
        for b in range(0, DIRECTIONS, WIDTH):
            total = spread(0.0)
            for m in range(count):
                total = total + load_at(work, rows + m * size + r * DIRECTIONS + b)
            to = own + r * DIRECTIONS + b
            store_at(k, to, load_at(k, to) + sign * total)


@njit
def force_tangent(
    q: Floats, v: Floats, moving: bool, body: Body, sheet: Sheet, obstacle: Obstacle, law: Law, anchors: Floats,
    alpha_q: float, alpha_v: float, work: Floats, points: Ints, f: Floats, k: Floats, used: Bools,
) -> None:  # fmt: skip
    """Force and tangent alpha_q df/dq + alpha_v df/dv.

    Args:
        points: room for the numbers of the points that touch.
        used: which parts of k are written: a block for each element, then, if the body moves, both couplings of each element with
            the body, and the body's own.
    """
    f[:] = 0.0
    wide, elements = sheet.vectors, sheet.n_element
    rows = 6 * sheet.n_vector + 6 * sheet.points
    block, side = 9 * sheet.n_vector * wide, 36 * wide
    by_body = block * elements
    of_body = by_body + side * elements
    own = of_body + side * elements
    k[own:] = 0.0
    for element in range(elements):
        count = 0
        if prepared(q, v, moving, body, sheet, obstacle, element, False, work):
            reach = obstacle.radius + sheet.half_thickness[element]
            for p in range(sheet.n_point):
                rel = at_point(body, moving, sheet, obstacle, anchors, element, p, work)
                if distance(obstacle, rel.y, rel.a) >= reach:
                    continue
                area = sheet.area[element * sheet.n_point + p]
                c = contact(obstacle, law, reach, area, rel)
                if c.at.g >= 0.0:
                    continue
                add_to_element(sheet, p, c.h, f, 3 * wide * element)
                if obstacle.moves:
                    add_to_body(obstacle, c, f, 3 * wide * elements)
                _rows(obstacle, law, area, rel, c, alpha_q, alpha_v, work, rows + count * 12 * DIRECTIONS)
                points[count] = p
                count += 1
        first, by, of = block * element, by_body + side * element, of_body + side * element
        used[element] = count > 0
        if obstacle.moves:
            used[elements + element] = used[2 * elements + element] = count > 0
        if count > 0:
            _element_block(sheet, points, count, work, rows, k, first)
            if obstacle.moves:
                _body_blocks(sheet, points, count, work, rows, k, by, of, own)
    if obstacle.moves:
        used[3 * elements] = True
