"""The assembly of alpha_q K + alpha_v D + alpha_a M and of Phi_q in the independent coordinates, on a pattern found once."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property, partial
from itertools import pairwise

import numpy as np
from scipy import sparse

from lamella import threads
from lamella._jit import shared
from lamella.assembly.constraints import ConstraintStack
from lamella.assembly.expand import Entries, expand_matrix, expand_rows
from lamella.assembly.forces import ForceSum
from lamella.assembly.operator import ScatterSum, SumOperator
from lamella.assembly.pattern import Pattern
from lamella.assembly.pattern_kernels import numbered
from lamella.assembly.point import Point, Weights
from lamella.assembly.vector_groups import Followed, Listed, Pairs, Placed, Places, Table, groups_of, pairs_of, pairs_of_mass
from lamella.inertia import of_components
from lamella.model import Model
from lamella.roles import ConstraintBlock, Floats, ForceBlock, Ints, Symmetry

Block = ForceBlock | ConstraintBlock
ENTRY = 2e-9
"""Seconds that it takes to sum an entry of a buffer into the matrix."""
RANGES = 8
"""Ranges of a large matrix."""
EVERY = np.ones(1, bool)
"""The one part of a buffer that is always in use."""


class MatrixAssembly:
    """One buffer for the tangents of all blocks, and the operator that sums it into the values of the matrix.

    Args:
        model: the compiled model.
        constraints: its constraints, with the rows that are kept.
        T: map from independent to all coordinates, (n_q, n_u).
        independent: the independent ones among all coordinates, shape (n_u,).
        symmetric: keep the upper triangle only.
        forces: the model's force blocks in other forms.
    """

    def __init__(
        self,
        model: Model,
        constraints: ConstraintStack,
        T: sparse.csr_array,
        independent: Ints,
        symmetric: bool,
        forces: Sequence[ForceBlock] | None = None,
    ) -> None:
        self.model, self.constraints, self._T, self._symmetric = model, constraints, T, symmetric
        blocks = (*(model.forces if forces is None else forces), *model.loads, *model.constraints)
        followed = Followed(T)
        lists, ends = [], [0]
        for block in blocks:
            found, n_k = _listed(block, symmetric, T, followed)
            lists.append(found)
            ends.append(ends[-1] + n_k)
        self.buffer = np.zeros(ends[-1])
        self.parts = [self.buffer[first:end] for first, end in pairwise(ends)]
        vectors = [one.vectors for one in lists if isinstance(one, Table)]
        first, group_of = groups_of(independent, np.concatenate([np.zeros(0, np.int64), *vectors]))
        pairs = [*(one.pairs(group_of) for one in lists), *self._pairs_of_mass(followed, group_of)]
        self._places = places = Places(pairs, first, group_of, symmetric)
        self._values = np.zeros(len(places.indices))
        self._sum_setup(blocks, [one.placed(places) for one in lists], ends)
        n_u = len(independent)
        self.pattern = Pattern(
            n_u, places.indptr, places.indices, symmetric, constraints.n_lam, *self._jacobian_setup(model, T, n_u)
        )

    def _pairs_of_mass(self, followed: Followed, group_of: Ints) -> list[Pairs]:
        """The pairs of groups that inertia couples; its values are not asked for yet."""
        found = []
        for i, j in (block.pairs() for block in self.model.inertias):
            pairs, several = pairs_of_mass(i, j, followed, group_of)
            found.append(pairs)
            if len(several):
                found.append(pairs_of(self._entries_of_mass(i[several], j[several], np.ones(len(several))), group_of))
        return found if self._symmetric else [*found, *((second, first) for first, second in found)]

    def _entries_of_mass(self, i: Ints, j: Ints, m: Floats) -> Entries:
        """Contributions of entries of m to M = m x 1_3; upper ones alone when the matrix is symmetric."""
        symmetry = "symmetric" if self._symmetric else "none"
        return expand_matrix(*of_components(i, j, m), symmetry, self._symmetric, self._T)

    @cached_property
    def mass(self) -> Floats:
        """The values of M alone in the pattern's order; statics does without them."""
        m = self.model.vector_mass.tocoo()
        upper = m.row <= m.col if self._symmetric else slice(None)
        i, j = m.row[upper].astype(np.int64), m.col[upper].astype(np.int64)
        entries = self._entries_of_mass(i, j, m.data[upper].astype(float))
        return np.bincount(self._places.of(entries), entries.factors, minlength=len(self._values)).astype(float)

    def _sum_setup(self, blocks: Sequence[Block], placed: Sequence[Placed], starts: Sequence[int]) -> None:
        """The operators that sum the buffer: of what is symmetric, of pairs, and of each block that may leave out parts."""
        paired = [self._symmetric and _symmetry(block) != "symmetric" for block in blocks]
        self._bounds = _bounds(sum(len(one.slots) for one in placed), len(self._values))
        self.pairs = np.zeros(2 * len(self._values) if any(paired) else 0)
        """A_ij and A_ji of blocks that are nearly symmetric, side by side in the pattern's order; 2 A_ii, 0 on the diagonal."""
        self._sums: list[tuple[ForceBlock | None, Floats, ScatterSum, Floats]] = []
        for pairs, out in ((False, self._values), (True, self.pairs)):
            bounds = [(1 + pairs) * bound for bound in self._bounds]
            whole = []
            for block, one, start, part, own in zip(blocks, placed, starts, self.parts, paired, strict=False):
                if own != pairs:
                    continue
                at, x = one.slots, one.factors
                if pairs:
                    at, x = 2 * at + one.below, np.where(one.on_diagonal, 2.0, 1.0) * x
                if isinstance(block, ForceBlock) and block.k_parts is not None:
                    self._sums.append((block, part, ScatterSum(at, one.sources, x, block.k_parts, bounds), out))
                elif len(at):
                    whole.append((at, one.sources + start if start else one.sources, x))
            if whole:
                at, sources, x = whole[0] if len(whole) == 1 else (np.concatenate(part) for part in zip(*whole, strict=True))
                total = ScatterSum(at, sources, x, np.array([0, len(self.buffer)]), bounds)
                self._sums.append((None, self.buffer, total, out))

    def _jacobian_setup(self, model: Model, T: sparse.csr_array, n_u: int) -> tuple[Ints, Ints]:
        """The operator that sums the buffer of Phi_q; the pattern of Phi_q T in compressed rows."""
        offsets = np.cumsum([0, *(block.n_lam for block in model.constraints)])
        rows = [block.j_rows + start for block, start in zip(model.constraints, offsets, strict=False)]
        ends = np.cumsum([len(r) for r in rows], dtype=np.int64)
        self.j_buffer = np.zeros(int(ends[-1]) if rows else 0)
        self.j_parts = [self.j_buffer[end - len(r) : end] for r, end in zip(rows, ends, strict=True)]
        empty = np.zeros(0, np.int64)
        cols = np.concatenate([empty, *(block.j_cols for block in model.constraints)])
        found = expand_rows(np.concatenate([empty, *rows]), cols, T)
        place = np.full(self.constraints.n_all, -1)
        place[self.constraints.kept] = np.arange(self.constraints.n_lam)
        kept = place[found.rows] >= 0
        entries = Entries(place[found.rows[kept]], found.cols[kept], found.sources[kept], found.factors[kept])
        indptr, indices, slots = numbered(entries.rows, entries.cols, self.constraints.n_lam, n_u)
        self._j_sum = SumOperator(slots, entries.sources, entries.factors, len(indices))
        return indptr, indices

    def values(
        self, forces: ForceSum, loads: ForceSum, point: Point, q: Floats, v: Floats, weights: Weights, previous: Floats
    ) -> tuple[Floats, Floats]:
        """Values of the matrix and of Phi_q in the pattern's order; the force buffers are filled on the way.

        The array of the matrix is overwritten by the next call.

        Args:
            forces, loads: the force buffers.
            point: where the equations are evaluated.
            q, v: its coordinates and velocities.
            weights: how the unknown moves coordinates, velocities and accelerations.
            previous: coordinates of Newton's previous iterate.
        """
        n_forces = len(forces.parts)
        n_blocks = n_forces + len(loads.parts)
        forces.linearise(point.t, q, v, weights, previous, self.parts[:n_forces])
        loads.linearise(point.t, q, v, weights, previous, self.parts[n_forces:n_blocks])
        if point.factor != 1.0:
            for k in self.parts[n_forces:n_blocks]:
                k *= point.factor
        lam = self.constraints.full(point.lam)
        for block, k in zip(self.model.constraints, self.parts[n_blocks:], strict=True):
            block.curvature(point.t, q, lam[block.first : block.first + block.n_lam], k)
            k *= weights.alpha_q
        self.add_up(weights.alpha_a)
        return self._values, self.jacobian(point.t, q)

    def add_up(self, alpha_a: float) -> None:
        """Sum the buffer and alpha_a M into the values of the matrix."""
        mass = self.mass if alpha_a else None
        threads.run([partial(self._add_range, i, mass, alpha_a) for i in range(len(self._bounds) - 1)])

    def _add_range(self, number: int, mass: Floats | None, alpha_a: float) -> None:
        first, end = self._bounds[number : number + 2]
        if mass is None:
            self._values[first:end] = 0.0
        else:
            np.multiply(mass[first:end], alpha_a, out=self._values[first:end])
        self.pairs[2 * first : 2 * end] = 0.0
        for block, x, total, out in self._sums:
            total.add(x, EVERY if block is None else block.k_used, out, number)
        if len(self.pairs):
            _add_means(self.pairs, first, end, self._values)

    def jacobian(self, t: float, q: Floats) -> Floats:
        """Values of Phi_q T in the pattern's order."""
        for block, j in zip(self.model.constraints, self.j_parts, strict=True):
            block.jacobian(t, q, j)
        return self._j_sum(self.j_buffer)


def _bounds(n_entries: int, n_values: int) -> list[int]:
    """Where the ranges of the matrix begin that may be summed side by side, and where the last ends.

    One after another they take less time than the whole as well: what is written stays in the cache.
    """
    pieces = RANGES if ENTRY * n_entries > threads.WORTHWHILE else 1
    return [n_values * i // pieces for i in range(pieces + 1)]


def _symmetry(block: Block) -> Symmetry:
    return block.symmetry if isinstance(block, ForceBlock) else "symmetric"


def _listed(block: Block, symmetric: bool, T: sparse.csr_array, followed: Followed) -> tuple[Table | Listed, int]:
    """Contributions of a block, upper ones alone where block and matrix are symmetric, and the length of its buffer."""
    symmetry, tables = _symmetry(block), block.k_tables if isinstance(block, ForceBlock) else None
    upper = symmetric and symmetry == "symmetric"
    if upper and tables is not None and (table := Table(tables, followed)).suits:
        return table, len(tables.coords) // tables.n * len(tables.rows)
    rows = block.k_rows
    scale = block.k_scale if isinstance(block, ForceBlock) else np.ones(len(rows))
    return Listed(expand_matrix(rows, block.k_cols, scale, symmetry, upper, T)), len(rows)


@shared
def _add_means(pairs: Floats, first: int, end: int, values: Floats) -> None:
    for k in range(first, end):
        values[k] += 0.5 * (pairs[2 * k] + pairs[2 * k + 1])
