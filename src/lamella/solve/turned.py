"""A factorisation that turns with the nodes of plates, so that it serves longer."""

from __future__ import annotations

import numpy as np

from lamella._jit import kernel
from lamella.assembly.equations import Equations
from lamella.lane import sqrt
from lamella.roles import Floats, Ints
from lamella.solve.base import LinearSolver


def turned(linear: LinearSolver, equations: Equations) -> LinearSolver:
    """The solver with a factorisation that turns along, where that is possible: with plates, and without multipliers.

    Rows of constraints with multipliers turn with no node.
    """
    return TurnedSolver(linear, equations) if equations.model.plates and not equations.n_lam else linear


class TurnedSolver(LinearSolver):
    """Solves with the factorisation of a matrix K0 of an earlier configuration, seen from axes that turn with each node.

        K^-1 = Q K0^-1 Q^T,      Q = diag(R_k),      R_k = F_k F_k0^T

    with the frames F_k = (t, m x t, m) of the nodes' normals m and of the bisectors t of their slopes, now and where K0 was
    evaluated. Where a plate has turned, this takes from K0 the error of first order in the angle, which the membrane, stiff
    beside the bending, magnifies. Vectors of which supports hold a component are not turned.

    Args:
        linear: the solver.
        equations: tell the places of nodal vectors among the unknowns.
    """

    def __init__(self, linear: LinearSolver, equations: Equations) -> None:
        self._linear, self.pattern = linear, linear.pattern
        independent = equations.elimination.independent
        slopes, places, nodes, count = [], [], [], 0
        for plate in equations.model.plates:
            numbers, per_node = np.arange(plate.n_nodes), plate.element.vectors_per_node
            slopes.append(np.stack([3 * (plate.vector(0, name) + per_node * numbers) for name in ("r_x", "r_y")], axis=1))
            coords = 3 * (plate.first + np.arange(per_node * plate.n_nodes))
            at = np.searchsorted(independent, coords)
            first, last = (independent[np.minimum(at + c, len(independent) - 1)] for c in (0, 2))
            whole = (first == coords) & (last == coords + 2)
            places.append(at[whole])
            nodes.append((count + np.arange(len(coords)) // per_node)[whole])
            count += plate.n_nodes
        self._slopes, self._places, self._nodes = (np.concatenate(parts) for parts in (slopes, places, nodes))
        self._start, self._frames, self._turns = np.zeros((3, count, 3, 3))
        self._turned = False
        _frames(equations.model.q0, self._slopes, self._frames)

    @property
    def negative_pivots(self) -> int | None:
        """As the solver."""
        return self._linear.negative_pivots

    def look(self, q: Floats) -> None:
        """Turn with the nodes to a configuration (n_q,)."""
        _frames(q, self._slopes, self._frames)
        _between(self._start, self._frames, self._turns)
        self._turned = True

    def factorise(self, k: Floats, j: Floats) -> None:
        """Factorise a matrix of the configuration looked at last, or of one near it."""
        self._linear.factorise(k, j)
        self._start[:] = self._frames
        self._turned = False

    def solve(self, r: Floats, s: Floats) -> tuple[Floats, Floats]:
        """Solve with the last factorisation, turned."""
        if not self._turned:
            return self._linear.solve(r, s)
        back, out = np.empty_like(r), np.empty_like(r)
        _turn_back(self._turns, self._places, self._nodes, r, back)
        x, y = self._linear.solve(back, s)
        _turn(self._turns, self._places, self._nodes, x, out)
        return out, y


@kernel
def _frames(q: Floats, slopes: Ints, frames: Floats) -> None:
    for k in range(len(slopes)):
        i, j = slopes[k, 0], slopes[k, 1]
        a0, a1, a2, b0, b1, b2 = q[i], q[i + 1], q[i + 2], q[j], q[j + 1], q[j + 2]
        a, b = 1.0 / sqrt(a0 * a0 + a1 * a1 + a2 * a2), 1.0 / sqrt(b0 * b0 + b1 * b1 + b2 * b2)
        m0, m1, m2 = a1 * b2 - a2 * b1, a2 * b0 - a0 * b2, a0 * b1 - a1 * b0
        t0, t1, t2 = a * a0 + b * b0, a * a1 + b * b1, a * a2 + b * b2
        m, t = 1.0 / sqrt(m0 * m0 + m1 * m1 + m2 * m2), 1.0 / sqrt(t0 * t0 + t1 * t1 + t2 * t2)
        m0, m1, m2, t0, t1, t2 = m * m0, m * m1, m * m2, t * t0, t * t1, t * t2
        frames[k, 0, 0], frames[k, 1, 0], frames[k, 2, 0] = t0, t1, t2
        frames[k, 0, 1], frames[k, 1, 1], frames[k, 2, 1] = m1 * t2 - m2 * t1, m2 * t0 - m0 * t2, m0 * t1 - m1 * t0
        frames[k, 0, 2], frames[k, 1, 2], frames[k, 2, 2] = m0, m1, m2


@kernel
def _between(start: Floats, frames: Floats, turns: Floats) -> None:
    for k in range(len(frames)):
        for i in range(3):
            for j in range(3):
                total = 0.0
                for c in range(3):
                    total += frames[k, i, c] * start[k, j, c]
                turns[k, i, j] = total


@kernel
def _turn(turns: Floats, places: Ints, nodes: Ints, x: Floats, y: Floats) -> None:
    for i in range(len(x)):
        y[i] = x[i]
    for k in range(len(places)):
        i, n = places[k], nodes[k]
        for c in range(3):
            y[i + c] = turns[n, c, 0] * x[i] + turns[n, c, 1] * x[i + 1] + turns[n, c, 2] * x[i + 2]


@kernel
def _turn_back(turns: Floats, places: Ints, nodes: Ints, x: Floats, y: Floats) -> None:
    for i in range(len(x)):
        y[i] = x[i]
    for k in range(len(places)):
        i, n = places[k], nodes[k]
        for c in range(3):
            y[i + c] = turns[n, 0, c] * x[i] + turns[n, 1, c] * x[i + 1] + turns[n, 2, c] * x[i + 2]
