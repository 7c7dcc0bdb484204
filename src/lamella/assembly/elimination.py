"""Elimination of constant linear constraints: C q = c(t) becomes q = T u + G c(t) with the independent coordinates u."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from copy import copy
from functools import cached_property
from heapq import heapify, heappop, heappush
from itertools import pairwise

import numpy as np
from scipy import sparse
from scipy.sparse import linalg

from lamella.assembly.operator import SumOperator
from lamella.assembly.pattern_kernels import sorted_by
from lamella.assembly.row_form import Diagonal, Form, form_of, taken
from lamella.dofs import LinearRow, Motion
from lamella.errors import ConstraintError
from lamella.roles import Floats, Ints

NEGLIGIBLE = 1e-10
"""Coefficients below this share of the row's largest one count as zero while rows are reduced."""
COLUMNS = 64
"""Right-hand sides solved for at once."""
FEW = 12
"""Rows for which a product is worth its numbers in any case."""


class Elimination:
    """The map between independent and all coordinates.

    Args:
        T: sparse (n_q, n_u).
        dependent: coordinates that are no unknowns, in the order of the rows that are kept, shape (n_rows,).
        rows: all rows.
        kept: numbers of those that determine the dependent coordinates; the others repeat these.
        form: all rows as arrays.

    Attributes:
        independent: coordinates kept as unknowns u, shape (n_u,).
        rows: the rows kept, in the order of ``C``.
        moving: those whose right-hand side changes with time.
        n_q: number of all coordinates.
        relations: for each row that repeats others the relation sum_k x_k row_k = 0 as {k: x_k}; its own x is 1.

    Raises:
        ConstraintError: a row that repeats others contradicts them.
    """

    def __init__(self, T: sparse.csr_array, dependent: Ints, rows: Sequence[LinearRow], kept: Sequence[int], form: Form) -> None:
        self.n_q = n_q = len(T.indptr) - 1
        self.T, self.kept, self.dependent = T, tuple(kept), dependent
        free = np.ones(n_q, bool)
        free[dependent] = False
        self.independent = np.flatnonzero(free)
        self._form = form
        self._forces: dict[bytes, Callable[[Floats], Floats]] = {}
        self._kept = form if len(kept) == len(rows) else taken(form, self.kept)
        self.alone = len(self._kept[1]) == len(self.kept)
        """Whether each row holds one coordinate, as on a clamped edge: C_d and C C^T are diagonal then."""
        if self.alone:
            self._inverse = Diagonal(self._kept[2]) if kept else None
        else:
            self._inverse = linalg.splu(sparse.csc_array(self.C[:, dependent]))
        self._take(rows)

    @cached_property
    def C(self) -> sparse.csr_array:
        """The constraints kept, sparse (n_rows, n_q), with full row rank."""
        starts, coords, coefs = self._kept
        found = sparse.csr_array((coefs, coords, starts), shape=(len(self.kept), self.n_q), copy=True)
        found.sum_duplicates()
        return found

    @cached_property
    def _gram(self) -> Diagonal | linalg.SuperLU | None:
        """The factorised C C^T; reactions alone ask for it."""
        if not self.kept:
            return None
        if self.alone:
            return Diagonal(self._kept[2] ** 2)
        return linalg.splu(sparse.csc_array(self.C @ self.C.T))

    @property
    def held_coordinates(self) -> Ints:
        """The coordinates that the rows kept hold, alone or with others; some may be listed twice."""
        return self._kept[1]

    def entries_of(self, rows: Ints) -> tuple[Ints, Ints, Floats]:
        """The entries of some of the rows kept: which of these, coordinate and coefficient of each."""
        starts, coords, coefs = taken(self._kept, rows)
        return np.repeat(np.arange(len(rows)), np.diff(starts)), coords, coefs

    def _take(self, rows: Sequence[LinearRow]) -> None:
        self.rows = tuple(rows[number] for number in self.kept)
        self.moving: Ints = np.array([k for k, row in enumerate(self.rows) if row.motion is not None], dtype=np.int64)
        self._motions = [row.motion for row in self.rows if row.motion is not None]
        self.relations = self._repeated(rows)

    def of(self, rows: Sequence[LinearRow], n_q: int) -> Elimination | None:
        """The elimination of rows with the same coefficients, which may be held at other values; None when these differ."""
        same = n_q == self.n_q and all(map(np.array_equal, self._form, form_of(rows)))
        if not same:
            return None
        found = copy(self)
        found._take(rows)
        return found

    def _repeated(self, rows: Sequence[LinearRow]) -> tuple[dict[int, float], ...]:
        """The rows that are not kept as sums of those that are: x C_d = row_d in the dependent coordinates."""
        numbers = sorted(set(range(len(rows))).difference(self.kept))
        if not numbers:
            return ()
        relations = []
        lengths = np.array([np.abs(row.coefs).max() for row in self.rows])
        for number in numbers:
            coefs = np.zeros(self.n_q)
            np.add.at(coefs, rows[number].coords, rows[number].coefs)
            shares = self._inverse.solve(coefs[self.dependent], "T") if self._inverse else lengths
            used = np.flatnonzero(np.abs(shares) * lengths > NEGLIGIBLE * np.abs(rows[number].coefs).max())
            relation = {number: 1.0} | {self.kept[k]: -float(shares[k]) for k in used}
            _check_repeated(rows[number], relation, rows)
            relations.append(relation)
        return tuple(relations)

    def particular(self, c: Floats) -> Floats:
        """The coordinates G c that obey C q = c with all independent ones 0, shape (n_q,) or (n_q, m) for c (n_rows, m)."""
        q = np.zeros((self.n_q, *c.shape[1:]))
        if self._inverse is not None:
            q[self.dependent] = self._inverse.solve(c)
        return q

    @property
    def of_motions(self) -> sparse.csr_array:
        """The columns of G that belong to moving rows, sparse (n_q, n_moving)."""
        if not self.moves:
            return sparse.csr_array((self.n_q, 0))
        units = np.zeros((len(self.rows), len(self.moving)))
        units[self.moving, np.arange(len(self.moving))] = 1.0
        return sparse.csr_array(self.particular(units))

    @property
    def moves(self) -> bool:
        """True when a support moves."""
        return bool(self._motions)

    def changes_like(self, other: Elimination) -> bool:
        """Whether equal changes of the unknowns, and of time, change coordinates equally: supports may stand at other places."""
        return self.T is other.T and np.array_equal(self.moving, other.moving) and self._motions == other._motions

    @property
    def constant(self) -> Floats:
        """The part of c(t) that does not move, shape (n_rows,)."""
        return np.array([row.constant for row in self.rows])

    def right_hand_side(self, t: float, factor: float = 1.0) -> Floats:
        """c(t) with its motions scaled by ``factor``, shape (n_rows,)."""
        c = self.constant
        c[self.moving] += factor * self.motions(t)
        return c

    def motions(self, t: float) -> Floats:
        """Motions of the moving rows, shape (n_moving,)."""
        return np.array([motion.value(t) for motion in self._motions])

    def rates(self, t: float) -> Floats:
        """First derivative of c of the moving rows by time, shape (n_moving,)."""
        return np.array([motion.rate(t) for motion in self._motions])

    def accelerations(self, t: float) -> Floats:
        """Second derivative of c of the moving rows by time, shape (n_moving,)."""
        return np.array([motion.acceleration(t) for motion in self._motions])

    def row_forces(self, reaction: Floats) -> Floats:
        """Force of each row from the generalised reaction R = C^T mu (n_q,): mu solves C C^T mu = C R exactly."""
        return self._gram.solve(self.C @ reaction) if self._gram else np.zeros(0)

    def forces_of(self, rows: Ints) -> Callable[[Floats], Floats]:
        """The function from R (n_q,) to the forces mu of some of the rows kept; where rows are ``alone`` R may be (n, n_q).

        It is the product with their rows of (C C^T)^-1 C, found once, unless these hold more numbers than the factorisation.
        """
        key = rows.tobytes()
        if key not in self._forces:
            self._forces[key] = self._forces_of(rows)
        return self._forces[key]

    def _forces_of(self, rows: Ints) -> Callable[[Floats], Floats]:
        if self._gram is None or not len(rows):
            return lambda reaction: np.zeros((*reaction.shape[:-1], 0))
        if self.alone:
            _, coords, coefs = self._kept
            places, shares = coords[rows], 1.0 / coefs[rows]
            return lambda reaction: shares * reaction.take(places, -1)
        gram, parts = self._gram, []
        for first in range(0, len(rows), COLUMNS):
            chosen = rows[first : first + COLUMNS]
            units = np.zeros((len(self.rows), len(chosen)))
            units[chosen, np.arange(len(chosen))] = 1.0
            parts.append(sparse.csr_array(gram.solve(units).T) @ self.C)
        found = sparse.csr_array(sparse.vstack(parts))
        if found.nnz > gram.nnz + self.C.nnz and len(rows) > FEW:
            return lambda reaction: self.row_forces(reaction)[rows]
        return SumOperator.of(found)


def eliminate(rows: Sequence[LinearRow], n_q: int, like: Elimination | None = None) -> Elimination:
    """Reduce the rows to dependent coordinates expressed by independent ones.

    Each row, after substitution of what is already dependent, gives up the coordinate with its largest coefficient.

    Args:
        rows: the constraints.
        n_q: number of coordinates.
        like: that of another model, from which this one differs by little: coordinates given up there are given up before others.

    Raises:
        ConstraintError: a row contradicts others.
    """
    known = None if like is None else like.of(rows, n_q)
    if known is not None:
        return known
    solved: dict[int, Expression] = {}
    order: dict[int, int] = {}
    resolved: dict[int, Expression] = {}
    kept: list[int] = []
    first = frozenset(() if like is None else like.dependent.tolist())
    form = form_of(rows)
    starts, coords, coefs = (part.tolist() for part in form)
    for number, (start, end) in enumerate(pairwise(starts)):
        if end == start + 1 and coefs[start] and coords[start] not in solved:  # a coordinate alone, as on a clamped edge
            kept.append(number)
            order[coords[start]] = len(order)
            solved[coords[start]] = NOTHING
            continue
        terms = _substitute(coords[start:end], coefs[start:end], solved, order, resolved)
        if not terms:
            continue
        kept.append(number)
        pivot = max(terms, key=lambda c: (c in first, abs(terms[c])))
        lead = terms.pop(pivot)
        order[pivot] = len(order)
        solved[pivot] = {c: -x / lead for c, x in terms.items()}
    return Elimination(_map(solved, order, n_q), np.array(list(order), dtype=np.int64), rows, kept, form)


Expression = dict[int, float]
"""A dependent coordinate as sum terms[c] q_c, beside what right-hand sides add; the q_c became dependent later or not at all."""


NOTHING: Expression = {}
"""What a coordinate that is held alone is expressed by; not to be written to."""


def _substitute(
    coords: Sequence[int],
    coefs: Sequence[float],
    solved: dict[int, Expression],
    order: dict[int, int],
    resolved: dict[int, Expression],
) -> Expression:
    """The coefficients of a row, free of dependent coordinates.

    Args:
        coords, coefs: the row.
        solved: the dependent coordinates, as they became dependent.
        order: when they did.
        resolved: those that rows have asked for, as they are now.
    """
    terms: Expression = {}
    for coordinate, coefficient in zip(coords, coefs, strict=True):
        if coordinate in solved:
            if coordinate not in resolved:
                resolved[coordinate] = dict(solved[coordinate])
            _resolve(resolved[coordinate], solved, order)
            _add(terms, coefficient, resolved[coordinate])
        else:
            terms[coordinate] = terms.get(coordinate, 0.0) + coefficient
    negligible = NEGLIGIBLE * max(map(abs, coefs))
    return {c: x for c, x in terms.items() if abs(x) > negligible}


def _resolve(terms: Expression, solved: dict[int, Expression], order: dict[int, int]) -> None:
    """Free an expression of dependent coordinates, which are replaced in the order in which they became dependent."""
    waiting = [(order[c], c) for c in terms if c in order]
    heapify(waiting)
    while waiting:
        dependent = heappop(waiting)[1]
        by, coefficient = solved[dependent], terms.pop(dependent)
        for c in by:
            if c in order and c not in terms:
                heappush(waiting, (order[c], c))
        _add(terms, coefficient, by)


def _add(total: Expression, factor: float, part: Expression) -> None:
    for key, x in part.items():
        total[key] = total.get(key, 0.0) + factor * x


def _map(solved: dict[int, Expression], order: dict[int, int], n_q: int) -> sparse.csr_array:
    """T from q_d = L q_d + B u for the dependent coordinates, with L strictly triangular: q_d = (1 - L)^-1 B u."""
    dependent, n_d, n_u = np.array(list(order), dtype=np.int64), len(order), n_q - len(order)
    free = np.ones(n_q, bool)
    free[dependent] = False
    place = np.empty(n_q, dtype=np.int64)
    place[free], place[dependent] = np.arange(n_u), n_u + np.arange(n_d)
    counts = np.array([len(terms) for terms in solved.values()], dtype=np.int64)
    if not counts.any():
        return sparse.csr_array((np.ones(n_u), np.arange(n_u), np.append(0, np.cumsum(free))), shape=(n_q, n_u))
    cols = place[np.array([c for terms in solved.values() for c in terms], dtype=np.int64)]
    values = np.array([x for terms in solved.values() for x in terms.values()], float)
    if np.any(cols >= n_u):
        rows = np.repeat(np.arange(n_d), counts)
        both = sparse.csr_array(sparse.coo_array((values, (rows, cols)), shape=(n_d, n_u + n_d)))
        B, L = sparse.csr_array(both[:, :n_u]), sparse.csr_array(both[:, n_u:])
        while L.nnz:  # (1 - L)^-1 = ... (1 + L^4) (1 + L^2) (1 + L), since a power of L vanishes
            B, L = sparse.csr_array(B + L @ B), sparse.csr_array(L @ L)
        counts, cols, values = np.diff(B.indptr), B.indices, B.data
    every = np.concatenate([np.flatnonzero(free), np.repeat(dependent, counts)])
    by_row, ends = sorted_by(every, n_q)
    data, indices = np.concatenate([np.ones(n_u), values]), np.concatenate([np.arange(n_u), cols])
    T = sparse.csr_array((data[by_row], indices[by_row], np.concatenate([[0], ends[:n_q]])), shape=(n_q, n_u))
    T.sort_indices()
    return T


def _check_repeated(row: LinearRow, relation: dict[int, float], rows: Sequence[LinearRow]) -> None:
    """What is left of a row that repeats others must say 0 = 0, now and (through its motions) at all times."""
    constant = sum(x * rows[k].constant for k, x in relation.items())
    scale = 1.0 + max(abs(x * rows[k].constant) for k, x in relation.items())
    motions: dict[Motion, float] = {}  # equal ones are the same: each item makes its own
    for k, x in relation.items():
        motion = rows[k].motion
        if motion is not None:
            motions[motion] = motions.get(motion, 0.0) + x
    if abs(constant) > 1e-9 * scale or any(abs(x) > NEGLIGIBLE for x in motions.values()):
        others = ", ".join(sorted({rows[k].label for k in relation if rows[k] is not row})[:4])
        raise ConstraintError(
            f"{row.label} contradicts {others}: both hold the same coordinates at different values; remove one of them"
        )
