"""Parts of the state of a model at a point."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from lamella.assembly.operator import SumOperator
from lamella.assembly.point import Point
from lamella.roles import Floats, Ints
from lamella.state import LateState


def reaction_at(equations: Any, point: Point, state: Any, n: int = 1) -> Floats:
    """M a + f + Phi_q^T lam in all coordinates of a state at a point, or of n states side by side."""
    holding = equations.holding.stack(n)
    v = state.v if equations.depends_on_velocity or holding.knows_states else None
    return holding.reaction(point.t, point.factor, state.q, v, None if point.at_rest else state.a, point.lam)


OF_POINT: dict[str, Callable[[Any], Floats]] = {
    "q": lambda state: state.of[0].coordinates(state.of[1]),
    "v": lambda state: state.of[0].velocities(state.of[1]),
    "a": lambda state: state.of[0].accelerations(state.of[1]),
    "lam": lambda state: state.of[0].constraints.full(state.of[1].lam).copy(),
    "reaction": lambda state: reaction_at(state.of[0], state.of[1], state),
}
"""What makes them in a :class:`~lamella.state.LateState` of the equations and the point."""


class PointStack:
    """States of several points side by side, as far as some vectors tell them; what else there is in them is zero.

    Of derivatives of points the same, without what supports hold.

    Args:
        equations: of the model; supports do not move.
        vectors: numbers of the vectors.
        n: states.
        held: whether what supports hold is added to the coordinates.
    """

    def __init__(self, equations: Any, vectors: Ints, n: int, *, held: bool) -> None:
        self._coords = (3 * np.unique(vectors)[:, None] + np.arange(3)).reshape(-1)
        self._expand = SumOperator.of(equations.elimination.T[self._coords])
        self._held = equations.held[self._coords] if held else 0.0
        self._near = np.zeros((3, n, len(self._coords)))
        self._whole = np.zeros((3, n, equations.model.n_q))
        self._rows = [[*self._near[:, k]] for k in range(n)]

    def put(self, k: int, point: Any) -> None:
        """Take the unknowns of a point, or of its derivative, for state number k, which has none yet."""
        expand, (u, ud, udd) = self._expand, self._rows[k]
        expand.onto(point.u, u)
        expand.onto(point.ud, ud)
        expand.onto(point.udd, udd)

    def fill(self, n: int) -> None:
        """Take the last of n states for all behind it."""
        self._near[:, n:] = self._near[:, n - 1, None]

    def clear(self) -> None:
        """Forget all states."""
        self._near[:] = 0.0

    def state(self, t: float, factor: float, more: Mapping[str, Callable[[Any], Floats]], *of: Any) -> LateState:
        """The states, or their derivatives, with other parts that are made of this stack and of what else is given."""
        return LateState(t, factor, {**_OF_STACK, **more}, (self, *of))

    def whole(self, part: int) -> Floats:
        """Coordinates (0), velocities (1) or accelerations (2) of the vectors in their places, shape (n, n_q); written to again
        for the next states.
        """
        found = self._whole[part]
        found[:, self._coords] = self._near[part] + self._held if part == 0 else self._near[part]
        return found


_OF_STACK: dict[str, Callable[[Any], Floats]] = {
    "q": lambda state: state.of[0].whole(0),
    "v": lambda state: state.of[0].whole(1),
    "a": lambda state: state.of[0].whole(2),
}
