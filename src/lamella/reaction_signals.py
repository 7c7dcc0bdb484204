"""Signals of supports and joints: force and torque that they exert."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from lamella._jit import njit
from lamella.assembly.equations import Equations
from lamella.assembly.operator import SumOperator
from lamella.constraint.dot_block import DotBlock
from lamella.dofs import Signal, Support
from lamella.kinematics import StackedRows, vectors_of
from lamella.roles import Floats, Ints
from lamella.state import OncePerState, State

AXES = ("x", "y", "z")
STILL = np.zeros(3)


def reaction_signals(support: Support, equations: Equations) -> list[Signal]:
    """Force and torque that a support or joint exerts on its body, or on the body of its side.

    The generalised force R = C^T mu - Phi_q^T lam acts on vectors x_k; a virtual translation gives the force, the sum over
    positions of R_k, and a virtual rotation about the centre c the torque, the sum of (x_k - c) x R_k with c for positions only.
    With P = sum_k (x_k - c) R_k^T the components of the torque are P_yz - P_zy, P_zx - P_xz, P_xy - P_yx.
    """
    model = equations.model
    places = {row: k for k, row in enumerate(equations.elimination.kept)}
    own = np.array([places[row] for row in support.rows if row in places], dtype=np.int64)
    if support.single:
        kind, unit = support.quantity
        forces_of = equations.elimination.forces_of(own)
        return [
            Signal(
                f"{support.name}.{kind}",
                unit,
                (),
                lambda s: float(forces_of(s.reaction).sum()),
                f"generalised {kind} of {support.name}",
                derivative=lambda _, change: float(forces_of(change.reaction).sum()),
            )
        ]
    numbers, held_coords, coefs = equations.elimination.entries_of(own)
    dots = DotBlock(support.name, [model.dots[row] for row in support.dots]) if support.dots else None
    lam = np.array(support.dots, dtype=np.int64)  # the dot rows of joints come first
    vectors = np.unique(np.concatenate([held_coords, np.zeros(0, np.int64) if dots is None else dots.j_cols]) // 3)
    if support.side is not None:
        vectors = np.array([k for k in vectors if model.owners[k] == support.side], dtype=np.int64)
    coords = (3 * vectors[:, None] + np.arange(3)).reshape(-1)
    weights, centre = model.is_position[vectors].astype(float), support.centre
    entries = np.empty(0 if dots is None else len(dots.j_cols))
    place = np.full(model.n_q, len(coords))  # what acts on the other side is left behind
    place[coords] = np.arange(len(coords))
    places = None if dots is None else place[dots.j_cols]
    acting = place[held_coords] < len(coords)
    held = SumOperator(place[held_coords[acting]], numbers[acting], coefs[acting], len(coords))
    forces_of = equations.elimination.forces_of(own)

    told_by = np.append(vectors, centre.vectors) if dots is None and equations.elimination.alone else None

    def held_forces(state: State) -> Floats:
        mu = forces_of(state.reaction)
        return held(mu) if mu.ndim == 1 else held.onto_each(mu, np.zeros((len(mu), held.n)))

    forces, changes = OncePerState(held_forces), OncePerState(held_forces)

    def resultants(q: Floats, f: Floats, constant: Floats) -> Floats:
        found = np.empty((*f.shape[:-1], 6))
        rows = (q, f, found) if f.ndim > 1 else (q[None], f[None], found[None])
        _resultants(*rows, vectors, weights, centre.vectors, centre.weights, constant)
        return found

    def evaluate(state: State) -> Floats:
        f = forces(state)
        if dots is not None and places is not None:
            dots.jacobian(state.t, state.q, entries)
            f = f - np.bincount(places, entries * state.lam[lam][dots.j_rows], minlength=len(coords) + 1)[:-1]
        return resultants(state.q, f, centre.constant)

    shared = OncePerState(evaluate)

    def force(state: State) -> Floats:
        return shared(state)[..., :3]

    def torque(state: State) -> Floats:
        return shared(state)[..., 3:]

    def force_change(state: State, change: State) -> Floats:
        return resultants(state.q, changes(change), centre.constant)[..., :3]

    def torque_change(state: State, change: State) -> Floats:
        of_forces = resultants(state.q, changes(change), centre.constant)
        return (of_forces + resultants(change.q, forces(state), STILL))[..., 3:]

    on = f" on {support.side}" if support.side else ""
    signals = [
        Signal(
            f"{support.name}.{name}",
            unit,
            AXES,
            value,
            f"{what}{on}",
            derivative=change if dots is None else None,
            polynomial=True,
            of_vectors=told_by,
        )
        for name, unit, value, change, what in (
            ("force", "N", force, force_change, f"force of {support.name}"),
            ("torque", "N m", torque, torque_change, f"torque of {support.name} about its centre"),
        )
    ]
    frame = support.frame
    if frame is None:
        return signals

    axes = StackedRows(frame.axes)
    into_frame = OncePerState(lambda state: axes.at(vectors_of(state.q)))  # R_WF^T, whose rows are the axes

    def local(evaluate: Callable[[State], Floats]) -> Callable[[State], Floats]:
        return lambda state: into_frame(state).dot(evaluate(state))

    where = "in the joint frame of a"
    return [
        *signals,
        Signal(f"{support.name}.force_local", "N", AXES, local(force), f"force of {support.name}{on} {where}", polynomial=True),
        Signal(
            f"{support.name}.torque_local", "N m", AXES, local(torque), f"torque of {support.name}{on} {where}", polynomial=True
        ),
    ]


@njit
def _resultants(
    q: Floats,
    f: Floats,
    out: Floats,
    vectors: Ints,
    weights: Floats,
    centre_vectors: Ints,
    centre_weights: Floats,
    constant: Floats,
) -> None:
    """Force and torque, out (n, 6), of forces f (n, 3 m) on vectors x_k of coordinates q (n, n_q).

    They are sum w_k f_k and sum (x_k - w_k c) x f_k. The weight w_k is 1 for positions, else 0; the centre c is a sum of vectors
    with weights, and a constant.
    """
    for state in range(len(f)):
        c0, c1, c2 = constant[0], constant[1], constant[2]
        for i in range(len(centre_vectors)):
            k, w = 3 * centre_vectors[i], centre_weights[i]
            c0, c1, c2 = c0 + w * q[state, k], c1 + w * q[state, k + 1], c2 + w * q[state, k + 2]
        own = out[state]
        own[:] = 0.0
        for i in range(len(vectors)):
            k, w = 3 * vectors[i], weights[i]
            x0, x1, x2 = q[state, k] - w * c0, q[state, k + 1] - w * c1, q[state, k + 2] - w * c2
            f0, f1, f2 = f[state, 3 * i], f[state, 3 * i + 1], f[state, 3 * i + 2]
            own[0] += w * f0
            own[1] += w * f1
            own[2] += w * f2
            own[3] += x1 * f2 - x2 * f1
            own[4] += x2 * f0 - x0 * f2
            own[5] += x0 * f1 - x1 * f0
