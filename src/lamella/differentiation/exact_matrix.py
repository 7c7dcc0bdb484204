"""The exact matrix at a solution: its symmetric part factorised, its skew part by conjugate residuals."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from lamella._jit import kernel
from lamella.assembly.equations import Equations
from lamella.assembly.point import STATIC, Point, Weights
from lamella.errors import ModelError, SingularSystemError
from lamella.roles import Floats
from lamella.solve.base import LinearSolver
from lamella.solve.linear import linear_solver

ENOUGH = 1e-10
"""What a solution lacks, as a share of it, below which it is improved once more and no further. The differences on the right-hand
side leave as much; 1e-9 already leaves 2e-7 of an output of a motion, 1e-10 some 1e-8."""
MOST = 24
"""Products beyond which a factorisation L U costs less."""


class ExactMatrix:
    """The exact matrix of the equations at a point, factorised.

    Where the equations keep the symmetric part B of A = B + N, it is B that is factorised, and

        (I + B^-1 N) x = B^-1 b

    is solved by the method of generalised conjugate residuals. As N is skew, the eigenvalues lie on a line through 1: a damped
    plate takes three to seven products, be the damping weak or strong. What they tell of the matrix serves all right-hand sides.
    At rest a damper has no N, and one product tells. To lay out A takes as long as hundreds of substitutions: it is factorised
    only where ``MOST`` products are not enough, and from then on.

    Args:
        equations: of the model.
        linear: a solver of the equations' pattern that may be used; one is made when left out.

    Source: S. C. Eisenstat, H. C. Elman, M. H. Schultz, SIAM J. Numer. Anal. 20 (1983) 345-357, algorithm GCR; with B the
    symmetric part, P. Concus, G. H. Golub, Lecture Notes in Economics and Math. Systems 134 (1976) 56-65.
    """

    def __init__(self, equations: Equations, linear: LinearSolver | None = None) -> None:
        self.equations = equations
        self.linear = linear or linear_solver(equations.matrix.pattern)
        self._per_magnitude = 1.0 / equations.magnitude
        self._unsymmetric: ExactMatrix | None = None
        self._rest: Callable[[Floats], Floats] | None = None
        self._known = 0
        self._directions, self._images = np.zeros((2, 0 if equations.is_exact else MOST, equations.n_u + equations.n_lam))

    def factorise(self, point: Point, weights: Weights) -> Floats:
        """Factorise alpha_q K + alpha_v D + alpha_a M with the constraints; the values of the matrix in the pattern's order.

        What is solved next must be solved before the equations' matrix is evaluated anew.

        Raises:
            ModelError: it is singular, so that the solution is not differentiable.
        """
        self._at, self._rest, self._known = (point, weights), None, 0
        k, j = self.equations.exact_matrix(point, weights)
        try:
            self.linear.factorise(k, j)
        except SingularSystemError as error:
            what = str(error) if error.index is None else self.equations.free(error.index)
            raise ModelError(f"gradient: the matrix of the solution is singular, so that it has no derivative: {what}") from error
        if self._unsymmetric is not None:
            self._unsymmetric.factorise(point, weights)
        return k

    def solve(self, r: Floats, s: Floats, guess: Floats | None = None) -> tuple[Floats, Floats]:
        """The change of unknowns and multipliers that a change (r, s) of residual and constraints asks for.

        Args:
            r, s: changes of the residual and of the constraints.
            guess: what the change of the unknowns may be near to, if known.
        """
        if self._unsymmetric is not None:
            return self._unsymmetric.solve(r, s)
        if self.equations.is_exact:
            return self.linear.solve(-r, -s)
        z, rest = np.zeros(len(r) + len(s)), r
        if guess is not None:
            z[: len(r)] = guess
            rest = r + self._product(guess)
        left = np.concatenate(self.linear.solve(-rest, -s)) - z
        done = learnt = 0
        while True:
            lacking = _improve(z, left, done, self._known, self._directions, self._images, self._per_magnitude)
            if lacking <= ENOUGH:
                z += left
                return z[: len(r)], z[len(r) :]
            if learnt == MOST:
                break
            if self._known == MOST:
                self._known = 0
            done = self._known
            change = self.linear.solve(self._product(left[: len(r)]), np.zeros(len(s)))
            _learn(left, *change, done, self._directions, self._images, self._per_magnitude)
            self._known += 1
            learnt += 1
        self._unsymmetric = ExactMatrix(exact(self.equations))
        self._unsymmetric.factorise(*self._at)
        return self._unsymmetric.solve(r, s)

    def stiffness(self, point: Point) -> Callable[[Floats], Floats]:
        """The product with K at a point; to be used before the equations' matrix is evaluated anew."""
        equations = self.equations
        K = equations.matrix.pattern.matrix(equations.exact_matrix(point, STATIC)[0].copy())
        if equations.is_exact:
            return lambda x: K @ x
        rest = equations.rest(point, STATIC)
        return lambda x: K @ x + rest(x)

    def _product(self, x: Floats) -> Floats:
        """R x."""
        if self._rest is None:
            self._rest = self.equations.rest(*self._at)
        return self._rest(x)


def exact(equations: Equations) -> Equations:
    """The same equations with their exact matrix: unsymmetric where a block is only nearly symmetric."""
    return equations if equations.is_exact else Equations(equations.model, symmetric=False, like=equations)


@kernel
def _improve(
    z: Floats, left: Floats, first: int, end: int, directions: Floats, images: Floats, per_magnitude: Floats
) -> float:  # fmt: skip
    """Take the shares of some directions in what is left into z; how large what is left then is, as a share of z."""
    for k in range(first, end):
        share = _scalar_product(images[k], left, per_magnitude)
        for i in range(len(z)):
            z[i] += share * directions[k, i]
            left[i] -= share * images[k, i]
    size = rest = 0.0
    for i in range(len(per_magnitude)):
        size = max(size, abs(z[i]) * per_magnitude[i])
        rest = max(rest, abs(left[i]) * per_magnitude[i])
    return rest / size if size > 0.0 else np.inf if rest > 0.0 else 0.0


@kernel
def _learn(
    left: Floats, x: Floats, y: Floats, k: int, directions: Floats, images: Floats, per_magnitude: Floats
) -> None:  # fmt: skip
    """Keep the direction left with its image left + (x, y), made orthogonal to those of the k before and of length 1."""
    p, image = directions[k], images[k]
    for i in range(len(left)):
        p[i] = left[i]
        image[i] = left[i] + (x[i] if i < len(x) else y[i - len(x)])
    for before in range(k):
        share = _scalar_product(images[before], image, per_magnitude)
        for i in range(len(left)):
            p[i] -= share * directions[before, i]
            image[i] -= share * images[before, i]
    length = np.sqrt(_scalar_product(image, image, per_magnitude))
    for i in range(len(left)):
        p[i] /= length
        image[i] /= length


@kernel
def _scalar_product(x: Floats, y: Floats, per_magnitude: Floats) -> float:
    """Of two lists of unknowns, in their magnitudes; multipliers do not count."""
    total = 0.0
    for i in range(len(per_magnitude)):
        total += x[i] * y[i] * per_magnitude[i] ** 2
    return total
