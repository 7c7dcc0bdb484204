"""The assembly of alpha_q K + alpha_v D + alpha_a M and of Phi_q in the independent coordinates, on a pattern found once."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
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
        n_u: number of independent coordinates.
        symmetric: keep the upper triangle only.
        forces: the model's force blocks in other forms.
    """

    def __init__(
        self,
        model: Model,
        constraints: ConstraintStack,
        T: sparse.csr_array,
        n_u: int,
        symmetric: bool,
        forces: Sequence[ForceBlock] | None = None,
    ) -> None:
        self.model, self.constraints = model, constraints
        blocks = (*(model.forces if forces is None else forces), *model.loads, *model.constraints)
        entries, ends = [], [0]
        for block in blocks:
            rows = block.k_rows
            entries.append(_entries(block, rows, symmetric, T, ends[-1]))
            ends.append(ends[-1] + len(rows))
        self.buffer = np.zeros(ends[-1])
        self.parts = [self.buffer[first:end] for first, end in pairwise(ends)]
        inertia = _inertia(model.vector_mass, symmetric, T)
        diagonal = np.arange(n_u)  # always stored, so that a pattern has no empty row
        rows = np.concatenate([*(e.rows for e in entries), inertia.rows, diagonal])
        cols = np.concatenate([*(e.cols for e in entries), inertia.cols, diagonal])
        indptr, indices, slots = numbered(
            *((np.minimum(rows, cols), np.maximum(rows, cols)) if symmetric else (rows, cols)), n_u, n_u
        )
        n_entries = sum(len(e.rows) for e in entries)
        self._values = np.zeros(len(indices))
        """The matrix and, below, M alone in the pattern's order."""
        of_mass = slots[n_entries : len(slots) - n_u]
        self.mass = np.bincount(of_mass, inertia.factors, minlength=len(indices)).astype(float)
        self._sum_setup(blocks, entries, slots[:n_entries], symmetric)
        j_indptr, j_indices = self._jacobian_setup(model, T, n_u)
        self.pattern = Pattern(
            n_u,
            indptr,
            indices,
            symmetric,
            constraints.n_lam,
            j_indptr,
            j_indices,
        )

    def _sum_setup(self, blocks: Sequence[Block], entries: Sequence[Entries], slots: Ints, symmetric: bool) -> None:
        """The operators that sum the buffer: of what is symmetric, of pairs, and of each block that may leave out parts."""
        starts = np.cumsum([0, *(len(part) for part in self.parts)])
        ends = np.cumsum([len(e.rows) for e in entries])
        paired = [symmetric and _symmetry(block) != "symmetric" for block in blocks]
        self._bounds = _bounds(sum(len(e.rows) for e in entries), len(self._values))
        self.pairs = np.zeros(2 * len(self._values) if any(paired) else 0)
        """A_ij and A_ji of blocks that are nearly symmetric, side by side in the pattern's order; 2 A_ii, 0 on the diagonal."""
        self._sums: list[tuple[ForceBlock | None, Floats, ScatterSum, Floats]] = []
        for pairs, out in ((False, self._values), (True, self.pairs)):
            bounds = [(1 + pairs) * bound for bound in self._bounds]
            places, sources, factors = [np.zeros(0, np.int64)], [np.zeros(0, np.int64)], [np.zeros(0)]
            for block, e, start, end, part, own in zip(blocks, entries, starts, ends, self.parts, paired, strict=False):
                if own != pairs:
                    continue
                at, x = slots[end - len(e.rows) : end], e.factors
                if pairs:
                    at, x = 2 * at + (e.rows > e.cols), np.where(e.rows == e.cols, 2.0, 1.0) * x
                if isinstance(block, ForceBlock) and block.k_parts is not None:
                    self._sums.append((block, part, ScatterSum(at, e.sources - start, x, block.k_parts, bounds), out))
                else:
                    places.append(at)
                    sources.append(e.sources)
                    factors.append(x)
            if len(places) > 1:
                whole = np.concatenate(places), np.concatenate(sources), np.concatenate(factors)
                self._sums.append((None, self.buffer, ScatterSum(*whole, np.array([0, len(self.buffer)]), bounds), out))

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
        threads.run([partial(self._add_range, i, alpha_a) for i in range(len(self._bounds) - 1)])

    def _add_range(self, number: int, alpha_a: float) -> None:
        first, end = self._bounds[number : number + 2]
        np.multiply(self.mass[first:end], alpha_a, out=self._values[first:end])
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


def _entries(block: Block, rows: Ints, symmetric: bool, T: sparse.csr_array, start: int) -> Entries:
    """Contributions of a block whose buffer begins at ``start``; upper ones alone where block and matrix are symmetric."""
    symmetry = _symmetry(block)
    scale = block.k_scale if isinstance(block, ForceBlock) else np.ones(len(rows))
    found = expand_matrix(rows, block.k_cols, scale, symmetry, symmetric and symmetry == "symmetric", T)
    return Entries(found.rows, found.cols, found.sources + start, found.factors)


def _inertia(mass: sparse.csr_array, symmetric: bool, T: sparse.csr_array) -> Entries:
    """Contributions of the entries of M = m x 1_3, from m; upper ones alone when the matrix is symmetric."""
    entries = mass.tocoo()
    upper = entries.row <= entries.col if symmetric else slice(None)
    i, j = entries.row[upper].astype(np.int64), entries.col[upper].astype(np.int64)
    of_all = of_components(i, j, entries.data[upper].astype(float))
    return expand_matrix(*of_all, "symmetric" if symmetric else "none", symmetric, T)


@shared
def _add_means(pairs: Floats, first: int, end: int, values: Floats) -> None:
    for k in range(first, end):
        values[k] += 0.5 * (pairs[2 * k] + pairs[2 * k + 1])
