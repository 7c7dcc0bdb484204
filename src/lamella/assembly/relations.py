"""Relations among all rows of a model: which rows of joints say what rows of bodies and of other joints say already."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import sparse

from lamella.assembly.constraints import ConstraintStack
from lamella.assembly.elimination import Elimination
from lamella.assembly.independence import Redundancy
from lamella.model import Model
from lamella.roles import Bools, Floats, Ints

BODY = -1
"""Owner of the rows by which bodies hold themselves together."""

TAKES_PART = 1e-6
"""Share in a relation, rows being of unit length, from which a row takes part; what rounding leaves is 1e-10 and below."""


@dataclass(frozen=True)
class Rows:
    """All rows of a model: the linear ones, then those with multipliers.

    Args:
        labels: what each holds, in words.
        owners: number of the joint each belongs to, ``BODY`` for those of bodies, shape (n,).
        names: names of the joints.
        of_edges: which joints hold an edge.
        lengths: length of each row when every coordinate is measured by its magnitude, shape (n,).
        n_linear: number of linear rows.
    """

    labels: tuple[str, ...]
    owners: Ints
    names: tuple[str, ...]
    of_edges: Bools
    lengths: Floats
    n_linear: int

    @classmethod
    def of(cls, model: Model, stack: ConstraintStack, row_size: Floats) -> Rows:
        """The rows of a model; ``row_size`` are the lengths of those with multipliers."""
        n_linear = len(model.rows)
        owners = np.full(n_linear + stack.n_all, BODY)
        for number, support in enumerate(model.supports):
            owners[list(support.rows)] = number
            owners[[n_linear + row for row in support.dots]] = number
        names = [support.name for support in model.supports]
        for block, part in stack.blocks:
            if not block.body and not (part.start == 0 and model.dots):  # the dot rows of joints come first
                owners[n_linear + part.start : n_linear + part.stop] = len(names)
                names.append(block.name)
        lengths = [float(np.linalg.norm(row.coefs * model.magnitude[row.coords])) for row in model.rows]
        of_edges = [support.edge for support in model.supports] + [False] * (len(names) - len(model.supports))
        labels = (*(row.label for row in model.rows), *stack.labels)
        return cls(labels, owners, tuple(names), np.array(of_edges, dtype=bool), np.concatenate([lengths, row_size]), n_linear)

    @property
    def described(self) -> list[str]:
        """The rows in words, with the names of their joints."""
        return [self._described(label, owner) for label, owner in zip(self.labels, self.owners.tolist(), strict=True)]

    def _described(self, label: str, owner: int) -> str:
        name = "" if owner == BODY else self.names[owner]
        named = owner == BODY or label.startswith(f"{name}: ") or label.endswith(f" of {name}") or f"'{name}'" in label
        return label if named else f"{label} by '{name}'"


def relations(rows: Rows, elimination: Elimination, jacobian: sparse.csr_array, reduced: Floats, kept: Ints) -> Floats:
    """All independent relations sum_k R_ik row_k = 0 of rows scaled to unit length, shape (n_relations, n_rows).

    Those that elimination meets are among linear rows. A row with multipliers that depends on others in independent coordinates,
    J_d T = s J_kept T, does so in all coordinates up to linear rows: J_d - s J_kept = mu C.

    Args:
        rows: the rows.
        elimination: what was made of the linear ones.
        jacobian: Phi_q of all rows with multipliers, sparse (n_all, n_q).
        reduced: the same in independent coordinates, each column times its magnitude, shape (n_all, n_u).
        kept: rows with multipliers that are independent.
    """
    dropped = np.setdiff1d(np.arange(len(reduced)), kept)
    R = np.zeros((len(elimination.relations) + len(dropped), len(rows.labels)))
    for i, relation in enumerate(elimination.relations):
        R[i, list(relation)] = list(relation.values())
    if len(dropped):
        shares = np.linalg.lstsq(reduced[kept].T, reduced[dropped].T, rcond=None)[0].T
        rest = jacobian[dropped].toarray() - shares @ jacobian[kept].toarray()
        of_dropped = R[len(elimination.relations) :]
        of_dropped[np.arange(len(dropped)), rows.n_linear + dropped] = 1.0
        of_dropped[:, rows.n_linear + kept] = -shares
        of_dropped[:, list(elimination.kept)] = [-elimination.row_forces(one) for one in rest]
    R *= rows.lengths
    return R / np.maximum(np.abs(R).max(axis=1, keepdims=True, initial=0.0), 1e-300)


def repeated_rows(rows: Rows, R: Floats, n_eliminated: int) -> list[Redundancy]:
    """The rows of joints that follow from rows before them, when bodies come first, then linear rows, then the others.

    Each relation is solved for its last row (Gauss and Jordan). Those of elimination, the first ``n_eliminated``, are so
    already; the others exchange a body's row, which the independent rows do without, for the joint's row that makes it
    superfluous.

    A linear row that follows from bodies and from its own joint alone is none of them: the joint's reaction is determined as a
    whole.
    """
    order = np.concatenate([np.flatnonzero(rows.owners == BODY), np.flatnonzero(rows.owners != BODY)])
    R = R[:, order].copy()
    pivots = [_last(one) for one in R[:n_eliminated]]
    for i in range(n_eliminated, len(R)):
        pivot = _last(R[i])
        pivots.append(pivot)
        R[i] /= R[i, pivot]
        others = np.flatnonzero(R[:, pivot])
        for j in others[others != i]:
            R[j] -= R[j, pivot] * R[i]
            R[j, np.abs(R[j]) < 0.01 * TAKES_PART * np.abs(R[j]).max()] = 0.0
    found = []
    for one, pivot in zip(R, pivots, strict=True):
        row, owner = int(order[pivot]), rows.owners[order[pivot]]
        if owner == BODY:
            continue
        parts = np.flatnonzero(np.abs(one) > TAKES_PART * np.abs(one).max())
        parts = order[parts[np.argsort(-np.abs(one[parts]), kind="stable")]]
        repeats = tuple(int(k) for k in parts if rows.owners[k] not in (BODY, owner))
        if repeats or row >= rows.n_linear:
            own = tuple(int(k) for k in parts if rows.owners[k] == owner and k != row)
            found.append(Redundancy(row, repeats or own, bool((rows.owners[parts] == BODY).any())))
    return sorted(found, key=lambda item: item.row)


def _last(relation: Floats) -> int:
    return int(np.flatnonzero(np.abs(relation) > TAKES_PART * np.abs(relation).max())[-1])


Meeting = tuple[int, tuple[int, ...]]
"""A joint, and the joints whose rows one of its rows repeats."""


def told_apart(rows: Rows, found: Sequence[Redundancy]) -> tuple[list[Redundancy], dict[Meeting, int]]:
    """What leaves reactions undetermined, and the numbers of rows by which edges overlap.

    Edges of plates that meet hold their common node twice, whoever models them. This is an overlap as long as no rigidity
    of a body takes part, and unless the whole joint holds what a single other joint holds already.
    """
    meetings = [(int(rows.owners[item.row]), tuple(sorted({int(rows.owners[k]) for k in item.repeats}))) for item in found]
    shared = Counter(meetings)
    redundant: list[Redundancy] = []
    overlaps: Counter[Meeting] = Counter()
    for item, meeting in zip(found, meetings, strict=True):
        owner, others = meeting
        nothing_new = len(others) == 1 and shared[meeting] == np.count_nonzero(rows.owners == owner)
        if rows.of_edges[[owner, *others]].any() and not item.by_bodies and not nothing_new:
            overlaps[meeting] += 1
        else:
            redundant.append(item)
    return redundant, overlaps


def overlaps_described(rows: Rows, overlaps: dict[Meeting, int]) -> list[str]:
    """Overlaps in words, a sentence for each meeting."""
    words = []
    for (owner, others), number in overlaps.items():
        names = " and ".join(f"'{rows.names[k]}'" for k in others)
        words.append(
            f"where '{rows.names[owner]}' meets {names} it holds the same ({number} row{'s' * (number > 1)}); the reaction of "
            f"what they share is counted in {names}"
        )
    return words
