"""Parts of the state of a model at a point."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from lamella.roles import Floats


def _reaction(state: Any) -> Floats:
    """M a + f + Phi_q^T lam in all coordinates, shape (n_q,)."""
    equations, point = state.of
    found = point.factor * equations.loads(point.t, state.q, state.v)
    found += equations.forces(point.t, state.q, state.v)
    if not point.at_rest:
        equations.mass.in_all.onto(state.a, found)
    equations.constraints.add_force(point.t, state.q, point.lam, found)
    return found


OF_POINT: dict[str, Callable[[Any], Floats]] = {
    "q": lambda state: state.of[0].coordinates(state.of[1]),
    "v": lambda state: state.of[0].velocities(state.of[1]),
    "a": lambda state: state.of[0].accelerations(state.of[1]),
    "lam": lambda state: state.of[0].constraints.full(state.of[1].lam).copy(),
    "reaction": _reaction,
}
"""What makes them in a :class:`~lamella.state.LateState` of the equations and the point."""
