"""Solutions by a factorisation that was made before the nodes of plates turned, each by itself."""

from __future__ import annotations

import numpy as np

from lamella._jit import inlined, kernel
from lamella.lane import WIDTH, load_at, number_at, put_at, sqrt, store_at
from lamella.roles import Floats, Ints
from lamella.solve.base import LinearSolver
from lamella.solve.turned import Nodes, TurnedSolver, Vectors

APART = 6.0
"""How far nodes may have turned against each other [rad], entry by entry of their rotations, times the slenderness. Below, plates
that swing or unfold cost up to a third less; above, one of 1.5 mm that is struck so that its slopes change by a tenth in a step
costs a tenth more."""
Vector = tuple[float, float, float]


class NodeTurns:
    """The rotations Q = diag(R_k, ..., 1) of the nodes of plates from one place to another, R_k = F_k' F_k^T with the frames
    F = (t, m x t, m) of the nodes' normals m and of the bisectors t of their slopes.

    Args:
        nodes: where they stand.
    """

    def __init__(self, nodes: Nodes) -> None:
        self._nodes = nodes
        self._start, self._turns, self._returns = np.zeros((3, 9 * len(nodes.slopes) + WIDTH))

    def begin(self, u: Floats) -> None:
        """Take the independent coordinates of the first place."""
        _begin(u, self._nodes.slopes, self._start)

    def turn(self, u: Floats) -> float:
        """Take those of the second one; how far the nodes have turned against each other [rad], entry by entry of R_k."""
        return _between(u, self._nodes.slopes, self._start, self._turns, self._returns)

    def forth(self, x: Floats) -> Floats:
        """Q x."""
        return self._turned(self._returns, x)

    def back(self, x: Floats) -> Floats:
        """Q^T x."""
        return self._turned(self._turns, x)

    def _turned(self, columns: Floats, x: Floats) -> Floats:
        nodes, there = self._nodes, np.empty(len(x) + WIDTH)
        _turn(columns, nodes.places, nodes.owners, nodes.others, nodes.n_motion, x, there)
        return there[: len(x)]


class NodeTurnedSolver(TurnedSolver):
    """A solver whose factorisation of A(u), seen from axes that turn with each node of the plates, serves for A(u') too:

        A(u')^-1 = Q A(u)^-1 Q^T

    with the rotations Q of the nodes from u to u' (:class:`NodeTurns`). Where the structure turns as
    a whole this is a :class:`TurnedSolver`; where it bends, Q takes from A the error of first order in the
    angles, which the membrane, stiff beside the bending, magnifies. A displacement of all nodes is not one of the old matrix any
    more, to second order in how they turn against each other: beyond ``APART`` they turn together again.

    Args:
        linear: the solver.
        vectors: of the equations to be solved.
        nodes: of the same.
    """

    def __init__(self, linear: LinearSolver, vectors: Vectors, nodes: Nodes) -> None:
        super().__init__(linear, vectors)
        self._turns, self._by_nodes, self._apart = NodeTurns(nodes), False, APART / max(nodes.slenderness, 1.0)

    def factorise(self, k: Floats, j: Floats) -> None:
        """Factorise the matrix; see :meth:`made_at`."""
        self._by_nodes = False
        super().factorise(k, j)

    def made_at(self, u: Floats) -> None:
        """Take note of the independent coordinates at which the present factorisation was made."""
        super().made_at(u)
        self._turns.begin(u)
        self._by_nodes = False

    def turn(self, u: Floats) -> None:
        """Turn the factorisation, whose place is known, to the independent coordinates ``u``."""
        self._by_nodes = self._turns.turn(u) <= self._apart
        if self._by_nodes:
            self._turned = True
            self.linear.shorten()
        else:
            super().turn(u)

    def _back_to_old(self, r: Floats) -> Floats:
        return self._turns.back(r) if self._by_nodes else super()._back_to_old(r)

    def _to_new(self, x: Floats) -> Floats:
        return self._turns.forth(x) if self._by_nodes else super()._to_new(x)


def turned_solver(linear: LinearSolver, vectors: Vectors) -> TurnedSolver | None:
    """The solver with a factorisation that turns along, None where nothing turns."""
    if vectors.nodes is not None and len(vectors.nodes.slopes):
        return NodeTurnedSolver(linear, vectors, vectors.nodes)
    return TurnedSolver(linear, vectors) if len(vectors.slopes) else None


@inlined
def _frame(q: Floats, slopes: Ints, k: int) -> tuple[Vector, Vector, Vector]:
    """The columns t, m x t, m of the frame of a node."""
    i, j = slopes[k, 0], slopes[k, 1]
    a0, a1, a2, b0, b1, b2 = q[i], q[i + 1], q[i + 2], q[j], q[j + 1], q[j + 2]
    a, b = 1.0 / sqrt(a0 * a0 + a1 * a1 + a2 * a2), 1.0 / sqrt(b0 * b0 + b1 * b1 + b2 * b2)
    m0, m1, m2 = a1 * b2 - a2 * b1, a2 * b0 - a0 * b2, a0 * b1 - a1 * b0
    t0, t1, t2 = a * a0 + b * b0, a * a1 + b * b1, a * a2 + b * b2
    m, t = 1.0 / sqrt(m0 * m0 + m1 * m1 + m2 * m2), 1.0 / sqrt(t0 * t0 + t1 * t1 + t2 * t2)
    m0, m1, m2, t0, t1, t2 = m * m0, m * m1, m * m2, t * t0, t * t1, t * t2
    return (t0, t1, t2), (m1 * t2 - m2 * t1, m2 * t0 - m0 * t2, m0 * t1 - m1 * t0), (m0, m1, m2)


@kernel
def _begin(q: Floats, slopes: Ints, start: Floats) -> None:
    """The columns of the frames of all nodes, one after the other."""
    for k in range(len(slopes)):
        t, s, m = _frame(q, slopes, k)
        for i in range(3):
            put_at(start, 9 * k + i, t[i])
            put_at(start, 9 * k + 3 + i, s[i])
            put_at(start, 9 * k + 6 + i, m[i])


@kernel
def _between(q: Floats, slopes: Ints, start: Floats, turns: Floats, returns: Floats) -> float:
    """The rotation of each node with its transpose, row by row, and their largest difference from that of the first."""
    apart = 0.0
    for k in range(len(slopes)):
        t, s, m = _frame(q, slopes, k)
        for i in range(3):
            for j in range(3):
                at = 9 * k + j
                total = t[i] * number_at(start, at) + s[i] * number_at(start, at + 3) + m[i] * number_at(start, at + 6)
                put_at(turns, 9 * k + 3 * i + j, total)
                put_at(returns, 9 * k + 3 * j + i, total)
                apart = max(apart, abs(total - number_at(turns, 3 * i + j)))
    return apart


@kernel
def _turn(columns: Floats, places: Ints, owners: Ints, others: Ints, n_motion: int, x: Floats, y: Floats) -> None:
    """y = Q x with the columns of the rotations; a lane's surplus numbers are overwritten by the next, or lie behind the last."""
    for k in range(len(places)):
        i, n = number_at(places, k), 9 * number_at(owners, k)
        lane = number_at(x, i) * load_at(columns, n) + number_at(x, i + 1) * load_at(columns, n + 3)
        store_at(y, i, lane + number_at(x, i + 2) * load_at(columns, n + 6))
    for k in range(len(others)):
        put_at(y, number_at(others, k), number_at(x, number_at(others, k)))
    for i in range(n_motion, len(x)):
        y[i] = x[i]
