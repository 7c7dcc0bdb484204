"""Derivatives of the reaction of eliminated constraints, from those of the solution."""

from __future__ import annotations

import numpy as np

from lamella.assembly.equations import Equations
from lamella.assembly.holding import Holding
from lamella.assembly.point import STATIC, Point, Weights
from lamella.assembly.product import TangentProduct
from lamella.differentiation.neighbours import Neighbours
from lamella.linear.steady import RATES
from lamella.roles import Floats
from lamella.state import State


class Reactions:
    """How the reaction R = M a + f + Phi_q^T lam, in all coordinates, follows parameters at a point.

    Where coordinates may follow the parameter in the parts of the residual, these tell dR. Else it is what they tell of unknowns
    as they are and K dq + D dv + M da + Phi_q^T dlam; where whole residuals are differenced, this alone, and the reactions of the
    neighbours tell the rest.

    Args:
        equations: of the model.
    """

    def __init__(self, equations: Equations) -> None:
        self.equations = equations
        self._tangents: dict[Holding, list[tuple[TangentProduct, Weights]]] = {}
        self._looked = False

    def look(self, point: Point, state: State) -> None:
        """Go to a point, or to several states side by side that have its time and load factor."""
        self._point, self._state, self._looked = point, state, False

    def change(self, each: Neighbours, lam: Floats, change: State) -> Floats:
        """The derivative in all coordinates, in the shape of the coordinates of the state.

        Args:
            each: the neighbours of the parameter.
            lam: the derivative of the multipliers of the rows kept.
            change: how the state follows the unknowns.
        """
        if each.following:
            return each.following.reaction(self._point, self._state, change)
        found = self._along(change, lam)
        if each.parts:
            found += each.parts.reaction(self._point, self._state)
        return found

    def _along(self, change: State, lam: Floats) -> Floats:
        """K dq + D dv + M da + Phi_q^T dlam."""
        point, state = self._point, self._state
        holding = self.equations.holding.stack(len(state.q) if state.q.ndim > 1 else 1)
        assert holding is not None, "asked of stacks only where there are any"
        total = np.zeros(holding.n_near)
        for (product, weights), moved in zip(self._tangents_of(holding), ("q", "v"), strict=False):
            if not self._looked:
                product.look(point, holding.near(state.q), holding.near(state.v), weights)
            total += product(holding.near(getattr(change, moved)))
        self._looked = True
        if not point.at_rest:
            holding.add_product(holding.mass, holding.near(change.a), total)
        return holding.with_multipliers(holding.whole(total), point.t, state.q, lam)

    def _tangents_of(self, holding: Holding) -> list[tuple[TangentProduct, Weights]]:
        if holding not in self._tangents:
            parts = holding.acting.forces, holding.acting.loads, self.equations.constraints
            weights = (STATIC, RATES) if self.equations.depends_on_velocity else (STATIC,)
            self._tangents[holding] = [(TangentProduct(*parts), each) for each in weights]
        return self._tangents[holding]
