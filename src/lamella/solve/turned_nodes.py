"""Solutions by a factorisation that was made before the nodes of plates turned, each by itself."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from lamella._jit import kernel
from lamella.lane import sqrt
from lamella.roles import Floats, Ints
from lamella.solve.base import LinearSolver

if TYPE_CHECKING:
    from lamella.assembly.equations import Equations


class Nodes:
    """Where the nodes of plates stand among the independent coordinates; only those with both slopes there.

    Args:
        equations: the equations of a model.

    Attributes:
        slopes: first coordinate of r_x and of r_y of each node, shape (n_node, 2).
        places: first coordinate of each of their vectors that is whole, shape (n_vector,).
        owners: the node of each, shape (n_vector,).
    """

    def __init__(self, equations: Equations) -> None:
        independent = equations.elimination.independent
        slopes, places, owners, count = [np.zeros((0, 2), np.int64)], [np.zeros(0, np.int64)], [np.zeros(0, np.int64)], 0
        for plate in equations.model.plates:
            per_node = plate.element.vectors_per_node
            coords = 3 * (plate.first + np.arange(per_node * plate.n_nodes)).reshape(-1, per_node)
            at = np.searchsorted(independent, coords)
            first, last = (independent[np.minimum(at + c, len(independent) - 1)] for c in (0, 2))
            whole = (first == coords) & (last == coords + 2)
            pair = [plate.element.vector_names.index(name) for name in ("r_x", "r_y")]
            turning = np.all(whole[:, pair], axis=1)
            number = count + np.cumsum(turning) - 1
            chosen = whole & turning[:, None]
            slopes.append(at[turning][:, pair])
            places.append(at[chosen])
            owners.append(np.broadcast_to(number[:, None], chosen.shape)[chosen])
            count += int(np.count_nonzero(turning))
        self.slopes, self.places, self.owners = (np.concatenate(parts) for parts in (slopes, places, owners))


class NodeTurnedSolver(LinearSolver):
    """A solver whose factorisation of A(u), seen from axes that turn with each node of the plates, serves for A(u') too:

        A(u')^-1 = Q A(u)^-1 Q^T,    Q = diag(R_k, ..., 1),    R_k = F_k' F_k^T

    with the frames F = (t, m x t, m) of the nodes' normals m and of the bisectors t of their slopes. Where the structure turns as
    a whole this is :class:`~lamella.solve.turned.TurnedSolver`; where it bends, Q takes from A the error of first order in the
    angles, which the membrane, stiff beside the bending, magnifies. A displacement of all nodes is not one of the old matrix any
    more, to second order in how they turn against each other.

    Args:
        linear: the solver.
        nodes: of the equations to be solved.
    """

    def __init__(self, linear: LinearSolver, nodes: Nodes) -> None:
        self.linear, self.pattern, self._nodes = linear, linear.pattern, nodes
        self._start, self._frames, self._turns = np.zeros((3, len(nodes.slopes), 3, 3))
        self._turned = False

    @property
    def negative_pivots(self) -> int | None:
        """Number of negative eigenvalues, which no rotation changes."""
        return self.linear.negative_pivots

    def factorise(self, k: Floats, j: Floats) -> None:
        """Factorise the matrix; see :meth:`made_at`."""
        self._turned = False
        self.linear.factorise(k, j)

    def made_at(self, u: Floats) -> None:
        """Take note of the independent coordinates at which the present factorisation was made."""
        _frames(u, self._nodes.slopes, self._start)
        self._turned = False

    def turn(self, u: Floats) -> None:
        """Turn the factorisation, whose place is known, to the independent coordinates ``u``."""
        _frames(u, self._nodes.slopes, self._frames)
        _between(self._start, self._frames, self._turns)
        self._turned = True

    def solve(self, r: Floats, s: Floats) -> tuple[Floats, Floats]:
        """Solution for the present place."""
        if not self._turned:
            return self.linear.solve(r, s)
        there, x = np.empty_like(r), np.empty_like(r)
        _turn_back(self._turns, self._nodes.places, self._nodes.owners, r, there)
        found, y = self.linear.solve(there, s)
        _turn(self._turns, self._nodes.places, self._nodes.owners, found, x)
        return x, y


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
def _turn(turns: Floats, places: Ints, owners: Ints, x: Floats, y: Floats) -> None:
    for i in range(len(x)):
        y[i] = x[i]
    for k in range(len(places)):
        i, n = places[k], owners[k]
        for c in range(3):
            y[i + c] = turns[n, c, 0] * x[i] + turns[n, c, 1] * x[i + 1] + turns[n, c, 2] * x[i + 2]


@kernel
def _turn_back(turns: Floats, places: Ints, owners: Ints, x: Floats, y: Floats) -> None:
    for i in range(len(x)):
        y[i] = x[i]
    for k in range(len(places)):
        i, n = places[k], owners[k]
        for c in range(3):
            y[i + c] = turns[n, 0, c] * x[i] + turns[n, 1, c] * x[i + 1] + turns[n, 2, c] * x[i + 2]
