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
        of = self.equations
        parts = of.model, of.forces, of.loads, of.constraints
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
            return each.following.reaction(self._point, known.u, known.ud, known.udd)
        total = each.parts.reaction(self._point) if each.parts else np.zeros_like(change.q)
        return self._add_along(change, known.lam, total)

    def _add_along(self, change: State, dlam: Floats, total: Floats) -> Floats:
        """Add K dq + D dv + M da + Phi_q^T dlam."""
        point, q = self._point, self._state.q
        for (product, weights), moved in zip(self._tangents, (change.q, change.v), strict=False):
            if not self._looked:
                product.look(point, q, self._state.v, weights)
            total += product(moved)
        self._looked = True
        if not point.at_rest:
            total += self.equations.momentum(change.a)
        self.equations.constraints.add_force(point.t, q, dlam, total)
        return total
