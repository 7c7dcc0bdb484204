"""Linearise a system about a steady state, and give its linear model from inputs to outputs in first-order form."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import sparse

from lamella.accepted import STATE, SYSTEM
from lamella.arguments import NAMED, NAMES, WHOLE, accepts, optional
from lamella.errors import DeclarationError
from lamella.linear.basis import all_motions, lowest_motions
from lamella.linear.inputs import Effect, Inputs, effects
from lamella.linear.outputs import Change, Outputs
from lamella.linear.state_space import StateSpace
from lamella.linear.steady import SteadyState
from lamella.model import Model
from lamella.roles import Floats
from lamella.state import State
from lamella.system import System

LARGEST = 3000
"""States of a model that is given as dense matrices; a Schur decomposition of so many takes minutes."""
IMPROPER = 1e-9
"""Share of an output's largest coefficient below which its dependence on rates of an input is rounding."""
ROUNDING = 1e-15
"""An entry of a reduced matrix below this share of the sum of its terms' sizes is what rounding has left of zero."""


@accepts(
    system=SYSTEM,
    inputs=NAMED,
    outputs=NAMES,
    state=STATE,
)
def linearise(system: System | Model, inputs: Inputs, outputs: Sequence[str], *, state: State | None = None) -> LinearModel:
    """Linearise a system about a steady state.

    Args:
        system: the system; a :class:`System` is compiled first.
        inputs: names of loads, drives and supports, each of which follows a function of time: the input is a change of that
            function. ``spring.preload`` or ``support.z`` names one of several; ``drive.acceleration`` is the second derivative
            of a motion. A mapping gives the inputs names of their own.
        outputs: recorded signals, or components such as ``tip.position.z``.
        state: for example ``equilibrium(...).final``; the reference configuration when left out.

    Raises:
        DeclarationError: an input or output does not exist; those that do are listed.
        ModelError: the state is not steady.
    """
    steady = SteadyState(system.compile() if isinstance(system, System) else system, state)
    return LinearModel(steady, effects(steady, inputs), Outputs(steady, outputs))


@dataclass(frozen=True)
class _Input:
    """What the inputs do, one in each column: derivatives of the force, and changes of q, both (n_q, n_input)."""

    force: Floats
    position: Floats


class LinearModel:
    """M z'' + C z' + K z = B w of the motions z that constraints leave free, with fields of temperature behind them.

    Args:
        steady: the state and its matrices.
        inputs: what each input does.
        outputs: the signals.
    """

    def __init__(self, steady: SteadyState, inputs: Sequence[Effect], outputs: Outputs) -> None:
        self.steady, self._inputs, self._outputs = steady, inputs, outputs
        force = np.stack([effect.force for effect in inputs], axis=1)
        position = np.stack([effect.position for effect in inputs], axis=1)
        self._w = _Input(force, self._without_inertia(position))

    @property
    def basis(self) -> sparse.csc_array:
        """E: changes of all coordinates that the constraints allow, q = E z, sparse (n_q, n_z)."""
        return self.steady.E

    @property
    def M(self) -> sparse.csr_array:
        """E^T M E, sparse (n_z, n_z); zero for fields."""
        return self._reduced(self.steady.M)

    @property
    def C(self) -> sparse.csr_array:
        """E^T D E: damping and gyroscopic terms, and heat capacities of fields, sparse (n_z, n_z)."""
        return self._reduced(self.steady.D)

    @property
    def K(self) -> sparse.csr_array:
        """E^T K E: stiffness with the geometric terms of stresses, loads and constraints, conduction, sparse (n_z, n_z)."""
        return self._reduced(self.steady.K)

    @property
    def n_fields(self) -> int:
        """Number of values of fields among z."""
        return len(self.steady.size) - self.steady.n_motion

    @accepts(modes=optional(WHOLE))
    def state_space(self, modes: int | None = None, *, static_correction: bool = True) -> StateSpace:
        """The model in first-order form, x' = A x + B u, y = C x + D u, for changes from the steady state.

        The states are amplitudes of natural motions with phi^T M phi = 1, then their rates, then values of fields.

        Args:
            modes: number of natural motions from the lowest; all when left out.
            static_correction: with ``modes``, add for each input the static shape that the modes left out would give to it, so
                that the answer to slow inputs is exact (residual flexibility).

        Raises:
            DeclarationError: too many states for dense matrices, or modes of a system with temperatures.
            ModelError: an output depends on the rate of an input.
        """
        n = self.steady.n_motion
        if modes is None:
            states = 2 * n + self.n_fields
            if states > LARGEST:
                raise DeclarationError(
                    "state_space", f"the whole model has {states} states", f"accepted are {LARGEST}; give modes=n to reduce it"
                )
            motions = all_motions(self.steady)
        else:
            self._refuse_fields()
            if not 1 <= modes <= n:
                raise DeclarationError("state_space", f"modes = {modes}", f"accepted is 1 to {n} for this system")
            motions = lowest_motions(self.steady, modes, self._static_loads() if static_correction else None)
        return self._first_order(motions)

    def _refuse_fields(self) -> None:
        if self.n_fields:
            raise DeclarationError(
                "state_space",
                "modes of a system with temperatures leave out most of the deformation that heat gives",
                "accepted is the whole model, which balanced(order) reduces",
            )

    def _reduced(self, matrix: sparse.csr_array) -> sparse.csr_array:
        return sparse.csr_array(self.steady.E.T @ matrix @ self.steady.E)

    def _static_loads(self) -> Floats:
        """Force of each input on z where everything stays as it is, (n_z, n_input)."""
        return -(self.steady.E.T @ (self._w.force + self.steady.K @ self._w.position))

    def _without_inertia(self, position: Floats) -> Floats:
        """Motions of inputs less what makes their inertia, or their heat capacity, act on z: no second derivative is left then.

        E^T M (w - E x) = 0 for motions, and the same with the capacity for fields.
        """
        if not position.any():
            return position
        steady, left = self.steady, position
        for E, matrix in ((steady.E_motion, steady.M), (steady.E_field, steady.D)):
            if E.nnz:
                own = sparse.csc_matrix(E.T @ matrix @ E)
                left = left - E @ sparse.linalg.splu(own).solve(E.T @ (matrix @ left))
        return left

    def _first_order(self, motions: Floats) -> StateSpace:
        """With z_m = amplitudes of ``motions`` (n_q, k), for which E^T M E = 1, and s = z_m' + E^T D w' as second state.

        z_m' = s - D_mw w
        s'   = -D_mm z_m' - K_m z + B w
        z_f' = C_f^-1 (-D_fm z_m' - K_f z + B_f w)
        """
        steady, w = self.steady, self._w
        k, f, m = motions.shape[1], self.n_fields, w.force.shape[1]
        Ef = steady.E_field.toarray()
        D, K = (_projected(matrix, motions) for matrix in (steady.D, steady.K))
        damped = motions.T @ (steady.D @ w.position)
        push = w.force + steady.K @ w.position
        A, B = np.zeros((2 * k + f, 2 * k + f)), np.zeros((2 * k + f, m))
        one, two, heat = slice(0, k), slice(k, 2 * k), slice(2 * k, None)
        A[one, two], B[one] = np.eye(k), -damped
        A[two, one], A[two, two], A[two, heat] = -K, -D, -(motions.T @ (steady.K @ Ef))
        B[two] = D @ damped - motions.T @ push
        if f:
            capacity = Ef.T @ (steady.D @ Ef)
            lag = Ef.T @ (steady.D @ motions)
            rows = np.concatenate([Ef.T @ (steady.K @ motions), lag, Ef.T @ (steady.K @ Ef)], axis=1)
            A[heat], B[heat] = -np.linalg.solve(capacity, rows), -np.linalg.solve(capacity, Ef.T @ push - lag @ damped)
        C, direct, rate, acceleration = self._output_matrices(A, B, motions, Ef, damped)
        return self._assembled(A, B, C, direct, rate, acceleration)

    def _output_matrices(self, A: Floats, B: Floats, motions: Floats, Ef: Floats, damped: Floats) -> tuple[Floats, ...]:
        """Derivatives of the outputs by x, w, w' and w''."""
        steady, w, k, f = self.steady, self._w, motions.shape[1], Ef.shape[1]
        m, equations = w.force.shape[1], steady.equations
        state, none = np.eye(2 * k + f), np.zeros((2 * k + f, m))
        z = np.concatenate([state, none, none, none], axis=1)
        rates = np.concatenate([A, B, none, none], axis=1)
        units = [
            np.concatenate([np.zeros((m, 2 * k + f)), *(np.eye(m) * (n == order) for n in range(3))], 1) for order in range(3)
        ]
        q = motions @ z[:k] + Ef @ z[2 * k :] + w.position @ units[0]
        v = motions @ rates[:k] + Ef @ rates[2 * k :] + w.position @ units[1]
        a = motions @ (rates[k : 2 * k] - damped @ units[1]) + w.position @ units[2]
        total = steady.M @ a + steady.D @ v + steady.K @ q + w.force @ units[0]
        lam = -(steady.P.T @ (equations.elimination.T.T @ total))
        total += steady.J.T @ lam
        full = np.zeros((equations.constraints.n_all, q.shape[1]))
        full[equations.constraints.kept] = lam
        found = self._outputs.derivative(Change(q, v, a, full, total))
        C, direct, rate, acceleration = np.split(found, np.cumsum([2 * k + f, m, m]), axis=1)
        return C, direct + np.stack([self._outputs.direct(e.signals) for e in self._inputs], axis=1), rate, acceleration

    def _assembled(self, A: Floats, B: Floats, C: Floats, D: Floats, rate: Floats, acceleration: Floats) -> StateSpace:
        """With two states more for each input that is an acceleration; an output must not depend on rates of the others."""
        size = np.abs(np.concatenate([C, D], axis=1)).max(axis=1, initial=0.0)
        for j, effect in enumerate(self._inputs):
            if effect.accelerates:
                n = len(A)
                A = np.block([[A, B[:, [j]], np.zeros((n, 1))], [np.zeros((2, n)), np.array([[0.0, 1.0], [0.0, 0.0]])]])
                C = np.concatenate([C, D[:, [j]], rate[:, [j]]], axis=1)
                B = np.concatenate([B, np.zeros((2, B.shape[1]))])
                B[:, j], B[-1, j], D[:, j] = 0.0, 1.0, acceleration[:, j]
                continue
            bad = np.abs(np.stack([rate[:, j], acceleration[:, j]])).max(axis=0) > IMPROPER * size
            if bad.any():
                raise DeclarationError(
                    "linearise",
                    f"the output '{self._outputs.names[int(np.argmax(bad))]}' depends on rates of the input '{effect.name}'",
                    "accepted is the acceleration as input, '<name of the drive or support>.acceleration'",
                )
        names, units = [e.name for e in self._inputs], [e.unit for e in self._inputs]
        levels = np.array([e.level for e in self._inputs])
        out = self._outputs
        return StateSpace(A, B, C, D, tuple(names), tuple(out.names), tuple(units), tuple(out.units), levels, out.values)


def _projected(matrix: sparse.csr_array, V: Floats) -> Floats:
    """V^T matrix V, with zero for what is rounding: the stiffness of a free motion is a sum of large terms that cancel."""
    found, size = V.T @ (matrix @ V), np.abs(V).T @ (abs(matrix) @ np.abs(V))
    return np.where(np.abs(found) > ROUNDING * size, found, 0.0)
