"""The exact matrix at a solution: a matrix near it factorised, and what that lacks by conjugate directions."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property
from math import isnan
from typing import NamedTuple

import numpy as np

from lamella._jit import njit
from lamella.assembly.equations import Equations
from lamella.assembly.point import STATIC, Point, Weights
from lamella.assembly.product import Ahead, TangentProduct
from lamella.differentiation.conjugate_gradients import FINE, ConjugateGradients
from lamella.differentiation.directions import LEAST
from lamella.differentiation.renewal import Renewal
from lamella.differentiation.residuals import ConjugateResiduals
from lamella.errors import ModelError, SingularSystemError
from lamella.roles import Floats
from lamella.solve.base import LinearSolver
from lamella.solve.linear import linear_solver

ENOUGH = 3e-10
"""What a solution may lack, as a share of it, unless another share is given."""
MOST = 24
"""Products of a solution beyond which a new factorisation costs less."""


def _products_for(linear: LinearSolver) -> float:
    """How many products with substitutions take as long as a new matrix and its factorisation: 8 on 6x6 elements, 37 on 24x16,
    where 23 take 4 % of a run more.
    """
    return 0.25 * linear.work_per_entry


class Change(NamedTuple):
    """A change of the equations, which a change x of the unknowns with their multipliers makes up for: A x = -(r, s).

    Args:
        r, s: of the residual and of the constraints.
        guess: what the change of the unknowns may be near to, if known.
        along: whether r and s are those of unknowns that have changed by the guess already, so that A (x - guess) = -(r, s).
        accelerations: change of these that belongs to the guess, where r lacks their inertia.
        energy: x . A x, as far as it is known.
    """

    r: Floats
    s: Floats
    guess: Floats | None = None
    along: bool = False
    accelerations: Floats | None = None
    energy: float = 0.0

    def completed(self, x: Floats, lam: Floats) -> tuple[Floats, Floats]:
        """The change of unknowns and multipliers, where x and lam solve A (x, lam) = -(r, s)."""
        return (x + self.guess if self.along and self.guess is not None else x), lam


class Remainder(NamedTuple):
    """What a solution x of A x = b lacks: b - A x = force - A left, with ``left`` near A^-1 ``force``."""

    force: Floats
    left: Floats


Residual = Callable[[Floats, Floats, Floats, Floats | None], tuple[Floats, Floats]]


class ExactMatrix:
    """The exact matrix A of the equations at a point, by a factorisation of a matrix B near it.

    B is what the equations keep: A itself, a symmetric matrix near it, or that of an earlier point. Where it is not A,

        B^-1 A x = B^-1 b

    is solved by conjugate residuals, or by conjugate gradients. What products tell of A at a point serves all right-hand sides.
    To lay out an unsymmetric A takes as long as hundreds of substitutions: it is factorised only where ``MOST`` products are not
    enough, and from then on.

    Args:
        equations: of the model.
        linear: a solver of the equations' pattern that may be used; one is made when left out.
        enough: see below.

    Attributes:
        enough: what a solution may lack, as a share of it; it is improved once more then and no further.
        remainders: of the solutions of :meth:`solve_each`; None where they are right, or solved by residuals.
        renewed: values of the matrix that was factorised for the present point, in the pattern's order; None where the one that
            the solver held serves.

    Source: S. C. Eisenstat, H. C. Elman, M. H. Schultz, SIAM J. Numer. Anal. 20 (1983) 345-357, algorithm GCR; with B the
    symmetric part of A, P. Concus, G. H. Golub, Lecture Notes in Economics and Math. Systems 134 (1976) 56-65.
    """

    def __init__(self, equations: Equations, linear: LinearSolver | None = None, enough: float = ENOUGH) -> None:
        self.equations, self.enough = equations, enough
        self.linear = linear or linear_solver(equations.matrix.pattern)
        self.renewed: Floats | None = None
        self._unsymmetric: ExactMatrix | None = None
        self._residual: Residual | None = None
        self._renewal, self._spent = Renewal(_products_for(self.linear)), 0
        self._nothing = np.zeros(equations.n_u), np.zeros(equations.n_lam)
        self._by_residuals = ConjugateResiduals(1.0 / equations.magnitude, equations.n_lam, MOST)
        self._by_gradients: ConjugateGradients | None = None
        self._outlasts = equations.multiplies and not equations.n_lam
        self._remainder: Remainder | None = None
        self.remainders: list[Remainder | None] = []

    def factorise(self, point: Point, weights: Weights) -> None:
        """Factorise alpha_q K + alpha_v D + alpha_a M with the constraints at a point.

        What is solved next must be solved before the equations' matrix is evaluated anew.

        Raises:
            ModelError: it is singular, so that the solution is not differentiable.
        """
        self._begin(point, weights)
        self.renewed, j = self.equations.exact_matrix(point, weights)
        try:
            self.linear.factorise(self.renewed, j)
        except SingularSystemError as error:
            what = str(error) if error.index is None else self.equations.free(error.index)
            raise ModelError(f"gradient: the matrix of the solution is singular, so that it has no derivative: {what}") from error
        if self._unsymmetric is not None:
            self._unsymmetric.factorise(point, weights)

    @property
    def direct(self) -> bool:
        """Whether A itself is factorised, so that a guess is of no use."""
        return self._unsymmetric is not None or (self.equations.is_exact and self.renewed is not None)

    def follow(self, point: Point, weights: Weights, iterations: int) -> None:
        """Go to a point with the factorisation that the solver holds of one before, or with a new one where that pays.

        A new one is needed where constraints have multipliers.

        Args:
            point, weights: where.
            iterations: by which the point was reached with the factorisation at hand; they count as products.
        """
        pays = self._renewal.pays(self._spent + iterations, new=self.renewed is not None)
        if self._outlasts and self._unsymmetric is None and not pays:
            self._begin(point, weights)
        else:
            self.factorise(point, weights)

    def ahead(self, point: Point, weights: Weights) -> Ahead | None:
        """Takes the look at a point off the products there, where an evaluation goes through it anyway."""
        return self._tangents.ahead(point, weights) if self.equations.multiplies else None

    def _begin(self, point: Point, weights: Weights) -> None:
        self._at, self._residual, self.renewed = (point, weights), None, None
        self._spent = 0
        self._by_residuals.forget()
        if self._by_gradients is not None:
            self._by_gradients.forget()

    def measure_by_energy(self, wanted: bool) -> bool:
        """Solve by conjugate gradients at the present point, where A is symmetric and B near it, of an earlier point, and where
        all its energies are of motion; else by residuals, in magnitudes. To be said before solutions are asked for; whether that
        is so now.
        """
        of_motion = self.equations.n_u == self.equations.n_motion  # beside heat, what a motion lacks would not be seen
        possible = wanted and of_motion and self._outlasts and self.equations.is_exact
        if not possible:
            self._by_gradients = None
        elif self._by_gradients is None:
            self._by_gradients = ConjugateGradients(1.0 / self.equations.magnitude, MOST)
        return possible

    def solve(self, r: Floats, s: Floats) -> tuple[Floats, Floats]:
        """The change of unknowns and multipliers that a change (r, s) of residual and constraints asks for."""
        return self._solve(Change(r, s))

    def _solve(self, change: Change) -> tuple[Floats, Floats]:
        self._remainder = None
        if self.direct:
            r = self._with_inertia(change)
            found = self._unsymmetric.solve(r, change.s) if self._unsymmetric else self.linear.solve(-r, -change.s)
            return change.completed(*found)
        self._shorten()
        rest = self._beside(change)
        return self._improved(change, self.linear.solve(*rest), rest[0])

    def _shorten(self) -> None:
        """Let a factorisation that serves on be as rough as the method bears."""
        if self.renewed is None:
            self.linear.shorten(singles=self._by_gradients is not None)

    def solve_each(self, changes: Sequence[Change]) -> list[tuple[Floats, Floats]]:
        """The same for several changes, whose first substitutions go together."""
        if self.direct and self._unsymmetric is None:
            self.remainders = [None] * len(changes)
            found = self.linear.solve_each([(-self._with_inertia(change), -change.s) for change in changes])
            return [change.completed(*each) for change, each in zip(changes, found, strict=True)]
        self.remainders = []
        if self._unsymmetric is not None or not self.equations.multiplies or len(changes) == 1:
            return [self._noted(self._solve(each)) for each in changes]
        self._shorten()
        rests = [self._beside(change) for change in changes]
        lefts = self.linear.solve_each(rests)
        renewed, found = self.renewed, []
        for change, left, rest in zip(changes, lefts, rests, strict=True):
            same = self.renewed is renewed and self._unsymmetric is None  # else another matrix had to be factorised on the way
            found.append(self._noted(self._improved(change, left, rest[0]) if same else self._solve(change)))
        return found

    def _beside(self, change: Change) -> tuple[Floats, Floats]:
        """What is left beside the guess of a change, or beside nothing."""
        if change.guess is None or change.along:
            return -change.r, -change.s
        return self._rest(change.r, change.s, _joined(change.guess, self._nothing[1]), change.accelerations)

    def _with_inertia(self, change: Change) -> Floats:
        """r of a change, with the inertia that it lacks, but for that of the guess."""
        if change.accelerations is None or change.guess is None:
            return change.r
        return change.r + self.equations.inertia_force(change.accelerations - self._at[1].alpha_a * change.guess)

    def _noted(self, solution: tuple[Floats, Floats]) -> tuple[Floats, Floats]:
        self.remainders.append(self._remainder)
        return solution

    def _improved(self, change: Change, found: tuple[Floats, Floats], force: Floats) -> tuple[Floats, Floats]:
        """The solution from what is left beside the guess, ``force``, and what a substitution has ``found`` of it."""
        by_energy, learnt, enough = self._by_gradients, 0, max(self.enough, LEAST)
        z, left = None if change.guess is None else _joined(change.guess, self._nothing[1]), _joined(*found)
        if z is not None and not self.equations.multiplies:
            left = left - z
        if by_energy:
            known, lacking = by_energy, by_energy.begin(z, left, force, change.energy)
        else:
            known, lacking = self._by_residuals, self._by_residuals.begin(z, left, force)
        if by_energy and by_energy.known and enough < FINE:
            lacking = by_energy.renew(self._substituted(by_energy.force))
        while not lacking <= enough and learnt < MOST and not isnan(lacking):
            lacking = self._lacking()
            learnt += 1
        if lacking <= enough:
            self._remainder = Remainder(by_energy.force.copy(), by_energy.left.copy()) if by_energy else None
            x, n = known.solution(), len(change.r)
            return x[:n], x[n:]
        if self.renewed is None:
            self.factorise(*self._at)
        else:
            self._unsymmetric = ExactMatrix(exact(self.equations), enough=self.enough)
            self._unsymmetric.factorise(*self._at)
        return self._solve(change)

    def stiffness(self, point: Point) -> Callable[[Floats], Floats]:
        """The product with K at a point; to be used before the equations' matrix is evaluated anew."""
        equations = self.equations
        if equations.multiplies:
            return self.product(point, STATIC)
        K = equations.matrix.pattern.matrix(equations.exact_matrix(point, STATIC)[0].copy())
        if equations.is_exact:
            return lambda x: K @ x
        skew = equations.skew_part()
        return lambda x: K @ x + skew(x)

    @cached_property
    def _tangents(self) -> TangentProduct:
        of = self.equations
        return TangentProduct(of.forces, of.loads, of.constraints, of.elimination.T)

    def product(self, point: Point, weights: Weights) -> Callable[[Floats], Floats]:
        """The product of the exact matrix at a point with changes of the unknowns, to be used before the next is asked for."""
        times, none = self._negative_product(point, weights), self._nothing[0]
        return lambda x: -times(none, x, None)

    def _negative_product(self, point: Point, weights: Weights) -> Callable[[Floats, Floats, Floats | None], Floats]:
        """-(r + A x) for r and x, with accelerations that are not those of x alone if they are given."""
        of, tangents, alpha_a = self.equations, self._tangents, weights.alpha_a
        place = tangents.place_ahead(point) or (of.coordinates(point), of.force_velocities(point))
        tangents.look(point, *place, weights)
        still, mass = self._nothing[0], of.mass.in_independent if alpha_a else None
        if mass is not None and not tangents.lists:
            return lambda r, x, a: tangents.negative_sum(r, of.expand(x), *((alpha_a, mass, x) if a is None else (1.0, mass, a)))

        def times(r: Floats, x: Floats, a: Floats | None) -> Floats:
            forces = tangents.reduced(of.expand(x), of.gather)
            if a is not None:
                return _negative_sum(r, forces, 1.0, of.inertia_force(a))
            return _negative_sum(r, forces, alpha_a, of.inertia_force(x) if alpha_a else still)

        return times

    def _lacking(self) -> float:
        """How much the solution lacks with one direction more: a product and a substitution."""
        if self._by_gradients is not None:
            rest, _ = self._rest(*self._nothing, self._by_gradients.left)
            return self._by_gradients.improve(rest, self._substituted)
        left = self._by_residuals.left
        x = _joined(*self.linear.solve(*self._rest(*self._nothing, left)))
        return self._by_residuals.improve(x if self.equations.multiplies else x - left)

    def _substituted(self, force: Floats) -> Floats:
        """B^-1 ``force``, without multipliers."""
        return self.linear.solve(force, self._nothing[1])[0]

    def _rest(self, r: Floats, s: Floats, z: Floats, accelerations: Floats | None = None) -> tuple[Floats, Floats]:
        """-((r, s) + A z), or -((r, s) + (A - B) z) where the matrix at hand is the symmetric part of A."""
        if self._residual is None:
            self._residual = self._by_products() if self.equations.multiplies else self._by_skew_part()
        self._spent += 1
        return self._residual(r, s, z, accelerations)

    def _by_products(self) -> Residual:
        n, negative = self.equations.n_u, self._negative_product(*self._at)
        if not self.equations.n_lam:
            return lambda r, s, z, a: (negative(r, z, a), s)
        J = self.equations.jacobian(self._at[0])
        return lambda r, s, z, a: (negative(r + J.T @ z[n:], z[:n], a), -(s + J @ z[:n]))

    def _by_skew_part(self) -> Residual:
        n, skew = self.equations.n_u, self.equations.skew_part()
        return lambda r, s, z, _: (-(r + skew(z[:n])), -s)


def exact(equations: Equations) -> Equations:
    """The same equations with their exact matrix: unsymmetric where a block is only nearly symmetric."""
    return equations if equations.is_exact else Equations(equations.model, symmetric=False, like=equations)


def _joined(x: Floats, y: Floats) -> Floats:
    """Unknowns with the multipliers behind them."""
    return np.concatenate([x, y]) if len(y) else x


@njit
def _negative_sum(x: Floats, y: Floats, factor: float, z: Floats) -> Floats:
    """-(x + y + factor z)"""
    total = np.empty_like(x)
    for i in range(len(x)):
        total[i] = -(x[i] + y[i] + factor * z[i])
    return total
