"""Derivatives of the reaction of eliminated constraints, from those of the solution."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from lamella.assembly.equations import Equations
from lamella.assembly.point import STATIC, Point, Weights
from lamella.assembly.product import TangentProduct
from lamella.differentiation.neighbours import Neighbours
from lamella.differentiation.solution import PointDerivative
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
        self._looked = False

    @cached_property
    def _tangents(self) -> list[tuple[TangentProduct, Weights]]:
        of, acting = self.equations, self.equations.holding.acting
        parts = acting.forces, acting.loads, of.constraints
        return [(TangentProduct(*parts), weights) for weights in ((STATIC, RATES) if of.depends_on_velocity else (STATIC,))]

    def look(self, point: Point, state: State) -> None:
        """Go to a point."""
        self._point, self._state, self._looked = point, state, False

    def change(self, each: Neighbours, known: PointDerivative, change: State) -> Floats:
        """The derivative, shape (n_q,).

        Args:
            each: the neighbours of the parameter.
            known: the derivative of the point.
            change: how the state follows the unknowns.
        """
        if each.following:
            return each.following.reaction(self._point, self._state, known.u, known.ud, known.udd)
        found = self._along(change, known.lam)
        if each.parts:
            found += each.parts.reaction(self._point, self._state)
        return found

    def _along(self, change: State, dlam: Floats) -> Floats:
        """K dq + D dv + M da + Phi_q^T dlam, shape (n_q,)."""
        point, holding = self._point, self.equations.holding
        total = np.zeros(holding.n_near)
        for (product, weights), moved in zip(self._tangents, ("q", "v"), strict=False):
            if not self._looked:
                product.look(point, holding.near(self._state.q), holding.near(self._state.v), weights)
            total += product(holding.near(getattr(change, moved)))
        self._looked = True
        if not point.at_rest:
            holding.mass.onto(holding.near(change.a), total)
        return holding.with_multipliers(holding.whole(total), point.t, self._state.q, dlam)
