"""Consistent start: positions and velocities that obey the constraints, and the accelerations and multipliers that follow."""

from __future__ import annotations

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import splu

from lamella.assembly.equations import Equations
from lamella.assembly.point import STATIC, Point, Weights
from lamella.errors import ConstraintError, ModelError, SingularSystemError
from lamella.inertia import whole_mass
from lamella.result import Start
from lamella.roles import Floats
from lamella.solve.base import LinearSolver
from lamella.state import State

MASS_ONLY = Weights(alpha_q=0.0, alpha_v=0.0, alpha_a=1.0, rate=1.0)


ROUNDING = 1e-9
"""Changes of the initial state below this share of the size of the body (and per second, or of the fastest) are rounding."""
CONTRADICTION = 1e-8
"""Violation of a redundant row, as a share of the size of the bodies, beyond which it contradicts the rows it follows from."""

UNDETERMINED = 1e-13
"""Change of a field's equations, as a share of the terms it is summed of, that is rounding."""


def start_of(equations: Equations, t: float, initial: State | None = None) -> Point:
    """The point of a state, the reference configuration when left out, with the velocities nearest to the ones given.

    Velocities of bodies, each given by itself, may disobey joints whose rows T, c are eliminated. Those of the unknowns are then

        min_w |T w + c'(t) - v|_M,      T^T M T dw = T^T M (v - T w - c'(t))

    so that impulses between the bodies, which change no momentum, close the joints, and nothing depends on which are unknowns.
    Supports take precedence: a coordinate that they alone hold changes no other one.
    """
    point = equations.start(t) if initial is None else equations.point_of(initial, t)
    model, T = equations.model, equations.elimination.T
    v = model.v0 if initial is None else initial.v
    gap, of_joints = v - equations.velocities(point), v - equations.expand(point.ud)
    gap[np.diff(T.indptr) == 0] = gap[model.n_motion :] = 0.0
    scale = ROUNDING * np.max(np.abs(v[: model.n_motion]) / model.magnitude[: model.n_motion], initial=1.0) * model.magnitude
    gap[np.minimum(np.abs(gap), np.abs(of_joints)) <= scale] = 0.0
    if gap.any():
        M, n = whole_mass(model.vector_mass, model.n_q), equations.n_motion
        try:
            factor = splu(sparse.csc_array(T.T @ M @ T)[:n, :n])
        except RuntimeError:  # a singular mass matrix, which solve_rates tells of
            return point
        point.ud[:n] += factor.solve((T.T @ (M @ gap))[:n])
    return point


def make_consistent(equations: Equations, point: Point, linear: LinearSolver) -> None:
    """Project ``point`` onto the constraints in the metric of the mass matrix, then solve for accelerations and multipliers.

        M dq + Phi_q^T kappa = 0,  Phi_q dq = -Phi                positions, repeated until Phi vanishes
        M dv + Phi_q^T kappa = 0,  Phi_q dv = -(Phi_q v + Phi_t)  velocities
        M a + Phi_q^T lam = -f,    Phi_q a = -gamma               accelerations

    Raises:
        ConstraintError: the constraints cannot be met from here, or contradict each other.
    """
    project_positions(equations, point, linear, MASS_ONLY)
    solve_rates(equations, point, linear)
    refuse_contradiction(equations, point, rates=True)


def is_consistent(equations: Equations, point: Point) -> bool:
    """Whether :func:`make_consistent` would leave coordinates and velocities as they are."""
    return not equations.n_lam or (
        _holds(equations, equations.position_violation(point)) and not equations.velocity_violation(point).any()
    )


def _holds(equations: Equations, phi: Floats) -> bool:
    return bool(np.abs(phi).max() < 1e-12 * equations.magnitude.max())


def refuse_contradiction(equations: Equations, point: Point, *, rates: bool) -> None:
    """Refuse rows that were left out as redundant and do not follow from the others: their directions agree, not their values.

    Raises:
        ConstraintError: there are such rows; they are named.
    """
    found = equations.left_out(point, CONTRADICTION, rates=rates)
    if found:
        raise ConstraintError(f"contradictory: {found}; remove one of them or let them ask for the same")


def project_positions(equations: Equations, point: Point, linear: LinearSolver, metric: Weights) -> None:
    """Move ``point`` onto the constraints by the smallest change in a metric: the mass matrix, or the stiffness in statics.

    Raises:
        ConstraintError: the constraints cannot be met from here.
        SingularSystemError: the metric is singular on what the constraints leave free.
    """
    if not equations.n_lam:
        return
    for attempt in range(20):
        phi = equations.position_violation(point)
        if _holds(equations, phi):
            return
        try:
            _factorise(equations, point, linear, metric)
        except SingularSystemError as error:
            if attempt == 0:
                raise
            raise _out_of_reach(phi) from error  # what was regular at the start became singular far away from it
        point.u += linear.solve(np.zeros(equations.n_u), -phi)[0]
    raise _out_of_reach(equations.position_violation(point))


def changes(equations: Equations, point: Point, q: Floats, v: Floats) -> Start:
    """How a consistent point differs from the coordinates and velocities that were given, those of supports included."""
    model = equations.model
    size, n = model.vectors(model.magnitude).max(axis=1), model.n_motion
    fastest = max(1.0, float(np.max(np.abs(v[:n]) / model.magnitude[:n])))
    numbers, where = [], []
    for new, old, scale in ((equations.coordinates(point), q, 1.0), (equations.velocities(point), v, fastest)):
        change = model.vectors(new - old)
        if not change.any():
            numbers += [0.0, 0.0]
            where += ["", ""]
            continue
        moved = np.linalg.norm(change, axis=1)
        for chosen in (model.is_position, ~model.is_position):
            sizes = np.where(chosen, moved, 0.0)
            largest = int(np.argmax(sizes))
            numbers.append(float(sizes[largest]))
            told = np.max(sizes / size) > ROUNDING * scale
            where.append(model.describe(3 * largest).removeprefix("x of ") if told else "")
    return Start(*numbers, where=(where[0], where[1], where[2], where[3]), left_out=tuple(equations.notes))


def refuse_undetermined(equations: Equations, point: Point) -> None:
    """Refuse statics of fields that no steady state determines: heat has no way out, or none but to other places of the field.

    The pivot of such a field is rounding, which a factorisation may take for a small number.

    Raises:
        ModelError: a uniform change of a field changes none of its equations.
    """
    independent = equations.elimination.independent
    for field in equations.model.fields:
        own = np.flatnonzero((independent >= field.first) & (independent < field.first + len(field.uniform)))
        if len(own) == len(field.uniform):
            warmer = point.copy()
            warmer.u[own] += field.uniform  # at 0 K nothing radiates
            _, _, k, _ = equations.linearise(warmer, STATIC)
            K = sparse.csr_array(equations.matrix.pattern.matrix(k))[own][:, own]
            if np.all(np.abs(K @ field.uniform) <= UNDETERMINED * (abs(K) @ field.uniform)):
                raise ModelError(
                    f"statics: nothing determines the temperatures of '{field.name}', heat has no way out; add a Film, Radiation "
                    "or a PrescribedTemperature, or let it warm in a motion"
                )


def refuse_locked(equations: Equations) -> None:
    """Refuse a system that has no mobility and that nothing drives.

    Raises:
        ModelError: joints lock it; they are named.
    """
    if not equations.locked:
        return
    own = {"joints", "bodies"}  # blocks of rows from many items
    names = [support.name for support in equations.model.supports]
    names += [block.name for block in equations.model.constraints if block.name not in own]
    raise ModelError(
        f"the system is locked by its joints, nothing can move: {', '.join(names)}; leave something free or drive it"
    )


def _out_of_reach(phi: Floats) -> ConstraintError:
    return ConstraintError(
        f"no position near the initial one satisfies the constraints; they are violated by {np.abs(phi).max():.2g}"
    )


def solve_rates(equations: Equations, point: Point, linear: LinearSolver) -> None:
    """Velocities that obey the constraints, and the accelerations, multipliers and rates of scalar fields that follow."""
    _factorise(equations, point, linear, MASS_ONLY)
    if equations.n_lam:
        point.ud += linear.solve(np.zeros(equations.n_u), -equations.velocity_violation(point))[0]
    point.udd[:] = 0.0
    point.lam[:] = 0.0
    r, _ = equations.residual(point)
    rates, point.lam[:] = linear.solve(-r, -equations.acceleration_rest(point))
    n = equations.n_motion
    point.udd[:n], point.ud[n:] = rates[:n], point.ud[n:] + rates[n:]


def balance(equations: Equations, point: Point) -> tuple[Floats, Floats]:
    """r and gamma at a point: what :func:`with_jump` compares."""
    return equations.residual(point)[0], equations.acceleration_rest(point)


def with_jump(equations: Equations, point: Point, before: tuple[Floats, Floats], linear: LinearSolver) -> Point:
    """The point behind a jump of inputs, of which ``before`` is the balance ahead of it.

        M da + Phi_q^T dlam = -(r+ - r-),   Phi_q da = -(gamma+ - gamma-)

    Only the jump is solved for. A step leaves velocities beside the constraints by its error; accelerations of projected ones, as
    :func:`solve_rates` has them, would hold what stiff damping makes of that error: a blow at each sample, which grows from one
    to the next.
    """
    _factorise(equations, point, linear, MASS_ONLY)
    (r, rest), (r_before, rest_before) = balance(equations, point), before
    rates, lam = linear.solve(r_before - r, rest_before - rest)
    found, n = point.copy(), equations.n_motion
    found.udd[:n] += rates[:n]
    found.ud[n:] += rates[n:]
    found.lam += lam
    return found


def _factorise(equations: Equations, point: Point, linear: LinearSolver, metric: Weights) -> None:
    _, _, k, j = equations.linearise(point, metric)
    try:
        linear.factorise(k, j)
    except SingularSystemError as error:
        if metric is not MASS_ONLY:
            raise
        raise SingularSystemError(f"the mass matrix is singular: {error}", getattr(error, "index", None)) from error
