"""Derivatives of natural frequencies."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy import sparse

from lamella.assembly.equations import Equations
from lamella.assembly.point import STATIC, Point
from lamella.differentiation.neighbours import FOURTH, STEP, Neighbours
from lamella.differentiation.solution import PointDerivative
from lamella.errors import DeclarationError, ModelError
from lamella.modal import Modes, modes
from lamella.model import Model
from lamella.roles import Floats
from lamella.solve.eigen import left_shape, skew
from lamella.state import State

REPEATED = 1e-5
"""Distance of two eigenvalues, as a share of the larger one, below which their shapes are not told apart: the share of the one
in the computed shape of the other is rounding over this distance."""
RIGID = 1e-9
"""Eigenvalue, as a share of the next larger one of an elastic mode, that counts as zero."""


def frequency_derivatives(
    equations: Equations,
    neighbours: Sequence[Neighbours],
    found: Modes,
    numbers: Sequence[int],
    state: State | None,
    derivatives: Sequence[PointDerivative] | None,
) -> Floats:
    """Derivatives of natural frequencies [Hz] by each parameter, shape (n_number, n_parameter).

    With (K - w2 M) phi + J^T mu = 0, J phi = 0, the same of K^T with psi and nu, and psi^T M phi = 1

        dw2/dp = psi^T (dK/dp - w2 dM/dp) phi + nu^T (dJ/dp) phi + mu^T (dJ/dp) psi,        df = dw2 / (8 pi^2 |f|)

    (Fox and Kapoor 1968, with constraints) and dK along the change of the state. Where K is symmetric psi is phi.

    Args:
        equations: of the model.
        neighbours: of each parameter.
        found: the modes, with one more than the largest number where there is one.
        numbers: which, from 1.
        state: about which the modes are; None for the reference configuration.
        derivatives: of the state by each parameter; None for the reference configuration.

    Raises:
        DeclarationError: a frequency is zero or repeated, so that it has no derivative, or is that of a flutter.
    """
    for number in numbers:
        _refuse_repeated(found, number)
    chosen = equations.elimination.independent[: equations.n_motion]
    point = _point(equations, state)
    reference = None if state is None else point
    K, M, J = _matrices(equations, point)
    shapes, magnitude = found.shapes[chosen], equations.magnitude[: equations.n_motion]
    one_sided = skew(sparse.csc_array(K), magnitude)
    rows = []
    for number in numbers:
        f, phi = float(found.frequencies[number - 1]), shapes[:, number - 1]
        w2 = np.sign(f) * (2.0 * np.pi * f) ** 2
        psi = left_shape(sparse.csc_array(K), sparse.csc_array(M), J, w2, magnitude) if one_sided else phi
        psi = psi / (psi @ (M @ phi))
        left = np.stack([K @ phi - w2 * (M @ phi), K.T @ psi - w2 * (M @ psi)], axis=1)
        mu, nu = -np.linalg.lstsq(J.T.toarray(), left, rcond=None)[0].T if equations.n_lam else np.zeros((2, 0))

        def form(there: Equations, at: Point) -> Floats:
            K, M, J = _matrices(there, at)
            return np.array([psi @ (K @ phi - w2 * (M @ phi)) + nu @ (J @ phi) + mu @ (J @ psi)])  # noqa: B023

        changes = [
            float(each.difference(lambda side: form(side.equations, reference or _point(side.equations, None)))[0])
            for each in neighbours
        ]
        for k, derivative in enumerate(derivatives or ()):
            step = STEP / max(float(np.abs(derivative.u / equations.magnitude).max()), np.finfo(float).tiny)
            for place, weight in FOURTH:
                there = derivative.moved(point, place * step)
                there.lam += place * step * derivative.lam
                changes[k] += weight / step * float(form(equations, there)[0])
        rows.append(np.array(changes) / (8.0 * np.pi**2 * abs(f)))
    return np.array(rows)


def enough_modes(model: Model, equations: Equations, count: int, state: State | None) -> Modes:
    """``count`` modes, and one more by which the last is told to be simple.

    Raises:
        ModelError: the model is described in a frame that spins.
    """
    if model.spin is not None:
        raise ModelError("gradient: derivatives of frequencies in a frame that spins (SteadySpin) are not available")
    return modes(model, count + 1 if count < equations.mobility - 1 else count, state=state)  # which refuses more than there are


def _refuse_repeated(found: Modes, number: int) -> None:
    frequencies = found.frequencies
    values = np.sign(frequencies) * frequencies**2
    own, others = values[number - 1], np.delete(values, number - 1)
    item = f"natural frequency {number}, {frequencies[number - 1]:.6g} Hz,"
    if abs(own) <= RIGID * np.abs(values).max():
        raise DeclarationError("gradient", f"{item} is that of a rigid body: it is zero and has no derivative")
    if found.quadrature is not None and found.quadrature[:, number - 1].any():
        raise DeclarationError("gradient", f"{item} is that of a flutter", "accepted is one whose shape swings in phase")
    apart = np.abs(others - own) / np.maximum(np.abs(others), abs(own))
    if len(apart) and apart.min() < REPEATED:
        twin = frequencies[np.argsort(np.abs(values - own))[1]]
        accepted = "accepted is a simple one: the parameter splits these, and which comes first changes there"
        raise DeclarationError(
            "gradient", f"{item} is repeated, the next is {twin:.9g} Hz, so that it has no derivative", accepted
        )


def _point(equations: Equations, state: State | None) -> Point:
    point = equations.start(at_rest=True) if state is None else equations.point_of(state, state.t)
    point.at_rest, point.factor = True, 1.0 if state is None else state.factor
    return point


def _matrices(equations: Equations, point: Point) -> tuple[sparse.csr_array, sparse.csr_array, sparse.csr_array]:
    """K, M and J of motion, as those of which the modes are."""
    _, _, k, j = equations.linearise(point, STATIC)
    pattern, own = equations.matrix.pattern, slice(equations.n_motion)
    K, M = (sparse.csr_array(pattern.matrix(x))[own, own] for x in (k.copy(), equations.matrix.mass))
    return K, M, sparse.csr_array(pattern.jacobian(j.copy())[:, own])
