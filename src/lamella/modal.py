"""Natural frequencies and shapes about any state."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from lamella.accepted import STATE, SYSTEM
from lamella.arguments import WHOLE, accepts
from lamella.assembly.equations import Equations
from lamella.assembly.point import STATIC
from lamella.errors import DeclarationError, ModelError
from lamella.model import Model
from lamella.roles import Floats
from lamella.shapes import Shapes
from lamella.solve.eigen import Complexes, gyroscopic, lowest, lowest_of_skew, skew
from lamella.state import State
from lamella.system import System

GROWING = 1e-6
"""Real part of a root beside its size above which the mode grows: roots of a stable system have rounding there."""


@dataclass(frozen=True)
class Modes(Shapes):
    """Natural modes K phi = omega^2 M phi about a state, phi^T M phi = 1. Temperatures stay as they are.

    In a frame that spins the modes are those of (K + i omega G - omega^2 M) phi = 0, seen from that frame, with the Coriolis
    force G; a point moves by shape cos(omega t) - quadrature sin(omega t). So it does in a flutter, to which loads without a
    potential may lead, as those that follow the body: omega^2 is complex, and of the two modes one grows and one decays.

    Args:
        model: the compiled model.
        frequencies: ascending [Hz]; an unstable mode has a negative one, -sqrt(|omega^2|) / 2 pi, shape (n,).
        shapes: columns of all coordinates, shape (n_q, n).
        state: coordinates about which the modes are, shape (n_q,).
        quadrature: the part of the shapes that is a quarter of a period late, shape (n_q, n); None where there is none.
    """

    title = "Natural modes"
    quantity = ("frequency", "Hz", "natural frequency")
    scaling = "phi^T M phi = 1"

    model: Model
    frequencies: Floats
    shapes: Floats
    state: Floats
    quadrature: Floats | None = None

    @property
    def values(self) -> Floats:
        """The frequencies [Hz]."""
        return self.frequencies


@accepts(
    system=SYSTEM,
    n=WHOLE,
    state=STATE,
)
def modes(system: System | Model, n: int, *, state: State | None = None) -> Modes:
    """The ``n`` lowest natural modes; in a frame that spins with the centrifugal and Coriolis forces in it.

    Args:
        system: the system.
        n: number of modes.
        state: about which state, for example ``equilibrium(...).final``; the reference configuration otherwise.

    Raises:
        DeclarationError: n is not positive or exceeds the number of independent coordinates.
        ModelError: the system has multipliers whose constraints are redundant, it spins and no state is given, or it can move in
            one way alone.
    """
    model = system.compile() if isinstance(system, System) else system
    if model.spin is not None and state is None:
        raise ModelError(
            "modes: the reference configuration of a spinning system is no equilibrium; "
            "accepted is state=equilibrium(system).final"
        )
    model.begin(state)
    equations = Equations(model)
    free = equations.mobility
    if free < 2:
        ways = "in one way" if free == 1 else "in no way"
        raise ModelError(
            f"modes: the system can move {ways}; accepted are two or more, and linearise(...).state_space().poles() for one"
        )
    if not 1 <= n <= free - 1:
        raise DeclarationError("modes", f"n = {n}", f"accepted is 1 to {free - 1} for this system")
    point = equations.start(at_rest=True) if state is None else equations.point_of(state, state.t)
    point.at_rest, point.factor = True, 1.0 if state is None else state.factor
    _, _, k, j = equations.linearise(point, STATIC)
    pattern = equations.matrix.pattern
    own = slice(equations.n_motion)
    K, M = (sparse.csc_array(sparse.csr_array(pattern.matrix(x))[own, own]) for x in (k.copy(), equations.matrix.mass))
    J = sparse.csr_array(pattern.jacobian(j.copy())[:, own])
    shapes = np.zeros((equations.n_u, n), complex if model.spin is not None else float)
    if model.spin is None and skew(K, equations.magnitude[own]):
        shapes = shapes.astype(complex)
        frequencies, shapes[own] = _of_skew(K, M, J, n, equations.magnitude[own])
    elif model.spin is None:
        values, shapes[own] = lowest(K, M, J, n, equations.magnitude[own])
        frequencies = np.sign(values) * np.sqrt(np.abs(values)) / (2 * np.pi)
    else:
        T = equations.elimination.T
        G = sparse.csr_array(T.T @ coriolis(model, np.sqrt(point.factor) * model.spin) @ T)
        roots, shapes[own] = gyroscopic(K, sparse.csc_array(G[own, own]), M, J, n, equations.magnitude[own])
        grows = np.abs(roots.real) > GROWING * np.abs(roots)
        frequencies = np.where(grows, -1.0, 1.0) * np.abs(roots) / (2 * np.pi)
    T = equations.elimination.T
    late = T @ np.imag(shapes) if model.spin is not None or np.imag(shapes).any() else None
    return Modes(model, frequencies, T @ np.real(shapes), equations.coordinates(point), late)


def _of_skew(
    K: sparse.csc_array, M: sparse.csc_array, J: sparse.csr_array, n: int, magnitude: Floats
) -> tuple[Floats, Complexes]:
    """Frequencies [Hz], ascending, and shapes where the stiffness is not symmetric.

    Two frequencies that have come together flutter: of omega^2 and its conjugate one root s = i omega grows and one decays.
    """
    values, shapes = lowest_of_skew(K, M, J, n, magnitude)
    flutters = np.abs(values.imag) > 2.0 * GROWING * np.abs(values)
    unstable = np.where(flutters, values.imag < 0.0, values.real < 0.0)  # s has the shape of its own omega^2, and Im s > 0
    frequencies = np.where(unstable, -1.0, 1.0) * np.sqrt(np.abs(values)) / (2 * np.pi)
    shapes = np.where(flutters, shapes, shapes.real)
    order = np.argsort(frequencies)
    return frequencies[order], shapes[:, order]


def coriolis(model: Model, spin: Floats) -> sparse.csr_array:
    """G = 2 M (1 x spin) in all coordinates (n_q, n_q): the force on each coordinate vector is 2 M spin x v."""
    x, y, z = spin
    cross = sparse.csr_array(np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]]))
    turn = sparse.kron(sparse.eye_array(model.n_motion // 3), cross, format="csr")
    n = model.n_motion
    return sparse.csr_array(sparse.block_diag([2.0 * model.mass[:n, :n] @ turn, sparse.csr_array((model.n_q - n,) * 2)]))
