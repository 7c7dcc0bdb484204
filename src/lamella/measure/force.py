"""The block of forces that follow from measures: springs, dampers, stops, latches, elastic cables."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from lamella.measure.kernels import share_out
from lamella.measure.law import Law
from lamella.measure.measure import Measure, MeasureSet
from lamella.roles import Floats, ForceBlock


class MeasureForce(ForceBlock):
    """f = sum_i s_i F(t, m_i, m_i') grad m_i with one law F and shares s_i.

    The tangent is s (F_m grad grad^T + F Hess) for the positions and s F_m' grad grad^T for the velocities. With damping the
    gradient's turning adds F_m' grad (Hess v)^T, which is not symmetric; it is small, and Newton may use its symmetric part.

    Args:
        name: name of the declaration.
        measures: the measures m_i.
        shares: s_i, shape (n,).
        law: F.
    """

    remembered = ("law", "measures")

    def __init__(self, name: str, measures: Sequence[Measure], shares: Floats, law: Law) -> None:
        self.name, self.law, self.shares = name, law, np.asarray(shares, float)
        self.measures = MeasureSet(measures)
        self.depends_on_velocity, self.varies = law.damped, law.varies
        self.symmetry = "nearly" if law.damped else "symmetric"
        self.f_coords, self.f_scale = self.measures.coords, np.ones(len(self.measures.coords))
        rows, cols = self.measures.rows, self.measures.cols
        self._listed = np.arange(len(rows)) if law.damped else np.flatnonzero(rows <= cols)
        self._i, self._j = rows[self._listed], cols[self._listed]
        self.k_rows, self.k_cols = self.f_coords[self._i], self.f_coords[self._j]
        self.k_scale = np.ones(len(self._listed))
        self._owner = self.measures.owner[self._i]

    def force(self, t: float, q: Floats, v: Floats, f: Floats) -> None:
        share_out(self.shares, self.answers(t, q, v), self.measures.owner, self.measures.gradients, f)

    def answers(self, t: float, q: Floats, v: Floats) -> Floats:
        """F of each measure, before it is shared out, shape (n,)."""
        self.measures.evaluate(q)
        return self.law.force(t, self.measures.values, self.measures.rates(v))[0]

    def damping_force(self, t: float, q: Floats, v: Floats, f: Floats) -> None:
        F = self.answers(t, q, v)
        F = F - self.law.force(t, self.measures.values, np.zeros_like(F))[0]
        share_out(self.shares, F, self.measures.owner, self.measures.gradients, f)

    def force_tangent(
        self, t: float, q: Floats, v: Floats, alpha_q: float, alpha_v: float, q_previous: Floats, f: Floats, k: Floats
    ) -> None:
        found = self.measures
        found.evaluate(q, second=True)
        F, F_m, F_rate = (self.shares * part for part in self.law.force(t, found.values, found.rates(v)))
        g = found.gradients
        np.multiply(F[found.owner], g, out=f)
        k[:] = (alpha_q * F_m + alpha_v * F_rate)[self._owner] * g[self._i] * g[self._j]
        k += alpha_q * F[self._owner] * found.hessians[self._listed]
        if self.law.damped:
            k += alpha_q * F_rate[self._owner] * g[self._i] * found.times(v)[self._j]

    def settle(self, t: float, q: Floats) -> None:
        self.measures.evaluate(q)
        self.measures.follow()

    def reset(self) -> None:
        self.law.reset()
        self.measures.reset()

    def energy(self, t: float, q: Floats) -> float:
        self.measures.evaluate(q)
        return float(self.shares @ self.law.energy(t, self.measures.values))

    def dissipation(self, t: float, q: Floats, v: Floats) -> float:
        self.measures.evaluate(q)
        return float(self.shares @ self.law.dissipation(t, self.measures.values, self.measures.rates(v)))
