"""Balanced truncation of the stable part of a linear system."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy import linalg

from lamella.errors import ModelError
from lamella.roles import Floats


def balanced_truncation(
    A: Floats, B: Floats, C: Floats, order: int, unstable: int
) -> tuple[Floats, Floats, Floats, Floats, float]:
    """Keep the poles farthest to the right as they are and, of the rest, the states with the largest Hankel singular values.

    An ordered Schur form puts the ``unstable`` poles first, and a Sylvester equation takes out their coupling with the others.
    Of the stable part the Gramians A P + P A^T = -B B^T and A^T Q + Q A = -C^T C give, with P = S S^T and Q = R R^T,

        R^T S = U diag(sigma) V^T,      W = R U_r sigma_r^-1/2,      T = S V_r sigma_r^-1/2,      A_r = W^T A T

    and the transfer matrix errs by at most 2 sum of the singular values left out, at any frequency.

    Args:
        A, B, C: the system.
        order: number of states kept, at least ``unstable``.
        unstable: number of poles that are kept as they are.

    Returns:
        A, B and C of the reduced system, all Hankel singular values of the stable part, and the error bound.

    Raises:
        ModelError: the poles cannot be separated, or the Gramians are not to be had.

    Source: M. S. Tombs, I. Postlethwaite, Int. J. Control 46 (1987) 1319-1330; the bound: K. Glover, Int. J. Control 39 (1984)
    1115-1193.
    """
    kept, rest = _separated(A, B, C, unstable)
    F, G, H = rest
    n = len(F)
    if not n:
        return (*kept, np.zeros(0), 0.0)
    S = _root(linalg.solve_continuous_lyapunov(F, -G @ G.T))
    R = _root(linalg.solve_continuous_lyapunov(F.T, -H.T @ H))
    U, sigma, Vt = linalg.svd(R.T @ S)
    r = order - unstable
    rounding = n * np.finfo(float).eps * np.linalg.norm(R, 2) * np.linalg.norm(S, 2)
    r = min(r, int(np.sum(sigma > rounding)))  # the states beyond are neither controllable nor observable
    W, T = R @ U[:, :r] / np.sqrt(sigma[:r]), S @ Vt[:r].T / np.sqrt(sigma[:r])
    A_r = np.block([[kept[0], np.zeros((unstable, r))], [np.zeros((r, unstable)), W.T @ F @ T]])
    return A_r, np.vstack([kept[1], W.T @ G]), np.hstack([kept[2], H @ T]), sigma, 2.0 * float(sigma[r:].sum())


Part = tuple[Floats, Floats, Floats]


def _separated(A: Floats, B: Floats, C: Floats, unstable: int) -> tuple[Part, Part]:
    """The parts (A, B, C) of the poles farthest to the right, ``unstable`` of them, and of the others."""
    n = len(A)
    if not unstable:
        return (np.zeros((0, 0)), np.zeros((0, B.shape[1])), np.zeros((C.shape[0], 0))), (A, B, C)
    real = np.sort(np.linalg.eigvals(A).real)[::-1]
    limit = -np.inf if unstable == n else 0.5 * (real[unstable - 1] + real[unstable])
    ordered: Any = linalg.schur(A, output="real", sort=lambda re, im=0.0: re > limit)
    T, Z, found = ordered
    if found != unstable:
        raise ModelError(f"balanced: {unstable} poles are not stable but cannot be told apart from those that hardly decay")
    k = unstable
    X = linalg.solve_sylvester(T[:k, :k], -T[k:, k:], -T[:k, k:]) if k < n else np.zeros((k, 0))
    # with x = Z [[1, X], [0, 1]] y the two parts are uncoupled
    right = Z @ np.block([[np.eye(k), X], [np.zeros((n - k, k)), np.eye(n - k)]])
    left = np.block([[np.eye(k), -X], [np.zeros((n - k, k)), np.eye(n - k)]]) @ Z.T
    G, H = left @ B, C @ right
    return (T[:k, :k], G[:k], H[:, :k]), (T[k:, k:], G[k:], H[:, k:])


def _root(gramian: Floats) -> Floats:
    """S with S S^T = the Gramian; negative eigenvalues are rounding."""
    if not np.isfinite(gramian).all():
        raise ModelError("balanced: the Gramians are not finite; accepted is a system whose vibrations decay")
    values, vectors = linalg.eigh(0.5 * (gramian + gramian.T))
    return vectors * np.sqrt(np.maximum(values, 0.0))
