"""Constraints that have coordinates in common, and the motions that they allow."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy import sparse
from scipy.linalg import get_lapack_funcs
from scipy.sparse.csgraph import connected_components

from lamella._jit import kernel
from lamella.assembly.pattern import Pattern
from lamella.roles import Floats, Ints
from lamella.solve.base import PIVOT_TOLERANCE

_geqrf, _orgqr = get_lapack_funcs(("geqrf", "orgqr"), dtype=np.float64)

SOFTEST = 1e-6
"""Least stiffness that scales a coordinate, relative to the largest in its group, for equal entries in J."""


class Group:
    """Constraints that have coordinates in common, and the motions that they allow.

    Args:
        rows: the constraints, rows of J, shape (l,).
        coords: the coordinates in them, shape (m,).
        pattern: pattern of K and J.
    """

    def __init__(self, rows: Ints, coords: Ints, pattern: Pattern) -> None:
        self.rows, self.coords = rows, coords
        self.n_motion = max(len(coords) - len(rows), 0)
        self.N, self.P = np.zeros((len(coords), self.n_motion)), np.zeros((len(coords), len(rows)))
        row_of, column_of = pattern.j_rows, np.asarray(pattern.j_indices, np.int64)
        self._entries = np.flatnonzero(np.isin(row_of, rows))
        self._places = np.searchsorted(coords, column_of[self._entries]), np.searchsorted(rows, row_of[self._entries])

    def decompose(self, j: Floats, stiffness: Floats) -> int:
        """Find motions N (m, m - l) with J N = 0, and P (m, l) with J P = 1; -1, or the constraint that repeats others.

        Coordinates of different units are made alike by their stiffness d_i^2; those that have none, which constraints alone
        determine, by their entries in J. With (J d^-1)^T = [Q_1 Q_2] [R, 0]^T,

            N = d^-1 Q_2,      P = d^-1 Q_1 R^-T

        Args:
            j: entries of J.
            stiffness: diagonal of K, shape (n,).
        """
        m, n_lam = len(self.coords), len(self.rows)
        if n_lam > m:
            return int(self.rows[-1])
        J, d, size = np.zeros((m, n_lam), order="F"), np.empty(m), np.empty(n_lam)
        _scaled(j, self._entries, *self._places, stiffness, self.coords, J, d, size)
        qr, tau, _, _ = _geqrf(J)
        pivots = np.abs(qr.diagonal())
        if not (pivots > PIVOT_TOLERANCE * size).all():  # or not a number
            return int(self.rows[np.argmin(pivots / np.maximum(size, np.finfo(float).tiny))])
        Q = np.zeros((m, m), order="F")
        Q[:, :n_lam] = qr
        Q = _orgqr(Q, tau, overwrite_a=1)[0]
        _unscaled(Q, qr, d, self.N, self.P)
        return -1


@kernel
def _scaled(
    j: Floats, entries: Ints, rows: Ints, cols: Ints, stiffness: Floats, coords: Ints, J: Floats, d: Floats, size: Floats
) -> None:
    """The scaled Jacobian (coordinate, constraint), the scale of coordinates, and the length of each constraint's column."""
    for e in range(len(entries)):
        J[rows[e], cols[e]] = j[entries[e]]
    stiffest, largest = 0.0, 0.0
    for i in range(len(d)):
        stiffest, d[i] = max(stiffest, abs(stiffness[coords[i]])), 0.0
        for a in range(len(size)):
            d[i] = max(d[i], J[i, a] ** 2)
        largest = max(largest, d[i])
    softest = SOFTEST * (stiffest if stiffest > 0.0 else 1.0) / (largest if largest > 0.0 else 1.0)
    for i in range(len(d)):
        d[i] = np.sqrt(max(abs(stiffness[coords[i]]), softest * d[i]))
        if d[i] == 0.0:
            d[i] = 1.0
    for a in range(len(size)):
        square = 0.0
        for i in range(len(d)):
            J[i, a] /= d[i]
            square += J[i, a] ** 2
        size[a] = np.sqrt(square)


@kernel
def _unscaled(Q: Floats, R: Floats, d: Floats, N: Floats, P: Floats) -> None:
    """N = d^-1 Q_2 and P = d^-1 Q_1 R^-T. For so small an R, LAPACK's threads take a hundred times longer than the arithmetic."""
    n_lam = P.shape[1]
    for i in range(len(d)):
        for k in range(n_lam - 1, -1, -1):
            x = Q[i, k] / d[i]
            for a in range(k + 1, n_lam):
                x -= R[k, a] * P[i, a]
            P[i, k] = x / R[k, k]
        for k in range(N.shape[1]):
            N[i, k] = Q[i, n_lam + k] / d[i]


def groups_of(pattern: Pattern) -> list[Group]:
    """The groups of a pattern's constraints."""
    n, n_lam = pattern.n, pattern.n_lam
    rows, cols = pattern.j_rows, np.asarray(pattern.j_indices, np.int64)
    graph = sparse.coo_array((np.ones(len(rows)), (rows, n_lam + cols)), shape=(n_lam + n, n_lam + n))
    label = connected_components(graph, directed=False)[1]
    return [
        Group(np.flatnonzero(label[:n_lam] == number), np.flatnonzero(label[n_lam:] == number), pattern)
        for number in np.unique(label[:n_lam])
    ]


def reduction_cost(pattern: Pattern, groups: Sequence[Group]) -> float:
    """Operations of one decomposition of J and of N^T K N, an entry of K at a time.

    Within a group of m coordinates and l constraints N is full: its orthogonal factors take about 4 m^2 l, and an entry between
    groups of w and w' motions w w'.
    """
    width = np.ones(pattern.n)
    for group in groups:
        width[group.coords] = group.n_motion
    entries = float(width[pattern.rows] @ width[np.asarray(pattern.indices, np.int64)])
    return entries + sum(4.0 * len(group.coords) ** 2 * len(group.rows) for group in groups)
