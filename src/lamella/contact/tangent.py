"""The tangent of contact.

Derivatives at the points of an element that touch (:mod:`lamella.contact.change`) are kept until all are there; sums over points
then stay in registers, and each entry of the buffer is written once:

    (element, component i, component j, vector a, vector b)      d f_ia / d e_jb
    if the body moves, (element, component i, coordinate r, a)   d f_ia / d x_r
                       (element, coordinate r, component j, b)   d f_r / d e_jb
                       (coordinate r, coordinate s)              d f_r / d x_s, sums over all elements
"""

from __future__ import annotations

from typing import Any

from lamella._jit import inlined, inner, kernel
from lamella.contact.change import store_changes
from lamella.contact.gap import Obstacle
from lamella.contact.kernels import (
    CHANGES,
    Body,
    add_to_body,
    add_to_element,
    at_points,
    changes,
    force_at,
    prepared,
    reached,
    sums,
    touching,
)
from lamella.contact.point import Law
from lamella.contact.sheet import Sheet
from lamella.element.plate48.strain import Vector
from lamella.lane import WIDTH, load_at, number_at, spread, store_at, total
from lamella.roles import Bools, Floats, Ints


@inlined
def _store_row(k: Floats, to: int, step: int, row: Vector) -> None:
    store_at(k, to, row[0])
    store_at(k, to + step, row[1])
    store_at(k, to + 2 * step, row[2])


@inlined
def _with_row(u: Vector, work: Floats, at: int, step: int, S: Any) -> Vector:
    """u and S times three numbers of work."""
    return (
        u[0] + number_at(work, at) * S,
        u[1] + number_at(work, at + step) * S,
        u[2] + number_at(work, at + 2 * step) * S,
    )


@inlined
def _element_block(sheet: Sheet, points: Ints, places: Ints, count: int, work: Floats, kept: int, k: Floats, first: int) -> None:
    """sum_p S_a S_b dh_i/ds_j over the points that touch, nine sums at a time in registers; symmetric in a and b."""
    n, wide, to_next = sheet.n_vector, sheet.vectors, sheet.points
    step, row_step, none = n * wide, 12 * to_next, spread(0.0)
    for a in range(n):
        for b in range(a - a % WIDTH, wide, WIDTH):
            x, y, z = (none, none, none), (none, none, none), (none, none, none)
            for i in range(count):
                at, row = number_at(points, i) * wide, kept + number_at(places, i)
                S = number_at(sheet.rows, at + a) * load_at(sheet.rows, at + b)
                x = _with_row(x, work, row, to_next, S)
                y = _with_row(y, work, row + row_step, to_next, S)
                z = _with_row(z, work, row + 2 * row_step, to_next, S)
            to = first + a * wide + b
            _store_row(k, to, step, x)
            _store_row(k, to + 3 * step, step, y)
            _store_row(k, to + 6 * step, step, z)
    for pair in range(first, first + 9 * step, step):
        for a in range(WIDTH, n):
            for b in range(a - a % WIDTH):
                k[pair + a * wide + b] = k[pair + b * wide + a]


@inlined
def _weighted_sums(
    sheet: Sheet, points: Ints, places: Ints, count: int, work: Floats, source: int, sign: float,
    k: Floats, to: int, row_step: int, step: int,
) -> None:  # fmt: skip
    """sign sum_p S_b M_ij of 3 x 3 derivatives M at work[source:], to k[to + i row_step + j step + b]."""
    wide, n, none = sheet.vectors, sheet.points, spread(0.0)
    for b in range(0, wide, WIDTH):
        x, y, z = (none, none, none), (none, none, none), (none, none, none)
        for i in range(count):
            row = source + number_at(places, i)
            S = sign * load_at(sheet.rows, number_at(points, i) * wide + b)
            x = _with_row(x, work, row, n, S)
            y = _with_row(y, work, row + 12 * n, n, S)
            z = _with_row(z, work, row + 24 * n, n, S)
        _store_row(k, to + b, step, x)
        _store_row(k, to + row_step + b, step, y)
        _store_row(k, to + 2 * row_step + b, step, z)


@inner
def _body_blocks(
    sheet: Sheet, points: Ints, places: Ints, count: int, groups: int, work: Floats, kept: int, k: Floats,
    by_body: int, of_body: int,
) -> None:  # fmt: skip
    """Sums over the points that touch: S_a dh_i/dx_r, S_b df_r/ds_j, and all derivatives, which are added up over elements.

    The force on p is -h, and along p all is as along -s.
    """
    wide, n = sheet.vectors, sheet.points
    for part in range(4):
        sign = -1.0 if part == 0 else 1.0
        by, of = by_body + 3 * part * wide, of_body + 9 * part * wide
        _weighted_sums(sheet, points, places, count, work, kept + 3 * part * n, sign, k, by, 12 * wide, wide)
        _weighted_sums(sheet, points, places, count, work, kept + 36 * part * n, sign, k, of, 3 * wide, wide)
    to = sums(sheet)
    for e in range(CHANGES):
        at, source = to + e * WIDTH, kept + e * n
        value = load_at(work, at)
        for group in range(groups):
            value = value + load_at(work, source + group * WIDTH)
        store_at(work, at, value)


@kernel
def force_tangent(
    q: Floats, v: Floats, moving: bool, body: Body, sheet: Sheet, obstacle: Obstacle, law: Law, anchors: Floats,
    alpha_q: float, alpha_v: float, work: Floats, points: Ints, places: Ints, f: Floats, k: Floats, used: Bools,
) -> None:  # fmt: skip
    """Force and tangent alpha_q df/dq + alpha_v df/dv.

    Args:
        points, places: room for the numbers of the points that touch, and of their places in work.
        used: which parts of k are written: a block for each element, then, if the body moves, both couplings of each element with
            the body, and the body's own.
    """
    f[:] = 0.0
    wide, elements = sheet.vectors, sheet.n_element
    kept, summed = changes(sheet), sums(sheet)
    on_body = summed + CHANGES * WIDTH
    work[summed : on_body + 12 * WIDTH] = 0.0
    block, side = 9 * sheet.n_vector * wide, 36 * wide
    by_body = block * elements
    of_body = by_body + side * elements
    own = of_body + side * elements
    for element in range(elements):
        count = place = 0
        if prepared(q, v, moving, body, sheet, obstacle, element, False, work):
            reach = obstacle.radius + sheet.half_thickness[element]
            for p in range(0, sheet.points, WIDTH):
                rel = at_points(body, moving, sheet, obstacle, anchors, element, p, work)
                if not reached(obstacle, reach, rel):
                    continue
                c = force_at(sheet, obstacle, law, reach, element, p, rel, False, work, place)
                listed = touching(sheet, element, p, place, c.at.g, work, points, places, count)
                if listed == count:
                    continue
                count = listed
                if obstacle.moves:
                    add_to_body(obstacle, c, work, on_body)
                store_changes(obstacle, law, rel, c, alpha_q, alpha_v, work, kept + place, sheet.points)
                place += WIDTH
        used[element] = count > 0
        if obstacle.moves:
            used[elements + element] = used[2 * elements + element] = count > 0
        if count > 0:
            add_to_element(sheet, points, places, count, work, f, 3 * wide * element)
            _element_block(sheet, points, places, count, work, kept, k, block * element)
            if obstacle.moves:
                by, of = by_body + side * element, of_body + side * element
                _body_blocks(sheet, points, places, count, place // WIDTH, work, kept, k, by, of)
    if obstacle.moves:
        used[3 * elements] = True
        for r in range(12):
            f[3 * wide * elements + r] = total(load_at(work, on_body + r * WIDTH))
            for s in range(12):
                sign = 1.0 if (r < 3) == (s < 3) else -1.0
                k[own + 12 * r + s] = sign * total(load_at(work, summed + (12 * r + s) * WIDTH))
