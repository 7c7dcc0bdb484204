"""Critical points of equilibrium paths: where the stiffness becomes singular."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from lamella.roles import Floats
from lamella.state import State

Kind = Literal["limit point", "bifurcation"]


@dataclass(frozen=True)
class CriticalPoint:
    """A point of an equilibrium path at which the tangent stiffness is singular: K phi = 0.

    At a limit point the load does work on the null vector phi, and the load factor has a maximum or minimum along the path; at a
    bifurcation phi^T f_load = 0, and other paths branch off.

    Args:
        factor: load factor.
        at: place on the axis of the result: 3.25 lies a quarter of the way from point 3 to point 4 of a path; the load factor or
            time of a solution in steps.
        kind: ``limit point`` or ``bifurcation``.
        negative: negative eigenvalues of the stiffness before and behind the point.
        shape: null vector phi, all coordinates, its largest displacement 1 m, shape (n_q,).
        state: the equilibrium.
    """

    factor: float
    at: float
    kind: Kind
    negative: tuple[int, int]
    shape: Floats
    state: State

    def imperfection(self, amplitude: float) -> Floats:
        """The shape with a largest displacement of ``amplitude`` [m], to be added to the stress-free geometry, shape (n_q,)."""
        return amplitude * self.shape

    def branch(self, amplitude: float) -> Branch:
        """Where a path begins that leaves this point along its shape; the sign of ``amplitude`` [m] chooses the side."""
        return Branch(self, amplitude)

    def __str__(self) -> str:
        before, behind = self.negative
        return (
            f"{self.kind} at load factor {self.factor:.6g}: "
            f"the stiffness has {before} negative eigenvalue{'s' * (before != 1)} before it and {behind} behind it"
        )


@dataclass(frozen=True)
class Branch:
    """The begin of a path that leaves a bifurcation.

    Args:
        point: the critical point.
        amplitude: largest displacement along its shape of the first point on the branch [m]; its sign chooses the side.
    """

    point: CriticalPoint
    amplitude: float
