"""Linear buckling: at which load factors the stiffness of the linear prebuckling state becomes singular."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import sparse
from scipy.sparse import linalg

from lamella.accepted import STATE, SYSTEM
from lamella.arguments import REAL, WHOLE, accepts
from lamella.assembly.equations import Equations
from lamella.assembly.point import STATIC, Point
from lamella.errors import ConvergenceError, DeclarationError, ModelError, SingularSystemError
from lamella.model import Model
from lamella.result import Statistics
from lamella.roles import Floats
from lamella.shapes import Shapes
from lamella.solve.base import LinearSolver
from lamella.solve.linear import linear_solver
from lamella.solve.newton import Newton, NewtonSolver
from lamella.state import State
from lamella.system import System

STEP = 1e-4
"""Largest change of a coordinate, as a share of its magnitude, over which the stiffness is differenced: its rounding of 1e-16
becomes 1e-12 of the change, and what is not quadratic in it 1e-8."""
ROUNDING = 1e-13
"""Change of the stiffness beside its largest entry that is rounding."""
NEGLIGIBLE = 1e-9
"""Reciprocal load factors below this share of the largest are rounding: that load does not buckle this shape."""


@dataclass(frozen=True)
class Buckling(Shapes):
    """Buckling shapes (K0 + d K_sigma) phi = 0 with d = factor - factor of the state, phi scaled to phi^T K0 phi = 1.

    Args:
        model: the compiled model.
        factors: load factors, first those above the state's own, ascending, then those below it, descending: negative ones
            belong to the reversed load, shape (n,).
        shapes: columns of all coordinates, shape (n_q, n).
        state: coordinates of the equilibrium they start from, shape (n_q,).
    """

    title = "Buckling shapes"
    quantity = ("load_factor", "1", "load factor; negative for the reversed load")
    scaling = "phi^T K phi = 1"

    model: Model
    factors: Floats
    shapes: Floats
    state: Floats

    @property
    def values(self) -> Floats:
        """The load factors."""
        return self.factors


@accepts(
    system=SYSTEM,
    n=WHOLE,
    t=REAL,
    state=STATE,
)
def buckling(system: System | Model, n: int = 1, *, t: float = 0.0, state: State | None = None) -> Buckling:
    """Linear buckling: load factors at which the stiffness becomes singular when the prebuckling state grows linearly.

    The equilibrium r(u, factor) = 0 has the tangent du/dfactor = -K0^-1 dr/dfactor, and along it the exact stiffness changes by

        K_sigma = dK(u0 + s du, factor0 + s) / ds,      (K0 + d K_sigma) phi = 0,

    by central differences of exact stiffnesses: membrane stress enters K quadratically in u, and is then differenced exactly.
    K_sigma holds the stiffness of loads that follow the surface, and the curvature of constraints.

    Args:
        system: what is loaded.
        n: number of shapes: those whose load factors are nearest, and always the nearest one under a growing load.
        t: time at which loads and motions are taken [s], without a state.
        state: an equilibrium to start from, such as ``equilibrium(...).final``; the unloaded one otherwise.

    Returns:
        Load factors and shapes. Where loads have no potential, only buckling without oscillation is found (divergence).

    Raises:
        DeclarationError: n is not positive or exceeds the number of independent coordinates.
        ModelError: nothing holds the system, or no load changes its stiffness.
        ConvergenceError: there is no equilibrium without load.
    """
    model = system.compile() if isinstance(system, System) else system
    model.begin(state)
    exact = all(block.symmetry == "symmetric" for block in (*model.forces, *model.loads))
    equations = Equations(model, symmetric=exact)
    free = equations.mobility
    if free < 3:
        raise ModelError(f"buckling: the system has {free} degrees of freedom; accepted are three or more")
    if not 1 <= n <= free - 2:
        raise DeclarationError("buckling", f"n = {n}", f"accepted is 1 to {free - 2} for this system")
    linear = linear_solver(equations.matrix.pattern)
    point = _equilibrium(equations, linear, t, state)
    ahead, behind, span = _along(equations, linear, point)
    pattern = equations.matrix.pattern
    change = _stiffness(equations, ahead)[0] - _stiffness(equations, behind)[0]
    K_sigma = pattern.matrix(change / span)
    k, j = _stiffness(equations, point)
    if np.abs(change).max() <= ROUNDING * np.abs(k).max():
        raise ModelError("buckling: no load changes the stiffness; add loads that stress the structure, with strain 'exact'")
    linear.factorise(k, j)
    K0 = sparse.csr_array(pattern.matrix(k))
    found, vectors = _reciprocals(K0, sparse.csr_array(K_sigma), linear, n)
    above = np.flatnonzero(found > 0)
    below = np.flatnonzero(found < 0)
    order = np.concatenate([above[np.argsort(-found[above])], below[np.argsort(found[below])]])
    shapes = vectors[:, order]
    shapes = shapes / np.sqrt(np.abs(np.sum(shapes * (K0 @ shapes), axis=0)))
    factors = point.factor + 1.0 / found[order]
    return Buckling(model, factors, equations.elimination.T @ shapes, equations.coordinates(point))


def _equilibrium(equations: Equations, linear: LinearSolver, t: float, state: State | None) -> Point:
    """The given equilibrium, or that without load."""
    model = equations.model
    if state is not None:
        point = equations.point_of(state, state.t)
        point.at_rest, point.factor = True, state.factor
        return point
    if not model.rows and not model.constraints:
        raise ModelError(
            "buckling: nothing holds the system; add at least one support, for example Clamp(name, plate.edge('x-'))"
        )
    point = equations.start(t, factor=0.0, at_rest=True)
    report = NewtonSolver(equations, linear, Newton(keep=0.0), Statistics()).solve(point, STATIC)
    if not report.converged:
        raise ConvergenceError(f"buckling: there is no equilibrium without load: {report.detail}")
    return point


def _along(equations: Equations, linear: LinearSolver, point: Point) -> tuple[Point, Point, float]:
    """Points ahead and behind on the tangent of the equilibrium path, and the difference of their load factors."""
    try:
        linear.factorise(*_stiffness(equations, point))
    except SingularSystemError as error:
        raise ModelError(f"buckling: {equations.free(error.index) if error.index is not None else error}") from error
    du, dlam = linear.solve(-equations.load_direction(point), np.zeros(equations.n_lam))
    size = float(np.abs(du / equations.magnitude).max())
    if size == 0.0:
        raise ModelError("buckling: the loads deform nothing; add loads that stress the structure")
    points = []
    for step in (STEP / size, -STEP / size):
        moved = point.copy()
        moved.u, moved.lam, moved.factor = point.u + step * du, point.lam + step * dlam, point.factor + step
        points.append(moved)
    return points[0], points[1], 2.0 * STEP / size


def _stiffness(equations: Equations, point: Point) -> tuple[Floats, Floats]:
    _, _, k, j = equations.linearise(point, STATIC)
    return k.copy(), j.copy()


def _reciprocals(K0: sparse.csr_array, K_sigma: sparse.csr_array, linear: LinearSolver, n: int) -> tuple[Floats, Floats]:
    """The largest eigenvalues of -K_sigma phi = (1 / d) K0 phi by size, the largest positive one among them; with shapes."""
    n_u, none = len(K0.indptr) - 1, np.zeros(linear.pattern.n_lam)

    def inverse(x: Floats) -> Floats:
        return linear.solve(np.ravel(x), none)[0]

    start = inverse(K0 @ np.random.default_rng(0).standard_normal(n_u))
    stable = linear.pattern.symmetric and linear.negative_pivots == 0

    def largest(which: str, count: int) -> tuple[Floats, Floats]:
        if stable:
            Minv: Any = linalg.LinearOperator((n_u, n_u), matvec=inverse, dtype=float)  # pyright: ignore[reportCallIssue]
            values, vectors = linalg.eigsh(-K_sigma, count, K0, Minv=Minv, which=which, v0=start)
            return np.asarray(values), np.asarray(vectors)
        product: Any = linalg.LinearOperator((n_u, n_u), matvec=lambda x: -inverse(K_sigma @ np.ravel(x)), dtype=float)  # pyright: ignore[reportCallIssue]
        solution: Any = linalg.eigs(product, count, which={"LA": "LR"}.get(which, which), v0=start)
        values, vectors = np.asarray(solution[0], complex), np.asarray(solution[1], complex)
        real = np.abs(np.imag(values)) < 1e-8 * np.abs(values).max()
        return np.real(values[real]), np.real(vectors[:, real])

    values, vectors = largest("LM", n)
    size = np.abs(values).max(initial=0.0)
    if not (values > NEGLIGIBLE * size).any():
        try:
            more = largest("LA", 1)
            if more[0].size and more[0][0] > NEGLIGIBLE * size:  # in the place of the one that is farthest
                kept = np.argsort(-np.abs(values))[: n - 1]
                values, vectors = np.append(values[kept], more[0]), np.column_stack([vectors[:, kept], more[1]])
        except linalg.ArpackNoConvergence:
            pass  # the positive end is a cluster at zero: no growing load buckles it
    used = np.abs(values) > NEGLIGIBLE * size
    return values[used], vectors[:, used]
