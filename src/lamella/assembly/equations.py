"""A model's equations in its independent coordinates: residual, matrix and constraints, as the solvers see them."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from scipy import sparse

from lamella.assembly.constraints import ConstraintStack
from lamella.assembly.elimination import eliminate
from lamella.assembly.forces import ForceSum
from lamella.assembly.holding import Holding
from lamella.assembly.independence import Redundancy, described, independent_rows
from lamella.assembly.mass import Mass
from lamella.assembly.matrix import MatrixAssembly
from lamella.assembly.operator import SumOperator, balance
from lamella.assembly.point import Point, Weights
from lamella.assembly.point_state import OF_POINT
from lamella.assembly.product import SkewProduct, matrix_free
from lamella.assembly.recent import Recent
from lamella.assembly.relations import Rows, overlaps_described, relations, repeated_rows, told_apart
from lamella.errors import ConstraintError, ModelError
from lamella.model import Model
from lamella.roles import Floats
from lamella.state import LateState, State

NOTHING = np.zeros(0)


class Equations:
    """r(u) = T^T (M a + f(t, q, v) + Phi_q^T lam), Phi(t, q) with q = T u + G c(t).

    Args:
        model: the compiled model.
        symmetric: store the upper triangle only; by default when every block allows it. Newton then uses the symmetric part of
            a ``nearly`` symmetric block, or what comes near to it; ``symmetric=False`` gives the exact matrix.
        like: the equations of a model that differs by little, whose unknowns are to be those of this one as well: the same
            independent coordinates, and multipliers of the same rows.
    """

    def __init__(self, model: Model, symmetric: bool | None = None, like: Equations | None = None) -> None:
        self.model = model
        self.elimination = eliminate(model.rows, model.n_q, None if like is None else like.elimination)
        self.n_u = len(self.elimination.independent)
        self.magnitude = model.magnitude[self.elimination.independent]
        self.n_motion = int(np.count_nonzero(self.elimination.independent < model.n_motion))
        """Number of independent coordinates of motion, which come first; the others are those of scalar fields."""
        T = self.elimination.T
        known = like if like is not None and T is like.elimination.T else None
        blocks = (*model.forces, *model.loads)
        self.symmetric = all(block.symmetry != "none" for block in blocks) if symmetric is None else symmetric
        free = matrix_free(model.forces, model.loads)
        self.multiplies = free is not None
        """Whether products with the tangents of all forces are cheap beside the matrix."""
        forces, like_forces, like_loads = model.forces, known and known.forces, known and known.loads
        self.forces = ForceSum(free if free and self.symmetric else forces, model.n_q, T, like_forces)
        self.loads = ForceSum(model.loads, model.n_q, T, like_loads)
        self.mass = Mass(model, T, None if known is None else known.mass)
        self.constraints = ConstraintStack(model.constraints)
        self.notes: list[str] = list(model.notes)
        """What the user should know about the equations."""
        self.redundant: list[Redundancy] = []
        """Rows with multipliers that are left out and must be watched."""
        self.depends_on_velocity = any(block.depends_on_velocity for block in blocks)
        self.expand = known.expand if known else SumOperator.of(T)
        self.gather = known.gather if known else self.expand.transposed(self.n_u)
        self.held = self.elimination.particular(self.elimination.constant)
        """Coordinates where all unknowns are zero and supports have not moved."""
        self.holding = Holding(model, self.elimination.held_coordinates, self.forces, self.loads, self.constraints)
        self._at_rest = np.zeros(model.n_q)
        self._moved, self._carried = Recent(), Recent()
        self._row_size = np.zeros(0)
        if like is not None:
            self.constraints.kept, self._row_size = like.constraints.kept, like._row_size
        elif self.constraints.n_all or self.elimination.relations:
            self._keep_independent()

    @cached_property
    def _source(self) -> SumOperator:
        """What motions of supports add to the coordinates."""
        return SumOperator.of(self.elimination.of_motions)

    @property
    def n_lam(self) -> int:
        """Number of multipliers."""
        return self.constraints.n_lam

    @property
    def mobility(self) -> int:
        """Number of independent motions."""
        return self.n_motion - self.n_lam

    @property
    def locked(self) -> bool:
        """Whether nothing can move, nothing is driven and no temperature changes."""
        moves = self.elimination.moves or self.constraints.moves or self.n_u > self.n_motion
        return self.mobility <= 0 and not moves

    def _keep_independent(self) -> None:
        """Leave out rows that repeat others in the initial configuration.

        Raises:
            ConstraintError: rows of joints are redundant, and the model does not say to drop them.
        """
        zero = np.zeros(self.n_u)
        start = Point(0.0, self.model.q0[self.elimination.independent].copy(), zero, zero, np.zeros(0))
        matrix = self.constraints.matrix(0.0, self.coordinates(start))
        self._row_size = np.sqrt(matrix.power(2) @ self.model.magnitude**2)
        jacobian = sparse.csr_array(matrix @ self.elimination.T).toarray() * self.magnitude
        kept, self.redundant = independent_rows(jacobian, self.constraints.of_bodies)
        self.constraints.kept = kept
        if len(kept) == self.constraints.n_all and not self.elimination.relations:
            return
        rows = Rows.of(self.model, self.constraints, self._row_size)
        R = relations(rows, self.elimination, matrix, jacobian, kept)
        redundant, overlaps = told_apart(rows, repeated_rows(rows, R, len(self.elimination.relations)))
        if redundant:
            found = described(redundant, rows.described)
            if self.model.redundant == "raise":
                locked = "; without it the system is locked by its joints, nothing can move" if self.locked else ""
                raise ConstraintError(
                    f"redundant in the initial position: {found}. Use joints that hold less (cylindrical, spherical, point on "
                    f"line) or let the system drop what is redundant; a mechanism in a singular position shows the same{locked}"
                )
            self.notes.append(f"left out as redundant: {found}")
            if any(item.by_bodies for item in redundant):  # linear rows stayed, and rows of bodies went in their place
                gone = np.setdiff1d(np.flatnonzero(self.constraints.of_bodies), kept)
                self.redundant += [Redundancy(int(row), (), by_bodies=True) for row in gone]
        self.notes += overlaps_described(rows, overlaps)

    @cached_property
    def matrix(self) -> MatrixAssembly:
        """The assembly of matrices; made when first needed."""
        forces = [block for block, _ in self.forces.parts]
        T, independent = self.elimination.T, self.elimination.independent
        return MatrixAssembly(self.model, self.constraints, T, independent, self.symmetric, forces)

    def start(self, t: float = 0.0, *, factor: float = 1.0, at_rest: bool = False) -> Point:
        """The reference configuration with the initial velocities (none at rest); supports take precedence over both."""
        chosen = self.elimination.independent
        zero = np.zeros(self.n_u)
        ud = zero.copy() if at_rest else self.model.v0[chosen].copy()
        return Point(t, self.model.q0[chosen].copy(), ud, zero, np.zeros(self.n_lam), factor, at_rest)

    def point_of(self, state: State, t: float) -> Point:
        """The point at time ``t`` with the coordinates, velocities, accelerations and multipliers of a state.

        Raises:
            ModelError: the state is that of another system.
        """
        found, own = (len(state.q), len(state.lam)), (self.model.n_q, self.constraints.n_all)
        if found != own:
            raise ModelError(
                f"a state of {found[0]} coordinates and {found[1]} multipliers; accepted is one of this system, {own}"
            )
        chosen = self.elimination.independent
        lam = state.lam[self.constraints.kept]
        return Point(t, state.q[chosen].copy(), state.v[chosen].copy(), state.a[chosen].copy(), lam)

    def coordinates(self, point: Point) -> Floats:
        """All coordinates q, shape (n_q,)."""
        from_supports = self._moved_at(point.t, point.factor) if self.elimination.moves else self.held
        return self.expand.onto(point.u, from_supports.copy())

    def forget(self) -> None:
        """Evaluate anew what is known for a time: a function of time has been given another course."""
        self._moved.clear()
        self._carried.clear()
        self.forces.forget()
        self.loads.forget()
        self.holding.forget()

    def _moved_at(self, t: float, factor: float) -> Floats:
        """What supports add to the coordinates, shape (n_q,)."""
        return self._moved.get((t, factor), lambda: self.held + self._source(factor * self.elimination.motions(t)))

    def _carried_at(self, t: float) -> Floats:
        """Inertia forces due to the accelerations of supports, shape (n_u,)."""
        return self._carried.get(t, lambda: self.gather(self.mass.in_all(self._source(self.elimination.accelerations(t)))))

    def force_velocities(self, point: Point) -> Floats:
        """Velocities where a force asks for them, else zeros, which cost nothing."""
        return self.velocities(point) if self.depends_on_velocity else self._at_rest

    def velocities(self, point: Point) -> Floats:
        """All velocities, shape (n_q,)."""
        v = self.expand(point.ud)
        return v if not self.elimination.moves or point.at_rest else v + self._source(self.elimination.rates(point.t))

    def accelerations(self, point: Point) -> Floats:
        """All accelerations, shape (n_q,)."""
        a = self.expand(point.udd)
        return a if not self.elimination.moves or point.at_rest else a + self._source(self.elimination.accelerations(point.t))

    def residual(self, point: Point) -> tuple[Floats, Floats]:
        """r (n_u,) and Phi (n_lam,)."""
        q, v = self.coordinates(point), self.force_velocities(point)
        self.forces.evaluate(point.t, q, v)
        self.loads.evaluate(point.t, q, v)
        return self._reduced(point, q)

    def linearise(self, point: Point, weights: Weights, previous: Floats | None = None) -> tuple[Floats, Floats, Floats, Floats]:
        """r, Phi and the values of the matrix alpha_q K + alpha_v D + alpha_a M and of Phi_q T, in the pattern's order.

        Args:
            point: where.
            weights: how the unknown moves q, v and a.
            previous: coordinates q of Newton's previous iterate; see :class:`lamella.roles.ForceBlock`.
        """
        q, v = self.coordinates(point), self.force_velocities(point)
        k, j = self.matrix.values(self.forces, self.loads, point, q, v, weights, q if previous is None else previous)
        r, phi = self._reduced(point, q)
        return r, phi, k, j

    def exact_matrix(self, point: Point, weights: Weights) -> tuple[Floats, Floats]:
        """The values of the two matrices alone, as :meth:`linearise` gives them at ``previous = q``."""
        q = self.coordinates(point)
        return self.matrix.values(self.forces, self.loads, point, q, self.force_velocities(point), weights, q)

    @cached_property
    def is_exact(self) -> bool:
        """Whether :meth:`exact_matrix` is the exact matrix; else it is a symmetric one near it."""
        return not self.symmetric or all(block.symmetry == "symmetric" for block in (*self.model.forces, *self.model.loads))

    @cached_property
    def _skew(self) -> SkewProduct:
        return SkewProduct(self.matrix)

    def skew_part(self) -> SkewProduct:
        """The product with the skew part of what was evaluated last, which a symmetric matrix leaves out; before the next one."""
        self._skew.look()
        return self._skew

    def left_out(self, point: Point, tolerance: float, *, rates: bool = False) -> str:
        """Rows left out as redundant that are violated after all, in words; empty when there is none.

        Args:
            point: where.
            tolerance: relative violation allowed: of positions to the size of the bodies, of velocities to the fastest or 1/s.
            rates: look at velocities as well.
        """
        if not self.redundant:
            return ""
        q = self.coordinates(point)
        violations = {"": self.constraints.phi_of_all(point.t, q) / self._row_size}
        if rates:
            v = self.velocities(point)
            fastest = max(1.0, float(np.max(np.abs(v) / self.model.magnitude)))
            violations[" in velocity"] = self.constraints.rate_of_all(point.t, q, v) / (fastest * self._row_size)
        labels, found = self.constraints.labels, []
        for item in self.redundant:
            others = ", ".join(labels[k] for k in item.repeats) or ("the joints" if item.by_bodies else "the bodies")
            sizes = [(abs(phi[item.row]), kind) for kind, phi in violations.items() if abs(phi[item.row]) > tolerance]
            found += [f"{labels[item.row]} against {others}{kind} (by {size:.2g} of their size)" for size, kind in sizes[:1]]
        return "; ".join(found)

    def same_coordinates(self, other: Equations) -> bool:
        """Whether equal unknowns mean equal coordinates, velocities and accelerations as in other equations."""
        return self.elimination.changes_like(other.elimination) and np.array_equal(self.held, other.held)

    def jacobian(self, point: Point) -> sparse.csr_array:
        """Phi_q T, shape (n_lam, n_u)."""
        return self.matrix.pattern.jacobian(self.matrix.jacobian(point.t, self.coordinates(point)))

    def position_violation(self, point: Point) -> Floats:
        """Phi, shape (n_lam,)."""
        return self.constraints.phi(point.t, self.coordinates(point))

    def velocity_violation(self, point: Point) -> Floats:
        """Phi_q v + Phi_t, shape (n_lam,)."""
        q = self.coordinates(point)
        return self.constraints.times(point.t, q, self.velocities(point)) + self.constraints.phi_t(point.t, q)

    def relative(self, phi: Floats) -> float:
        """Largest value of Phi, each relative to what a change of all coordinates by their magnitudes adds to its row."""
        return float((np.abs(phi) / self._row_size[self.constraints.kept]).max(initial=0.0))

    def violation(self, point: Point) -> float:
        """Largest violation of a constraint, relative to the size of the bodies."""
        return self.relative(self.position_violation(point)) if self.n_lam else 0.0

    def acceleration_rest(self, point: Point) -> Floats:
        """gamma plus Phi_q times the accelerations of moving supports, so that Phi_q T udd = -rest, shape (n_lam,)."""
        q, v = self.coordinates(point), self.velocities(point)
        moving = self._source(self.elimination.accelerations(point.t))
        return self.constraints.gamma(point.t, q, v) + self.constraints.times(point.t, q, moving)

    def momentum(self, v: Floats) -> Floats:
        """M v in all coordinates, shape (n_q,)."""
        return self.mass.in_all(v)

    def inertia_force(self, udd: Floats, onto: Floats | None = None) -> Floats:
        """T^T M T udd, added to ``onto`` if that is given, shape (n_u,)."""
        whole, r = self.mass.in_independent, np.zeros(self.n_u) if onto is None else onto
        return whole.onto(udd, r) if whole else self.gather.onto(self.mass.in_all(self.expand(udd)), r)

    def load_direction(self, point: Point) -> Floats:
        """Derivative of r by the load factor, shape (n_u,): -f_ext, and the stiffness times the supports' motion if they move."""
        if not self.elimination.moves:
            return self.gather(self.loads(point.t, self.coordinates(point), self.velocities(point)))
        # By difference: an exact derivative would need the columns of K that belong to eliminated coordinates.
        step, ahead = 1e-7, point.copy()
        ahead.factor += step
        return (self.residual(ahead)[0] - self.residual(point)[0]) / step

    def describe(self, unknown: int) -> str:
        """An independent coordinate, or a multiplier counted after them, in words."""
        if unknown < self.n_u:
            return self.model.describe(int(self.elimination.independent[unknown]))
        return f"the multiplier of {self.constraints.labels[self.constraints.kept[unknown - self.n_u]]}"

    def free(self, unknown: int) -> str:
        """An unknown that nothing determines, numbered as in :meth:`describe`, in words with what would determine it."""
        what = self.describe(unknown)
        if unknown >= self.n_u:
            return f"{what} is not determined: it repeats other constraints here"
        if unknown >= self.n_motion:
            return f"nothing holds {what}: heat has no way out here; a plate that radiates must start above 0 K"
        return f"nothing holds {what}: a body or mechanism can move freely; add a support"

    def state(self, point: Point) -> State:
        """All coordinates, velocities, accelerations, multipliers and the reaction of the eliminated constraints."""
        late = self.late_state(point)
        return State(point.t, late.q, late.v, late.a, late.lam, late.reaction, point.factor)

    def late_state(self, point: Point) -> LateState:
        """The same of a point that stays as it is while the state is in use; each part is evaluated when it is asked for."""
        return LateState(point.t, point.factor, OF_POINT, (self, point))

    def _reduced(self, point: Point, q: Floats) -> tuple[Floats, Floats]:
        """r and Phi with the forces that the buffers hold now."""
        whole, unreduced = None if point.at_rest else self.mass.in_independent, None
        if whole:
            r = balance(point.factor, self.loads.reduced(), self.forces.reduction, self.forces.buffer, whole, point.udd)
        else:
            r = self.forces.onto(point.factor * self.loads.reduced())
            unreduced = None if point.at_rest else self.mass.in_all(self.expand(point.udd))
        if self.elimination.moves and not point.at_rest:
            r += self._carried_at(point.t)
        if self.n_lam:
            unreduced = np.zeros(self.model.n_q) if unreduced is None else unreduced
            self.constraints.add_force(point.t, q, point.lam, unreduced)
        if unreduced is not None:
            self.gather.onto(unreduced, r)
        return r, self.constraints.phi(point.t, q) if self.n_lam else NOTHING
