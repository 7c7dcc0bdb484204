"""A steady state, its matrices in all coordinates, and the motions that the constraints allow there."""

from __future__ import annotations

import numpy as np
from scipy import sparse
from scipy.sparse import linalg

from lamella.assembly.equations import Equations
from lamella.assembly.matrix import MatrixAssembly
from lamella.assembly.point import STATIC, Point, Weights
from lamella.errors import ModelError
from lamella.modal import coriolis
from lamella.model import Model
from lamella.roles import Floats
from lamella.solve.constraint_group import groups_of
from lamella.state import State

REST = 1e-6
"""Velocity of a state that counts as rest: this share of the size of the bodies in a second."""
UNBALANCED = 1e-6
"""Unbalanced force of a steady state, as a share of the largest force in it."""
APART = 1e-6
"""Distance of a steady state from the equilibrium that Newton's method sees, as a share of the size of the bodies."""
NO_FORCE = 1e-12
"""Unbalanced force that is rounding where no force acts, as a share of what a change by the bodies' size would need."""
VIOLATED = 1e-6
"""Violation of constraints accepted of a steady state, relative to the size of the bodies."""
ALONG, CHANGED = 1e-3, 1e-6
"""How far along a steady motion the matrices are looked at again, in sizes of the bodies; and by what share they may differ."""

RATES = Weights(alpha_q=0.0, alpha_v=1.0, rate=1.0)


class SteadyState:
    """The linear equations about a steady state, in all coordinates q and in those that the constraints leave free.

        M q'' + D q' + K q + Phi_q^T lam = -F p,      q = E z

    for small changes of everything; z are independent motions, behind them the values of scalar fields.

    Args:
        model: the compiled model.
        state: the state; the reference configuration when None. Its multipliers are computed anew, so it may be that of the same
            bodies with other joints or drives, which held them there without force.

    Attributes:
        K, D, M: matrices in all coordinates, sparse (n_q, n_q); K has the curvature of constraints under their multipliers in it.
        J: Phi_q in all coordinates, sparse (n_lam, n_q).
        E: motions that the constraints allow, sparse (n_q, n_z).
        P: a change of independent coordinates for each constraint, J T P = 1, sparse (n_u, n_lam).
        size: typical size of a change of each z, shape (n_z,).
        n_motion: number of motions in z; the others are values of fields.

    Raises:
        ModelError: the state moves unsteadily, violates constraints or is not in equilibrium; constraints repeat others there.
    """

    def __init__(self, model: Model, state: State | None) -> None:
        model.begin(state)
        self.model, self.equations = model, Equations(model, symmetric=False)
        equations = self.equations
        self.point = point = equations.start(at_rest=True)
        moves = False
        if state is not None:
            if state.q.shape != model.q0.shape:
                raise ModelError(
                    f"linearise: the state has {len(state.q)} coordinates; accepted is one with {model.n_q}, of the same bodies"
                )
            chosen, moves = equations.elimination.independent, _fastest(model, state.v) > REST
            point.t, point.factor, point.at_rest = state.t, state.factor, not moves
            point.u[:] = state.q[chosen]
            if moves:
                point.ud[:] = state.v[chosen]
        self._refuse_violated()
        self._allowed_motions()
        r = equations.residual(point)[0]
        point.lam[:] = -(self.P.T @ r)
        identity = sparse.csr_array(sparse.eye_array(model.n_q))
        self._assembly = MatrixAssembly(model, equations.constraints, identity, np.arange(model.n_q), symmetric=False)
        self.K, self.D, self.J = self._matrices(point)
        self.M = model.mass
        if model.spin is not None:
            self.D = sparse.csr_array(self.D + coriolis(model, np.sqrt(point.factor) * model.spin))
        self._refuse_unbalanced()
        if moves:
            self._refuse_unsteady()
        self.state = equations.state(point)

    @property
    def E_motion(self) -> sparse.csc_array:
        """The columns of E that move, (n_q, n_motion)."""
        return sparse.csc_array(self.E[:, : self.n_motion])

    @property
    def E_field(self) -> sparse.csc_array:
        """The columns of E that are values of fields, (n_q, n_z - n_motion)."""
        return sparse.csc_array(self.E[:, self.n_motion :])

    def _allowed_motions(self) -> None:
        equations, point = self.equations, self.point
        pattern, n = equations.matrix.pattern, equations.n_u
        j = equations.matrix.jacobian(point.t, equations.coordinates(point))
        groups = groups_of(pattern) if equations.n_lam else []
        for group in groups:
            repeated = group.decompose(j, 1.0 / equations.magnitude**2)
            if repeated >= 0:
                label = equations.constraints.labels[equations.constraints.kept[repeated]]
                raise ModelError(
                    f"linearise: {label} repeats other constraints in this state; accepted is a state where none does"
                )
        touched = np.zeros(n, bool)
        for group in groups:
            touched[group.coords] = True
        free = np.flatnonzero(~touched)
        moving, fields = free[free < equations.n_motion], free[free >= equations.n_motion]
        own = [_unit(n, moving), *(_unit(n, group.coords) @ sparse.csr_array(group.N) for group in groups), _unit(n, fields)]
        self._N = sparse.csc_array(sparse.hstack(own))
        self.E = sparse.csc_array(equations.elimination.T @ self._N)
        constrained = np.ones(sum(group.n_motion for group in groups))
        self.size = np.concatenate([equations.magnitude[moving], constrained, equations.magnitude[fields]])
        self.n_motion = len(self.size) - len(fields)
        P = sparse.lil_array((n, equations.n_lam))
        for group in groups:
            P[np.ix_(group.coords, group.rows)] = group.P
        self.P = sparse.csr_array(P)

    def _matrices(self, point: Point) -> tuple[sparse.csr_array, sparse.csr_array, sparse.csr_array]:
        """K, D and Phi_q in all coordinates."""
        equations = self.equations
        q, v = equations.coordinates(point), equations.velocities(point)
        pattern, found = self._assembly.pattern, []
        for weights in (STATIC, RATES):
            k, j = self._assembly.values(equations.forces, equations.loads, point, q, v, weights, q)
            found.append(pattern.matrix(k.copy()))
        return found[0], found[1], pattern.jacobian(j.copy())

    def _refuse_violated(self) -> None:
        violation = self.equations.violation(self.point)
        if violation > VIOLATED:
            raise ModelError(
                f"linearise: the state violates the constraints by {violation:.2g} of the bodies' size; accepted is one that a "
                "statics or motion of the same system ends in, such as equilibrium(system).final"
            )

    def _refuse_unbalanced(self) -> None:
        """Refuse a state in which forces or heat are not balanced, and neither is an equilibrium close by."""
        equations, point = self.equations, self.point
        q, v = equations.coordinates(point), equations.velocities(point)
        T, lam = equations.elimination.T, np.zeros(self.model.n_q)
        equations.constraints.add_force(point.t, q, point.lam, lam)
        terms = [equations.forces(point.t, q, v), point.factor * equations.loads(point.t, q, v), lam]
        r = self._N.T @ equations.residual(point)[0]
        self.unbalanced = r
        K = sparse.csc_array(self.E.T @ self.K @ self.E)
        stiff = np.abs(K.diagonal()) * self.size**2
        for own, what, unit in (
            (slice(None, self.n_motion), "force", "N or N m"),
            (slice(self.n_motion, None), "heat", "W"),
        ):
            coords = equations.elimination.independent < self.model.n_motion
            coords = coords if what == "force" else ~coords
            size = self.size[own]
            if not len(size):
                continue
            acting = max(float(np.abs((T.T @ term)[coords] * equations.magnitude[coords]).max(initial=0.0)) for term in terms)
            unbalanced = np.abs(r[own] * size)
            if unbalanced.max() <= UNBALANCED * acting + NO_FORCE * stiff[own].max():
                continue
            distance = _newton_step(K, r, self.size)
            if distance <= APART:
                continue
            worst = int(np.argmax(unbalanced))
            column = self.E[:, [worst + (own.start or 0)]].tocoo()
            where = self.model.describe(int(column.row[np.argmax(np.abs(column.data))]))
            far = f", the nearest one is some {distance:.2g} of the bodies' size away" if np.isfinite(distance) else ""
            raise ModelError(
                f"linearise: the state is not in equilibrium: a {what} of {np.abs(r[own]).max():.3g} {unit} is unbalanced at "
                f"{where} ({unbalanced.max() / max(acting, 1e-300):.2g} of the largest {what}{far}); accepted is a state such as "
                "equilibrium(system).final, or the end of a motion that has come to rest"
            )

    def _refuse_unsteady(self) -> None:
        """A motion is steady when going on with it changes none of the matrices; exact then, as no term in v * dPhi_q is left."""
        ahead, v = self.point.copy(), self.equations.velocities(self.point)
        fastest = _fastest(self.model, v)
        ahead.u += ALONG / fastest * ahead.ud
        here, there = (self.K, self.D, self.J), self._matrices(ahead)
        for old, new in zip(here, there, strict=True):
            scale = sparse.diags_array(self.model.magnitude)
            old, new = (scale @ m @ scale if m.shape[0] == m.shape[1] else m @ scale for m in (old, new))
            if abs(new - old).max() > CHANGED * max(abs(old).max(), 1e-300):
                raise ModelError(
                    f"linearise: the state moves at {fastest:.3g} of the bodies' size in a second, and its linear equations "
                    "change on the way; accepted is a state at rest, a steady translation, or one in a frame that spins "
                    "(SteadySpin)"
                )


def _fastest(model: Model, v: Floats) -> float:
    """Largest velocity in sizes of the bodies [1/s]."""
    return float(np.abs(v / model.magnitude).max())


def _unit(n: int, columns: np.ndarray) -> sparse.csr_array:
    """The unit vectors of some coordinates as columns, (n, n_columns)."""
    return sparse.csr_array((np.ones(len(columns)), (columns, np.arange(len(columns)))), shape=(n, len(columns)))


def _newton_step(K: sparse.csc_array, r: Floats, size: Floats) -> float:
    """Largest change |K^-1 r| in sizes of the bodies; infinite where the stiffness is singular."""
    scale = sparse.diags_array(size)
    try:
        step = linalg.splu(sparse.csc_matrix(scale @ K @ scale)).solve(size * r)
    except RuntimeError:  # exactly singular
        return np.inf
    found = float(np.abs(step).max())
    return found if np.isfinite(found) else np.inf
