"""Each linear system that a motion asks for is solved: constraints are taken out of matrices of all structures, and come back."""

from __future__ import annotations

import pytest
from random_systems import World, ended, random_system
from scipy import sparse

from lamella.roles import Floats
from lamella.solve.linear import AutomaticSolver

LEFT = 1e-9
"""Share of the terms of a row that a solution leaves of it: rounding, magnified by what is eliminated."""
SMALL = 1e-6
"""Share of the largest row below which terms count as this much."""
NOTHING = 1e-20
"""Largest row of a system that lies still."""


class Watched(AutomaticSolver):
    """A solver that remembers the worst row of its solutions."""

    worst, solved = 0.0, 0

    def factorise(self, k: Floats, j: Floats) -> None:
        super().factorise(k, j)
        self.matrix = sparse.csr_array(self.pattern.matrix(k.copy()))
        self.constraints = sparse.csr_array(self.pattern.jacobian(j.copy()))

    def solve(self, r: Floats, s: Floats) -> tuple[Floats, Floats]:
        x, y = super().solve(r, s)
        A, J = self.matrix, self.constraints
        terms = abs(A) @ abs(x) + abs(J.T) @ abs(y) + abs(r)
        of_rows = abs(A @ x + J.T @ y - r) / (terms + SMALL * terms.max() + NOTHING)
        of_constraints = abs(J @ x - s).max(initial=0.0) / ((abs(J) @ abs(x) + abs(s)).max(initial=0.0) + NOTHING)
        Watched.worst = max(Watched.worst, of_rows.max(), of_constraints)
        Watched.solved += 1
        return x, y


@pytest.mark.parametrize("seed", range(60, 100))
def test_solutions_satisfy_the_whole_system(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("lamella.solve.linear.AutomaticSolver", Watched)
    monkeypatch.setattr(Watched, "worst", 0.0)
    monkeypatch.setattr(Watched, "solved", 0)
    ended(random_system(seed, World()), World())
    assert Watched.solved > 20
    assert Watched.worst < LEFT
