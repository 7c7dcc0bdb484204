"""Parts of the state of a model at a point."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from lamella.assembly.point import Point
from lamella.roles import Floats


def reaction_at(equations: Any, point: Point, q: Floats, v: Floats, a: Floats) -> Floats:
    """M a + f + Phi_q^T lam in all coordinates, shape (n_q,), from those at a point, their velocities and accelerations."""
    return equations.holding.reaction(point.t, point.factor, q, v, None if point.at_rest else a, point.lam)


OF_POINT: dict[str, Callable[[Any], Floats]] = {
    "q": lambda state: state.of[0].coordinates(state.of[1]),
    "v": lambda state: state.of[0].velocities(state.of[1]),
    "a": lambda state: state.of[0].accelerations(state.of[1]),
    "lam": lambda state: state.of[0].constraints.full(state.of[1].lam).copy(),
    "reaction": lambda state: reaction_at(state.of[0], state.of[1], state.q, state.v, state.a),
}
"""What makes them in a :class:`~lamella.state.LateState` of the equations and the point."""
