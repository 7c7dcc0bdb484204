"""Loops over elements and their points: the force, and the advance of bristles.

Elements away from the obstacle are left out by a bound. The buffer of the force holds (element, component, vector), with vectors
filled up to whole lanes, then the 12 coordinates of the body.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from lamella._jit import inlined, njit
from lamella.contact.gap import Obstacle, distance
from lamella.contact.point import Axes, Force, Law, Relative, components, contact, tangential, weighted
from lamella.contact.sheet import Sheet, gather, interpolate, near
from lamella.element.plate48.strain import Vector, combined, combined3, cross, dot
from lamella.lane import WIDTH, load_at, store_at
from lamella.roles import Floats

DIRECTIONS = 16
"""Coordinates along which the tangent is taken: those of (s, p, d_1, d_2, d_3), and one to fill up."""
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
def _vector(x: Floats, first: int, step: int) -> Vector:
    return (x[first], x[first + step], x[first + 2 * step])


@inlined
def _axes(x: Floats) -> Axes:
    return (_vector(x, 3, 1), _vector(x, 6, 1), _vector(x, 9, 1))


@inlined
def _seen(obstacle: Obstacle, body: Body, s: Vector, sd: Vector, anchors: Floats, pair: int) -> Relative:
    """A point with place s and velocity sd as seen from the obstacle."""
    D, Dd = _axes(body.x), _axes(body.rate)
    y = combined3(1.0, s, -1.0, _vector(body.x, 0, 1), -1.0, weighted(obstacle.centre, D))
    yd = combined3(1.0, sd, -1.0, _vector(body.rate, 0, 1), -1.0, weighted(obstacle.centre, Dd))
    X, held = (0.0, 0.0, 0.0), 0.0
    if anchors.size > 0 and anchors[ANCHOR * pair] == anchors[ANCHOR * pair]:
        X, held = _vector(anchors, ANCHOR * pair, 1), 1.0
    return Relative(y, yd, weighted(obstacle.axis, D), weighted(obstacle.axis, Dd), D, Dd, X, held)


@inlined
def prepared(
    q: Floats, v: Floats, moving: bool, body: Body, sheet: Sheet, obstacle: Obstacle, element: int, every: bool, work: Floats
) -> bool:
    """Put places and velocities of an element's points in work; False when none can touch."""
    gather(q, sheet, element, work, 0)
    D = _axes(body.x)
    c = combined(1.0, _vector(body.x, 0, 1), 1.0, weighted(obstacle.centre, D))
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
def at_point(
    body: Body, moving: bool, sheet: Sheet, obstacle: Obstacle, anchors: Floats, element: int, p: int, work: Floats
) -> Relative:
    """A point of the element that is in work, as seen from the obstacle."""
    first = 6 * sheet.n_vector + p
    sd = (0.0, 0.0, 0.0)
    if moving:
        sd = _vector(work, first + 3 * sheet.points, sheet.points)
    return _seen(obstacle, body, _vector(work, first, sheet.points), sd, anchors, element * sheet.n_point + p)


def work_size(sheet: Sheet) -> int:
    """Numbers of work space: vectors and points of an element with their velocities, and the rows of each point's tangent."""
    return 6 * sheet.n_vector + 6 * sheet.points + 12 * DIRECTIONS * sheet.n_point


@inlined
def add_to_element(sheet: Sheet, p: int, h: Vector, f: Floats, first: int) -> None:
    """Add S_a h of point p."""
    for c in range(3):
        for k in range(0, sheet.vectors, WIDTH):
            at = first + c * sheet.vectors + k
            store_at(f, at, load_at(f, at) + h[c] * load_at(sheet.rows, p * sheet.vectors + k))


@inlined
def add_to_body(obstacle: Obstacle, c: Force, f: Floats, first: int) -> None:
    """Add the forces on p, d_1, d_2, d_3."""
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
        if not prepared(q, v, moving, body, sheet, obstacle, element, every, work):
            continue
        reach = obstacle.radius + sheet.half_thickness[element]
        for p in range(sheet.n_point):
            rel = at_point(body, moving, sheet, obstacle, anchors, element, p, work)
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
            add_to_element(sheet, p, c.h, f, 3 * sheet.vectors * element)
            if obstacle.moves:
                add_to_body(obstacle, c, f, end)
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
    stretch = tangential(c.unit, combined(1.0, rel.y, -1.0, weighted(rel.X, rel.D)))
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


@njit
def advance(q: Floats, body: Body, sheet: Sheet, obstacle: Obstacle, law: Law, anchors: Floats, work: Floats) -> float:
    """Let bristles that are stretched beyond their limit slide, and those of points that do not touch go along with them.

    Returns:
        Heat [J]: the limit along the way that a bristle slides; where its limit has shrunk, or the point has come off, the energy
        that the bristle has lost.
    """
    heat = 0.0
    for element in range(sheet.n_element):
        if not prepared(q, q, False, body, sheet, obstacle, element, False, work):
            for pair in range(element * sheet.n_point, (element + 1) * sheet.n_point):
                heat += _released(law, sheet.area[pair], anchors, pair)
                anchors[ANCHOR * pair] = np.nan
            continue
        reach = obstacle.radius + sheet.half_thickness[element]
        for p in range(sheet.n_point):
            pair = element * sheet.n_point + p
            rel = at_point(body, False, sheet, obstacle, anchors, element, p, work)
            X, pull, area = components(rel.D, rel.y), 0.0, sheet.area[pair]
            c = contact(obstacle, law, reach, area, rel)
            if rel.held > 0.0 and c.at.g < 0.0:
                stretch = tangential(c.unit, combined(1.0, rel.y, -1.0, weighted(rel.X, rel.D)))
                limit, pull = law.mu * c.elastic * c.size, area * law.tangential * dot(stretch, stretch) ** 0.5
                X = rel.X
                if pull > limit:
                    X = components(rel.D, combined(1.0, rel.y, -limit / pull, stretch))
                    shrunk = min(max(anchors[ANCHOR * pair + 3] - limit, 0.0), pull - limit)
                    heat += (limit * (pull - limit) + 0.5 * shrunk**2) / (area * law.tangential)
                    pull = limit
            else:
                heat += _released(law, area, anchors, pair)
            for i in range(3):
                anchors[ANCHOR * pair + i] = X[i]
            anchors[ANCHOR * pair + 3] = pull
    return heat


@inlined
def _released(law: Law, area: float, anchors: Floats, pair: int) -> float:
    """Energy of a bristle that lets go."""
    if anchors[ANCHOR * pair] != anchors[ANCHOR * pair]:
        return 0.0
    return 0.5 * anchors[ANCHOR * pair + 3] ** 2 / (area * law.tangential)
