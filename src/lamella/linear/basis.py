"""Motions in which a linear model is written: all natural ones, or the lowest with static shapes for the inputs."""

from __future__ import annotations

import numpy as np
from scipy import linalg, sparse

from lamella.errors import ModelError
from lamella.linear.steady import SteadyState
from lamella.roles import Floats
from lamella.solve.eigen import RIGID_MODES, lowest

RIGID = 1e-9
"""Eigenvalue, as a share of the largest of the modes computed, below which a mode counts as rigid."""
SHIFT = 1e-2
"""Shift of the stiffness of a body that can move freely, as a share of the largest eigenvalue kept."""
ITERATIONS, SETTLED = 50, 1e-13
DEPENDENT = 1e-8
"""Share of a static shape left after the others are taken out of it, below which it adds nothing."""


def all_motions(steady: SteadyState) -> Floats:
    """All natural motions, ascending, with phi^T M phi = 1, columns of all coordinates, shape (n_q, n_motion).

    Raises:
        ModelError: some motion has no mass.
    """
    K, M = _matrices(steady)
    scale = steady.size[: steady.n_motion]
    try:
        _, vectors = linalg.eigh(_scaled(K, scale).toarray(), _scaled(M, scale).toarray())
    except linalg.LinAlgError as error:
        raise ModelError("linearise: some motion has no mass; the mass matrix is not positive definite") from error
    return steady.E_motion @ (scale[:, None] * vectors)


def lowest_motions(steady: SteadyState, n: int, loads: Floats | None) -> Floats:
    """The ``n`` lowest natural motions, and static shapes for loads on z, (n_z, m); shape (n_q, n + static shapes).

    The static shape of a load b is psi = K^-1 b, less its part in the modes. With rigid-body modes K is singular: then

        K psi = b - M Phi Phi^T b

    of the load that the modes do not carry, solved with K + s M and repeated with what is left, which the orthogonality of psi
    to all rigid modes makes converge. The shapes are made orthonormal and turned to natural motions of the whole basis.

    Source: R. R. Craig, Int. J. Anal. Exp. Modal Anal. 2 (1987) 59-72 (attachment modes, inertia relief).
    """
    size, (K, M) = steady.n_motion, _matrices(steady)
    if n + RIGID_MODES >= size:  # so few coordinates that all motions cost less
        return all_motions(steady)[:, : n if loads is None else None]
    none = sparse.csr_array((0, size))
    values, shapes = lowest(K, M, none, n + RIGID_MODES, steady.size[:size])
    largest, shapes = float(np.abs(values).max()), shapes[:, :n]
    if loads is None or not loads[:size].any():
        return steady.E_motion @ shapes
    own = sparse.csc_array(steady.E_motion.T @ steady.K @ steady.E_motion)
    if np.abs(values).min() > RIGID * largest:
        psi = _solver(own)(loads[:size])
    else:
        psi = _relieved(own, M, shapes, loads[:size], SHIFT * largest)
    for _ in range(2):  # the second time takes out what rounding has left
        psi = psi - shapes @ (shapes.T @ (M @ psi))
    psi = _independent(psi, M, np.sqrt(np.abs(loads[:size].T @ psi).max(axis=1)))
    basis = np.concatenate([shapes, psi], axis=1)
    _, turn = linalg.eigh(basis.T @ (K @ basis), basis.T @ (M @ basis))
    return steady.E_motion @ (basis @ turn)


def _relieved(K: sparse.csc_array, M: sparse.csc_array, shapes: Floats, loads: Floats, shift: float) -> Floats:
    """K psi = b - M Phi Phi^T b with a singular K."""
    solve = _solver(sparse.csc_array(K + shift * M))
    rest = loads - M @ (shapes @ (shapes.T @ loads))
    psi = np.zeros_like(rest)
    for _ in range(ITERATIONS):
        step = solve(rest - K @ psi)
        step -= shapes @ (shapes.T @ (M @ step))
        psi += step
        if np.abs(step).max() <= SETTLED * np.abs(psi).max():
            break
    return psi


def _solver(matrix: sparse.csc_array) -> sparse.linalg.SuperLU:
    try:
        return sparse.linalg.splu(sparse.csc_matrix(matrix)).solve
    except RuntimeError as error:
        raise ModelError("linearise: the stiffness is singular; accepted is a state that is not at a critical point") from error


def _independent(psi: Floats, M: sparse.csc_array, size: Floats) -> Floats:
    """Orthonormal shapes, without those that follow from others or that their load hardly moves."""
    norms = np.sqrt(np.sum(psi * (M @ psi), axis=0))
    psi = psi[:, (norms > 0.0) & (size > 0.0)] / norms[(norms > 0.0) & (size > 0.0)]
    values, vectors = linalg.eigh(psi.T @ (M @ psi)) if psi.shape[1] else (np.zeros(0), np.zeros((0, 0)))
    kept = values > DEPENDENT
    return psi @ (vectors[:, kept] / np.sqrt(values[kept]))


def _matrices(steady: SteadyState) -> tuple[sparse.csc_array, sparse.csc_array]:
    """The symmetric part of the stiffness, and the mass, of the motions."""
    E = steady.E_motion
    K, M = (sparse.csc_array(E.T @ matrix @ E) for matrix in (steady.K, steady.M))
    return sparse.csc_array(0.5 * (K + K.T)), sparse.csc_array(0.5 * (M + M.T))


def _scaled(matrix: sparse.csc_array, scale: Floats) -> sparse.csc_array:
    size = sparse.diags_array(scale)
    return sparse.csc_array(size @ matrix @ size)
