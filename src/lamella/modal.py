"""Natural frequencies and shapes about any state."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import sparse
from scipy.sparse import linalg

from lamella.assembly.equations import Equations
from lamella.assembly.point import STATIC
from lamella.errors import DeclarationError, ModelError
from lamella.model import Model
from lamella.roles import Floats
from lamella.state import State
from lamella.system import System

RIGID_MODES = 7
"""Modes computed beyond those asked for: the six of a rigid body and one elastic, which sets the scale."""


@dataclass(frozen=True)
class Modes:
    """Natural modes K phi = omega^2 M phi about a state, phi^T M phi = 1. Temperatures stay as they are.

    Args:
        model: the compiled model.
        frequencies: ascending [Hz]; an unstable mode has a negative one, -sqrt(-omega^2) / 2 pi, shape (n,).
        shapes: columns of all coordinates, shape (n_q, n).
        state: coordinates about which the modes are, shape (n_q,).
    """

    model: Model
    frequencies: Floats
    shapes: Floats
    state: Floats

    def displaced(self, mode: int, amplitude: float) -> Floats:
        """Coordinates with mode number ``mode`` (from 0) added, its largest displacement being ``amplitude`` [m].

        A rigid body that turns about its origin is displaced as far as its points at its reach are.
        """
        shape = self.shapes[:, mode]
        moved = np.linalg.norm(self.model.vectors(shape), axis=1)
        largest = moved[self.model.is_position].max()
        for body in self.model.rigid_bodies:
            reach = self.model.magnitude[3 * body.first]
            largest = max(largest, reach * moved[body.first + 1 : body.first + 4].max())
        return self.state + amplitude / largest * shape


def modes(system: System | Model, n: int, *, state: State | None = None) -> Modes:
    """The ``n`` lowest natural modes.

    Args:
        system: the system.
        n: number of modes.
        state: about which state, for example ``equilibrium(...).final``; the reference configuration otherwise.

    Raises:
        DeclarationError: n is not positive or exceeds the number of independent coordinates.
        ModelError: the system has multipliers whose constraints are redundant.
    """
    model = system.compile() if isinstance(system, System) else system
    equations = Equations(model)
    free = equations.mobility
    if not 1 <= n <= free - 1:
        raise DeclarationError("modes", f"n = {n}", f"accepted is 1 to {free - 1} for this system")
    point = equations.start(at_rest=True) if state is None else equations.point_of(state, state.t)
    point.at_rest, point.factor = True, 1.0 if state is None else state.factor
    _, _, k, j = equations.linearise(point, STATIC)
    pattern = equations.matrix.pattern
    own = slice(equations.n_motion)
    K, M = (sparse.csc_array(sparse.csr_array(pattern.matrix(x))[own, own]) for x in (k.copy(), equations.matrix.mass))
    values, vectors = _lowest(K, M, sparse.csr_array(pattern.jacobian(j.copy())[:, own]), n, equations.magnitude[own])
    frequencies = np.sign(values) * np.sqrt(np.abs(values)) / (2 * np.pi)
    shapes = np.zeros((equations.n_u, n))
    shapes[own] = vectors
    return Modes(model, frequencies, equations.elimination.T @ shapes, equations.coordinates(point))


def _lowest(K: sparse.csc_array, M: sparse.csc_array, J: sparse.csr_array, n: int, magnitude: Floats) -> tuple[Floats, Floats]:
    """Eigenvalues nearest to a small negative shift, so that rigid-body modes and slightly unstable ones are found too.

    A body that can move freely has eigenvalues of zero, from which no shift can be derived; close to them the matrix is all but
    singular and the elastic modes drown in rounding. They are then computed again with a shift of the elastic modes' order.
    """
    scale = sparse.diags_array(magnitude)  # positions, slopes and twists differ by orders of magnitude
    K, M, J = sparse.csc_array(scale @ K @ scale), sparse.csc_array(scale @ M @ scale), sparse.csr_array(J @ scale)
    count = min(n + RIGID_MODES, len(magnitude) - len(J.indptr))
    values, vectors = _nearest(K, M, J, count, -1e-3 * _typical(K, M))
    largest = np.abs(values).max()
    if np.abs(values).min() < 1e-6 * largest:
        values, vectors = _nearest(K, M, J, count, -0.1 * largest)
    chosen = np.argsort(values)[:n]
    return values[chosen], scale @ vectors[:, chosen]


def _nearest(K: sparse.csc_array, M: sparse.csc_array, J: sparse.csr_array, n: int, shift: float) -> tuple[Floats, Floats]:
    """The ``n`` eigenvalues nearest to a shift below them, on the null space of J."""
    n_u, n_lam = len(M.indptr) - 1, len(J.indptr) - 1
    matrix = K - shift * M
    saddle = sparse.block_array([[matrix, J.T], [J, None]], format="csc") if n_lam else matrix
    try:
        factor = linalg.splu(sparse.csc_matrix(saddle))
    except RuntimeError as error:
        raise ModelError(
            "modes: the constraints are redundant or some mass is missing; the shifted matrix is singular"
        ) from error

    def inverse(x: Floats) -> Floats:
        return factor.solve(np.concatenate([np.ravel(x), np.zeros(n_lam)]))[:n_u]

    operator: Any = linalg.LinearOperator((n_u, n_u), matvec=inverse, dtype=float)  # pyright: ignore[reportCallIssue]
    start = inverse(M @ np.ones(n_u))
    values, vectors = linalg.eigsh(K, n, M, sigma=shift, OPinv=operator, which="LM", v0=start)
    return np.asarray(values), np.asarray(vectors)


def _typical(K: sparse.csc_array, M: sparse.csc_array) -> float:
    """A squared frequency of the order of the lowest elastic ones, from a few steps of inverse iteration with a rough shift."""
    rough = 1e-9 * K.diagonal().mean() / M.diagonal().mean()
    factor = linalg.splu(sparse.csc_matrix(K + rough * M))
    x, value = np.random.default_rng(0).standard_normal(len(K.indptr) - 1), 0.0
    for _ in range(4):
        x = factor.solve(M @ x)
        x /= np.sqrt(x @ (M @ x))
        value = float(x @ (K @ x))
    return max(abs(value), rough)
