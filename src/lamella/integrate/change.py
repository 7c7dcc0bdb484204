"""How large a change of the coordinates is: local errors, and turns that no step should make."""

from __future__ import annotations

import numpy as np

from lamella.assembly.equations import Equations
from lamella.result import Cause
from lamella.roles import Floats
from lamella.solve.newton import NewtonReport

LARGEST_TURN = 1.0
"""Largest change of a slope in one step [rad]. The equations of a long step have further solutions in which elements are folded
over, with slopes changed by 1 to 2; Newton may land on one after many iterations."""


class ChangeSize:
    """Sizes of a change du of the independent coordinates, relative to the magnitudes of the coordinates.

    Args:
        equations: the equations of the model.

    Attributes:
        per_slope: one over the magnitude of each slope, 0 for what is none, shape (n_motion,).
    """

    def __init__(self, equations: Equations) -> None:
        n, independent = equations.n_motion, equations.elimination.independent
        chosen = equations.model.is_position[independent[:n] // 3]
        measured = chosen if chosen.any() else ~chosen  # errors are displacements; slopes would weigh short waves too much
        self._measured = np.flatnonzero(measured)
        self._per_size, self.n = 1.0 / equations.magnitude, n
        self.per_slope = self._per_size[:n] * ~chosen

    def error(self, du: Floats) -> float:
        """Root mean square of the displacements, or that of the scalar fields if it is larger."""
        relative = du * self._per_size
        parts = relative[self._measured], relative[self.n :]
        return max(float(np.sqrt(np.mean(part**2))) if len(part) else 0.0 for part in parts)

    def turn(self, du: Floats) -> float:
        """Largest change of a slope."""
        return float(np.max(np.abs(du[: self.n] * self.per_slope), initial=0.0))


def refuse_folding(report: NewtonReport, turn: float) -> NewtonReport:
    """The report of a step, not converged if a slope turned so far in it that this is another solution."""
    if not report.converged or turn <= LARGEST_TURN:
        return report
    detail = f"the step ended at another solution, in which a slope has changed by {turn:.1f}"
    return NewtonReport(Cause.NOT_CONVERGED, report.iterations, report.size, detail)
