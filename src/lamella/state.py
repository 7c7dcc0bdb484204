"""The changing part of a simulation, as plain arrays."""

from __future__ import annotations

from dataclasses import dataclass

from lamella.roles import Floats


@dataclass(frozen=True)
class State:
    """A state of a model.

    Args:
        t: time [s].
        q: coordinates, shape (n_q,); three to a vector, see :mod:`lamella.roles`.
        v: their velocities, shape (n_q,).
        a: their accelerations, shape (n_q,).
        lam: Lagrange multipliers of the constraints that are not eliminated, shape (n_lam,).
        mu: forces of the eliminated constraints, one for each row kept, shape (n_rows,): the reaction is
            M a + f + Phi_q^T lam = C^T mu.
        factor: load factor in statics, 1 in motion.
    """

    t: float
    q: Floats
    v: Floats
    a: Floats
    lam: Floats
    mu: Floats
    factor: float = 1.0
