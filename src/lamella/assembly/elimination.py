"""Elimination of constant linear constraints: C q = c(t) becomes q = T u + G c(t) with the independent coordinates u."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np
from scipy import sparse
from scipy.sparse import linalg

from lamella.assembly.operator import SumOperator
from lamella.dofs import LinearRow, Motion
from lamella.errors import ConstraintError
from lamella.roles import Floats, Ints

NEGLIGIBLE = 1e-10
"""Coefficients below this share of the row's largest one count as zero while rows are reduced."""


class Elimination:
    """The map between independent and all coordinates.

    Args:
        independent: coordinates kept as unknowns u, shape (n_u,).
        T: sparse (n_q, n_u).
        G: sparse (n_q, n_rows).
        C: the constraints kept, sparse (n_rows, n_q), with full row rank.
        kept: rows of the model that were kept; the others repeat these.
        rows: the rows kept, in the order of ``C``.
        relations: for each row that repeats others the relation sum_k x_k row_k = 0 as {k: x_k}; its own x is 1.
    """

    def __init__(
        self,
        independent: Ints,
        T: sparse.csr_array,
        G: sparse.csr_array,
        C: sparse.csr_array,
        kept: tuple[int, ...],
        rows: tuple[LinearRow, ...],
        relations: tuple[dict[int, float], ...] = (),
    ) -> None:
        self.relations = relations
        self.independent, self.T, self.G, self.C, self.kept, self.rows = independent, T, G, C, kept, rows
        self._constant = np.array([row.constant for row in rows])
        self._moving = [(k, row.motion) for k, row in enumerate(rows) if row.motion is not None]
        self._gram, self._row_sum = linalg.splu(sparse.csc_array(C @ C.T)) if rows else None, SumOperator(C)

    @property
    def dependent(self) -> frozenset[int]:
        """Coordinates that are no unknowns."""
        return frozenset(range(len(self.T.indptr) - 1)) - frozenset(self.independent.tolist())

    @property
    def moves(self) -> bool:
        """True when a support moves."""
        return bool(self._moving)

    def right_hand_side(self, t: float, factor: float = 1.0) -> Floats:
        """c(t) with its motions scaled by ``factor``, shape (n_rows,)."""
        return self._constant + self._motion(t, "value") * factor

    def rates(self, t: float) -> Floats:
        """First derivative of c by time, shape (n_rows,)."""
        return self._motion(t, "rate")

    def accelerations(self, t: float) -> Floats:
        """Second derivative of c by time, shape (n_rows,)."""
        return self._motion(t, "acceleration")

    def row_forces(self, reaction: Floats) -> Floats:
        """Force of each row from the generalised reaction R = C^T mu (n_q,): mu solves C C^T mu = C R exactly."""
        return self._gram.solve(self._row_sum(reaction)) if self._gram else np.zeros(0)

    def _motion(self, t: float, derivative: str) -> Floats:
        values = np.zeros(len(self.rows))
        for k, motion in self._moving:
            values[k] = getattr(motion, derivative)(t)
        return values


def eliminate(rows: Sequence[LinearRow], n_q: int, preferred: Collection[int] = ()) -> Elimination:
    """Reduce the rows to dependent coordinates expressed by independent ones.

    Each row, after substitution of what is already dependent, gives up the coordinate with its largest coefficient.

    Args:
        rows: the constraints.
        n_q: number of coordinates.
        preferred: coordinates to give up before others: those that another model gives up, from which this one differs by little.

    Raises:
        ConstraintError: a row contradicts those before it.
    """
    solved: dict[int, tuple[dict[int, float], dict[int, float]]] = {}
    users: dict[int, set[int]] = {}
    kept: list[int] = []
    relations: list[dict[int, float]] = []
    for number, row in enumerate(rows):
        terms, sources = _substitute(row, number, solved)
        if not terms:
            _check_repeated(row, sources, rows)
            relations.append(sources)
            continue
        kept.append(number)
        pivot = max(terms, key=lambda c: (c in preferred, abs(terms[c])))
        lead = terms.pop(pivot)
        expression = ({c: -x / lead for c, x in terms.items()}, {k: x / lead for k, x in sources.items()})
        for dependent in users.pop(pivot, ()):
            _replace(solved[dependent], pivot, expression)
            for c in expression[0]:
                users.setdefault(c, set()).add(dependent)
        solved[pivot] = expression
        for c in expression[0]:
            users.setdefault(c, set()).add(pivot)
    return _matrices(rows, kept, solved, n_q, tuple(relations))


Expression = tuple[dict[int, float], dict[int, float]]


def _substitute(row: LinearRow, number: int, solved: dict[int, Expression]) -> Expression:
    """The row as sum terms[c] q_c = sum sources[k] c_k, free of dependent coordinates."""
    terms: dict[int, float] = {}
    sources: dict[int, float] = {number: 1.0}
    for coordinate, coefficient in zip(row.coords.tolist(), row.coefs.tolist(), strict=True):
        if coordinate in solved:
            for c, x in solved[coordinate][0].items():
                terms[c] = terms.get(c, 0.0) + coefficient * x
            for k, x in solved[coordinate][1].items():
                sources[k] = sources.get(k, 0.0) - coefficient * x
        else:
            terms[coordinate] = terms.get(coordinate, 0.0) + coefficient
    largest = float(np.abs(row.coefs).max())
    return {c: x for c, x in terms.items() if abs(x) > NEGLIGIBLE * largest}, sources


def _replace(expression: Expression, pivot: int, by: Expression) -> None:
    coefficient = expression[0].pop(pivot)
    for part, new in zip(expression, by, strict=True):
        for key, x in new.items():
            part[key] = part.get(key, 0.0) + coefficient * x


def _check_repeated(row: LinearRow, sources: dict[int, float], rows: Sequence[LinearRow]) -> None:
    """A row without terms must say 0 = 0, now and (through its motions) at all times."""
    constant = sum(x * rows[k].constant for k, x in sources.items())
    scale = 1.0 + max(abs(x * rows[k].constant) for k, x in sources.items())
    motions: dict[Motion, float] = {}  # equal ones are the same: each item makes its own
    for k, x in sources.items():
        motion = rows[k].motion
        if motion is not None:
            motions[motion] = motions.get(motion, 0.0) + x
    if abs(constant) > 1e-9 * scale or any(abs(x) > NEGLIGIBLE for x in motions.values()):
        others = ", ".join(sorted({rows[k].label for k in sources if rows[k] is not row})[:4])
        raise ConstraintError(
            f"{row.label} contradicts {others}: both hold the same coordinates at different values; remove one of them"
        )


def _matrices(
    rows: Sequence[LinearRow],
    kept: list[int],
    solved: dict[int, Expression],
    n_q: int,
    relations: tuple[dict[int, float], ...],
) -> Elimination:
    independent = np.array([c for c in range(n_q) if c not in solved], dtype=np.int64)
    column = {int(c): k for k, c in enumerate(independent)}
    source = {number: k for k, number in enumerate(kept)}
    t_entries = [(int(c), k, 1.0) for k, c in enumerate(independent)]
    t_entries += [(d, column[c], x) for d, (terms, _) in solved.items() for c, x in terms.items()]
    g_entries = [(d, source[k], x) for d, (_, sources) in solved.items() for k, x in sources.items() if k in source]
    c_entries = [
        (k, int(c), float(x))
        for k, number in enumerate(kept)
        for c, x in zip(rows[number].coords, rows[number].coefs, strict=True)
    ]
    return Elimination(
        independent,
        _sparse(t_entries, (n_q, len(independent))),
        _sparse(g_entries, (n_q, len(kept))),
        _sparse(c_entries, (len(kept), n_q)),
        tuple(kept),
        tuple(rows[number] for number in kept),
        relations,
    )


def _sparse(entries: list[tuple[int, int, float]], shape: tuple[int, int]) -> sparse.csr_array:
    i, j, x = (
        (np.array(part) for part in zip(*entries, strict=True)) if entries else (np.zeros(0, int), np.zeros(0, int), np.zeros(0))
    )
    return sparse.csr_array(sparse.coo_array((x, (i, j)), shape=shape))
