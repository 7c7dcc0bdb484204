"""Loops over elements and their points, a lane of points at a time: the force.

Elements away from the obstacle are left out by a bound. The buffer of the force holds (element, component, vector), with vectors
filled up to whole lanes, then the 12 coordinates of the body.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from lamella._jit import inlined, kernel
from lamella.contact.gap import Obstacle, distance, gap, positive
from lamella.contact.point import Axes, Force, Law, Relative, contact, due_to_velocity, tangential, weighted
from lamella.contact.sheet import Sheet, gather, interpolate, near
from lamella.element.plate48.strain import Vector, combined, combined3, cross, dot
from lamella.lane import WIDTH, chosen, load_at, number_at, spread, sqrt, store_at, total
from lamella.roles import Floats, Ints

CHANGES = 144
"""Derivatives of (h, forces on d_1, d_2, d_3) by (s, d_1, d_2, d_3) at a point."""
TOTALS = 13
"""Force and torque on the body (3 + 3), normal force, power of friction and of damping, energy, points in contact, largest depth,
points evaluated."""
ANCHOR = 4
"""Where the bristle of a point holds, X (3), not a number when nowhere, and its pull at the last accepted step."""
FIELDS = 8
"""Gap, pressure, slip (3), traction (3) of each point."""


class Body(NamedTuple):
    """The vectors p, d_1, d_2, d_3 of a body in its present place, and their rates, each of shape (12,)."""

    x: Floats
    rate: Floats


@inlined
def vector_at(x: Floats, first: int, step: int) -> Vector:
    """Three numbers, ``step`` apart."""
    return (x[first], x[first + step], x[first + 2 * step])


@inlined
def _axes(x: Floats) -> Axes:
    return (vector_at(x, 3, 1), vector_at(x, 6, 1), vector_at(x, 9, 1))


@inlined
def seen(obstacle: Obstacle, body: Body, s: Vector, sd: Vector, X: Vector, held: Any) -> Relative:
    """Points with places s and velocities sd as seen from the obstacle."""
    D, Dd = _axes(body.x), _axes(body.rate)
    y = combined3(1.0, s, -1.0, vector_at(body.x, 0, 1), -1.0, weighted(obstacle.centre, D))
    yd = combined3(1.0, sd, -1.0, vector_at(body.rate, 0, 1), -1.0, weighted(obstacle.centre, Dd))
    return Relative(y, yd, weighted(obstacle.axis, D), weighted(obstacle.axis, Dd), D, Dd, X, held)


@inlined
def prepared(
    q: Floats, v: Floats, moving: bool, body: Body, sheet: Sheet, obstacle: Obstacle, element: int, every: bool, work: Floats
) -> bool:
    """Put places and velocities of an element's points in work; False when none can touch."""
    gather(q, sheet, element, work, 0)
    D = _axes(body.x)
    c = combined(1.0, vector_at(body.x, 0, 1), 1.0, weighted(obstacle.centre, D))
    reach = obstacle.radius + sheet.half_thickness[element]
    if not every and not near(sheet, obstacle, reach, c, weighted(obstacle.axis, D), work, 0):
        return False
    places = 6 * sheet.n_vector
    interpolate(sheet, work, 0, places)
    if moving:
        gather(v, sheet, element, work, 3 * sheet.n_vector)
        interpolate(sheet, work, 3 * sheet.n_vector, places + 3 * sheet.points)
    return True


@inlined
def _lanes(work: Floats, at: int, step: int) -> Vector:
    return (load_at(work, at), load_at(work, at + step), load_at(work, at + 2 * step))


@inlined
def at_points(
    body: Body, moving: bool, sheet: Sheet, obstacle: Obstacle, anchors: Floats, element: int, p: int, work: Floats
) -> Relative:
    """Points p, p + 1, ... of the element that is in work, as seen from the obstacle; their velocities only if ``moving``."""
    at, n = 6 * sheet.n_vector + p, sheet.points
    none = spread(0.0)
    sd = (none, none, none)
    if moving:
        sd = _lanes(work, at + 3 * n, n)
    X, held = (none, none, none), none
    if anchors.size > 0:
        to = 6 * sheet.n_vector + 6 * n
        for i in range(WIDTH):
            pair = ANCHOR * (element * sheet.n_point + min(p + i, sheet.n_point - 1))
            holds = anchors[pair] == anchors[pair]
            work[to + 3 * WIDTH + i] = 1.0 if holds else 0.0
            for k in range(3):
                work[to + k * WIDTH + i] = anchors[pair + k] if holds else 0.0
        X, held = _lanes(work, to, WIDTH), load_at(work, to + 3 * WIDTH)
    return seen(obstacle, body, _lanes(work, at, n), sd, X, held)


@inlined
def reached(obstacle: Obstacle, reach: float, rel: Relative) -> bool:
    """Whether some of the points may touch; those that are nowhere may."""
    return total(chosen(distance(obstacle, rel.y, rel.a) - reach, 0.0, 1.0)) > 0.0


@inlined
def force_at(
    sheet: Sheet, obstacle: Obstacle, law: Law, reach: float, element: int, p: int, rel: Relative, damping: bool,
    work: Floats, place: int,
) -> Force:  # fmt: skip
    """Contact at points p, p + 1, ...; their h goes to work, (component, place), for :func:`add_to_element`.

    With ``damping`` forces are less those at rest.
    """
    at = gap(obstacle, reach, rel.y, rel.a)
    area = load_at(sheet.areas, element * sheet.points + p)
    area = chosen(at.g, 0.0, area)
    c = contact(law, at, area, rel)
    if damping:
        c = due_to_velocity(law, area, rel, c)
    to = pushes(sheet) + place
    store_at(work, to, c.h[0])
    store_at(work, to + sheet.points, c.h[1])
    store_at(work, to + 2 * sheet.points, c.h[2])
    return c


@inlined
def pushes(sheet: Sheet) -> int:
    """Where the forces h of points begin in work, (component, point)."""
    return 6 * sheet.n_vector + 6 * sheet.points + 4 * WIDTH


@inlined
def changes(sheet: Sheet) -> int:
    """Where the derivatives of the forces begin in work, (derivative, point)."""
    return pushes(sheet) + 3 * sheet.points


@inlined
def sums(sheet: Sheet) -> int:
    """Where sums over all points begin in work: lanes of forces on (p, d_1, d_2, d_3) and of totals, or of derivatives."""
    return changes(sheet) + CHANGES * sheet.points


def work_size(sheet: Sheet) -> int:
    """Numbers of work space: vectors and points of an element with their velocities, bristles, forces and tangents, and sums."""
    fixed = 6 * sheet.n_vector + 6 * sheet.points + 4 * WIDTH + 3 * sheet.points
    return fixed + CHANGES * sheet.points + (CHANGES + 12 + TOTALS) * WIDTH


@inlined
def add_to_element(sheet: Sheet, points: Ints, places: Ints, count: int, work: Floats, f: Floats, first: int) -> None:
    """Write sum_p S_a h of the points, whose h stand at ``places`` in work."""
    h, n, wide = pushes(sheet), sheet.points, sheet.vectors
    for b in range(0, wide, WIDTH):
        x, y, z = spread(0.0), spread(0.0), spread(0.0)
        for i in range(count):
            S, at = load_at(sheet.rows, number_at(points, i) * wide + b), h + number_at(places, i)
            x, y, z = x + number_at(work, at) * S, y + number_at(work, at + n) * S, z + number_at(work, at + 2 * n) * S
        store_at(f, first + b, x)
        store_at(f, first + wide + b, y)
        store_at(f, first + 2 * wide + b, z)


@inlined
def add_lanes(work: Floats, at: int, u: Vector) -> None:
    """Add to three lanes of work."""
    store_at(work, at, load_at(work, at) + u[0])
    store_at(work, at + WIDTH, load_at(work, at + WIDTH) + u[1])
    store_at(work, at + 2 * WIDTH, load_at(work, at + 2 * WIDTH) + u[2])


@inlined
def _add_to_axis(obstacle: Obstacle, c: Force, i: int, work: Floats, at: int) -> None:
    turned = combined3(-obstacle.centre[i], c.h, obstacle.axis[i], c.f_a, -c.Y[i], c.tau)
    add_lanes(work, at, turned)


@inlined
def add_to_body(obstacle: Obstacle, c: Force, work: Floats, at: int) -> None:
    """Add the forces on p, d_1, d_2, d_3 to lanes of work."""
    add_lanes(work, at, (-c.h[0], -c.h[1], -c.h[2]))
    _add_to_axis(obstacle, c, 0, work, at + 3 * WIDTH)
    _add_to_axis(obstacle, c, 1, work, at + 6 * WIDTH)
    _add_to_axis(obstacle, c, 2, work, at + 9 * WIDTH)


@inlined
def touching(sheet: Sheet, element: int, p: int, place: int, g: Any, work: Floats, points: Ints, places: Ints, count: int) -> int:
    """List those of points p, p + 1, ... that touch, with the place of their numbers in work; how many are listed now."""
    to = pushes(sheet) - WIDTH  # beside the bristles, which have been read
    store_at(work, to, g)
    for i in range(min(WIDTH, sheet.n_point - p)):
        if not work[to + i] >= 0.0:
            points[count], places[count] = p + i, place + i
            count += 1
    return count


@kernel
def force(
    q: Floats, v: Floats, moving: bool, body: Body, sheet: Sheet, obstacle: Obstacle, law: Law, anchors: Floats,
    damping: bool, work: Floats, points: Ints, places: Ints, f: Floats, totals: Floats, field: Floats,
) -> None:  # fmt: skip
    """Force, totals, and what each point shows if ``field`` has room for it.

    Args:
        damping: give the force less that at rest in the same place; totals mean nothing then.
        points, places: room for the numbers of the points that touch, and of their places in work.
    """
    f[:] = 0.0
    totals[:] = 0.0
    every = field.size > 0
    end, kept = 3 * sheet.vectors * sheet.n_element, sums(sheet)
    work[kept : kept + (12 + TOTALS) * WIDTH] = 0.0
    for element in range(sheet.n_element):
        if not prepared(q, v, moving, body, sheet, obstacle, element, every, work):
            continue
        totals[12] += sheet.n_point
        reach = obstacle.radius + sheet.half_thickness[element]
        count = place = 0
        for p in range(0, sheet.points, WIDTH):
            rel = at_points(body, moving, sheet, obstacle, anchors, element, p, work)
            if not every and not reached(obstacle, reach, rel):
                continue
            c = force_at(sheet, obstacle, law, reach, element, p, rel, damping, work, place)
            if obstacle.moves:
                add_to_body(obstacle, c, work, kept)
            area = load_at(sheet.areas, element * sheet.points + p)
            _add_totals(law, area, rel, c, work, kept + 12 * WIDTH)
            if every:
                apart = distance(obstacle, rel.y, rel.a) - reach
                _show(sheet, area, apart, c, work, field, element, p)
            count = touching(sheet, element, p, place, c.at.g, work, points, places, count)
            place += WIDTH
        if count > 0:
            add_to_element(sheet, points, places, count, work, f, 3 * sheet.vectors * element)
    if obstacle.moves:
        for r in range(12):
            f[end + r] = total(load_at(work, kept + r * WIDTH))
    for r in range(11):
        totals[r] = total(load_at(work, kept + (12 + r) * WIDTH))
    for i in range(WIDTH):
        totals[11] = max(totals[11], work[kept + 23 * WIDTH + i])


@inlined
def _show(sheet: Sheet, area: Any, apart: Any, c: Force, work: Floats, field: Floats, element: int, p: int) -> None:
    """Write what points p, p + 1, ... show, by way of work."""
    to, per = changes(sheet), 1.0 / chosen(area, area, 1.0)
    store_at(work, to, chosen(apart, apart, c.at.g))
    store_at(work, to + WIDTH, c.F * c.size * per)
    for k in range(3):
        store_at(work, to + (2 + k) * WIDTH, chosen(c.at.g, 0.0, c.slip[k]))
        store_at(work, to + (5 + k) * WIDTH, -c.tau[k] * per)
    for i in range(min(WIDTH, sheet.n_point - p)):
        for k in range(FIELDS):
            field[(element * sheet.n_point + p + i) * FIELDS + k] = work[to + k * WIDTH + i]


@inlined
def _add_lane(work: Floats, at: int, value: Any) -> None:
    store_at(work, at, load_at(work, at) + value)


@inlined
def _add_totals(law: Law, area: Any, rel: Relative, c: Force, work: Floats, at: int) -> None:
    """Add to lanes of work; see :data:`TOTALS`."""
    touches = chosen(c.at.g, 0.0, chosen(area, 1.0 + 0.0 * area, 0.0))
    depth = positive(-c.at.g) * touches
    add_lanes(work, at, c.h)
    add_lanes(work, at + 3 * WIDTH, cross(rel.y, c.h))
    _add_lane(work, at + 6 * WIDTH, c.F * c.size)
    heat, stored = dot(c.tau, c.slip), 0.0 * area
    if law.bristle:
        stored, power = _bristle_energy(law, area, rel, c)
        stored, power = chosen(touches, stored, 0.0), chosen(touches, power, 0.0)
        heat = heat - power
    _add_lane(work, at + 7 * WIDTH, positive(heat))
    _add_lane(work, at + 8 * WIDTH, (c.F - c.elastic) * c.rate)
    _add_lane(work, at + 9 * WIDTH, c.elastic * depth / (law.exponent + 1.0) + stored)
    _add_lane(work, at + 10 * WIDTH, touches)
    deepest = load_at(work, at + 11 * WIDTH)
    store_at(work, at + 11 * WIDTH, chosen(depth - deepest, depth, deepest))


@inlined
def _bristle_energy(law: Law, area: Any, rel: Relative, c: Force) -> tuple[Any, Any]:
    """Energy of a bristle, and the power that goes into it: of its stretch, up to where it slides. No numbers without area."""
    k = area * law.tangential
    stretch = tangential(c.unit, combined(1.0, rel.y, -1.0, weighted(rel.X, rel.D)))
    length = rel.held * sqrt(dot(stretch, stretch))
    limit = law.mu * c.elastic * c.size / k
    growth = chosen(length, rel.held * dot(stretch, c.slip) / length, 0.0)
    widening = law.exponent * limit * c.rate / -c.at.g
    # as bristles that slide are after each accepted step
    slower = chosen(widening - growth, growth, widening)
    widening = chosen(limit * (1.0 + 1e-9) - length, slower, widening)
    holds = limit * (1.0 - 1e-9) - length
    stored = chosen(holds, 0.5 * k * length * length, 0.5 * k * limit * limit)
    power = chosen(holds, k * length * growth, k * limit * widening)
    return chosen(length, stored, 0.0), chosen(length, power, 0.0)
