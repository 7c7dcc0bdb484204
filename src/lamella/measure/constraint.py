"""The block of constraints on measures: drives, fixed lengths, cables, couplings of angles."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lamella.dofs import Motion
from lamella.measure.kernels import ANGLE
from lamella.measure.measure import Measure, MeasureSet
from lamella.roles import ConstraintBlock, Floats


@dataclass(frozen=True)
class MeasureRow:
    """One constraint m(q) = constant + motion(t).

    Args:
        label: says in words what is held, for messages.
        measure: m.
        constant: right-hand side without motion.
        motion: prescribed motion added to the right-hand side.
        shared: whether the terms are shares of one angle, as along a hinge; each is then taken within pi of the prescribed angle.
    """

    label: str
    measure: Measure
    constant: float = 0.0
    motion: Motion | None = None
    shared: bool = False


class MeasureConstraint(ConstraintBlock):
    """Phi_r = m_r(q) - constant_r - motion_r(t).

    Angles follow the accepted configurations. A measure that is a single angle, or shares of one, is taken within pi of its
    prescribed value instead, which says where it shall be at the start as well.

    Args:
        name: name of the declaration.
        rows: the rows.
    """

    remembered = ("measures",)

    def __init__(self, name: str, rows: Sequence[MeasureRow]) -> None:
        self.name, self.rows, self.n_lam = name, tuple(rows), len(rows)
        self.measures = MeasureSet([row.measure for row in rows])
        self.moves = any(row.motion is not None for row in rows)
        self.breakpoints = tuple(t for row in rows if row.motion is not None for t in row.motion.breakpoints)
        ends = np.cumsum([len(row.measure) for row in rows], dtype=np.int64)
        self._angles = [
            (r, slice(int(end) - len(row.measure), int(end)), sum(term.factor for term in row.measure))
            for r, (row, end) in enumerate(zip(rows, ends, strict=True))
            if (row.shared or len(row.measure) == 1) and all(term.kind == ANGLE for term in row.measure)
        ]
        self.j_rows, self.j_cols = self.measures.owner, self.measures.coords
        self._listed = np.flatnonzero(self.measures.rows <= self.measures.cols)
        i, j = self.measures.rows[self._listed], self.measures.cols[self._listed]
        self.k_rows, self.k_cols = self.j_cols[i], self.j_cols[j]
        self._owner = self.measures.owner[i]

    @property
    def labels(self) -> tuple[str, ...]:
        return tuple(row.label for row in self.rows)

    def prescribed(self, t: float) -> Floats:
        return np.array([row.motion.value(t) if row.motion is not None else 0.0 for row in self.rows])

    def phi(self, t: float, q: Floats, out: Floats) -> None:
        wanted = self.prescribed(t) + [row.constant for row in self.rows]
        self._turn_to(wanted)
        self.measures.evaluate(q)
        np.subtract(self.measures.values, wanted, out=out)

    def jacobian(self, t: float, q: Floats, out: Floats) -> None:
        self.measures.evaluate(q)
        out[:] = self.measures.gradients

    def curvature(self, t: float, q: Floats, lam: Floats, out: Floats) -> None:
        self.measures.evaluate(q, second=True)
        np.multiply(lam[self._owner], self.measures.hessians[self._listed], out=out)

    def phi_t(self, t: float, q: Floats, out: Floats) -> None:
        out[:] = [-row.motion.rate(t) if row.motion is not None else 0.0 for row in self.rows]

    def gamma(self, t: float, q: Floats, v: Floats, out: Floats) -> None:
        self.measures.evaluate(q, second=True)
        bend = self.measures.times(v) * v[self.measures.coords]
        out[:] = np.bincount(self.measures.owner, bend, minlength=self.n_lam)
        out -= [row.motion.acceleration(t) if row.motion is not None else 0.0 for row in self.rows]

    def settle(self, t: float, q: Floats) -> None:
        self.measures.evaluate(q)
        self.measures.follow()

    def reset(self) -> None:
        self.measures.reset()

    def _turn_to(self, wanted: Floats) -> None:
        """Take angles within pi of their prescribed values."""
        for r, terms, factor in self._angles:
            self.measures.centres[terms] = wanted[r] / factor
