"""The advance of bristles with an accepted step: those stretched beyond their limit slide."""

from __future__ import annotations

import numpy as np

from lamella._jit import inlined, kernel
from lamella.contact.gap import Obstacle, gap
from lamella.contact.kernels import ANCHOR, Body, prepared, seen, vector_at
from lamella.contact.point import Law, components, contact, tangential, weighted
from lamella.contact.sheet import Sheet
from lamella.element.plate48.strain import combined, dot
from lamella.roles import Floats


@kernel
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
            s = vector_at(work, 6 * sheet.n_vector + p, sheet.points)
            X, held = (0.0, 0.0, 0.0), 0.0
            if anchors[ANCHOR * pair] == anchors[ANCHOR * pair]:
                X, held = vector_at(anchors, ANCHOR * pair, 1), 1.0
            rel = seen(obstacle, body, s, (0.0, 0.0, 0.0), X, held)
            X, pull, area = components(rel.D, rel.y), 0.0, sheet.area[pair]
            c = contact(law, gap(obstacle, reach, rel.y, rel.a), area, rel)
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
