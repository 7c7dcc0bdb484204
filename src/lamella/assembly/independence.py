"""Which constraints with multipliers say something that the others do not say already."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lamella.roles import Bools, Floats, Ints

DEPENDENT = 1e-8
"""Share of a row that must lie outside the span of the rows before it; below, it repeats them. Rounding leaves about 1e-14."""

NAMED = 4
"""Constraints that a message names before it only counts them."""


@dataclass(frozen=True)
class Redundancy:
    """A row that repeats others.

    Args:
        row: its number.
        repeats: numbers of the rows of joints whose combination it is.
        by_bodies: whether rows of bodies take part.
    """

    row: int
    repeats: tuple[int, ...]
    by_bodies: bool = False


def independent_rows(jacobian: Floats, of_bodies: Bools) -> tuple[Ints, list[Redundancy]]:
    """Choose rows of full rank, those of bodies first, then the others in their order.

    Rows of bodies that repeat each other (two plates that share an edge both hold its direction at unit length) never contradict
    and are left out without a word. A row of a joint that repeats earlier ones is redundant: the distribution of the reactions
    among them is then not determined by rigid-body mechanics.

    Args:
        jacobian: Phi_q in independent coordinates, each column times the coordinate's magnitude, shape (n_lam, n_u).
        of_bodies: which rows belong to bodies, shape (n_lam,).

    Returns:
        Numbers of the rows kept, ascending, and the redundant ones among the others.
    """
    lengths = np.linalg.norm(jacobian, axis=1)
    typical = lengths.max(initial=0.0)
    order = np.concatenate([np.flatnonzero(of_bodies), np.flatnonzero(~of_bodies)])
    basis, kept = np.zeros((min(jacobian.shape), jacobian.shape[1])), []
    found: list[Redundancy] = []
    for row in order.tolist():
        rest = jacobian[row] / max(lengths[row], 1e-300)
        for _ in range(2):  # twice is enough (Giraud, Langou, Rozloznik 2005)
            rest = rest - basis[: len(kept)].T @ (basis[: len(kept)] @ rest)
        length = np.linalg.norm(rest)
        if lengths[row] > 1e-12 * typical and length > DEPENDENT and len(kept) < len(basis):
            basis[len(kept)] = rest / length
            kept.append(row)
        elif not of_bodies[row]:
            found.append(Redundancy(row, _repeated(jacobian, row, kept, of_bodies)))
    return np.array(sorted(kept), dtype=np.int64), found


def _repeated(jacobian: Floats, row: int, kept: list[int], of_bodies: Bools) -> tuple[int, ...]:
    """The rows of joints among those kept that take part in making up a row."""
    if not kept:
        return ()
    shares = np.linalg.lstsq(jacobian[kept].T, jacobian[row], rcond=None)[0]
    sizes = np.abs(shares) * np.linalg.norm(jacobian[kept], axis=1)
    taking_part = [(size, other) for size, other in zip(sizes.tolist(), kept, strict=True) if not of_bodies[other]]
    length = float(np.linalg.norm(jacobian[row]))  # shares far below it are rounding
    return tuple(other for size, other in sorted(taking_part, reverse=True) if size > 1e-6 * length)


def described(redundant: Sequence[Redundancy], labels: Sequence[str]) -> str:
    """Redundant rows in words, with what they follow from."""
    words = []
    for item in redundant[:NAMED]:
        others = ", ".join(labels[k] for k in item.repeats[:NAMED])
        words.append(labels[item.row] + (f" (follows from {others})" if others else " (follows from the bodies alone)"))
    more = len(redundant) - NAMED
    return "; ".join(words) + (f" and {more} more" if more > 0 else "")
