"""Eigenvalues of sparse matrices on the null space of constraints: K phi = omega^2 M phi and (K + s G + s^2 M) phi = 0."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse import linalg

from lamella.errors import ModelError
from lamella.roles import Floats

Complexes = NDArray[np.complex128]
RIGID_MODES = 7
"""Modes computed beyond those asked for: the six of a rigid body and one elastic, which sets the scale."""

RIGID_ROOT = 1e-3
"""Roots below this share of a low elastic one are those of rigid motions, zero but for rounding."""
SEARCHED = 1e-12
"""Tolerance of the roots that are corrected afterwards; one by rounding alone, the default, is not always met."""
SKEW = 1e-13
"""Skew part of a stiffness, as a share of its largest entry, that is rounding."""
BESIDE = 1e-6
"""Distance from an eigenvalue, as a share of it, at which its shape is iterated."""
CORRECTIONS = 8
"""Corrections of a root at most; the number of right digits doubles with each."""
ROUNDING = 1e-11
"""Share of a root below which a correction is rounding."""
CLOSE = 1e-4
"""Share of a root within which another is a part of the same multiple one, where the method of Newton mixes shapes."""
SAME = 1e-5
"""Share of a root by which two may differ after their corrections that are one."""


class ConstrainedInverse:
    """x = K^-1 y on the null space of J, from [[K, J^T], [J, 0]] [x; lam] = [y; 0].

    Args:
        matrix: K, shape (n, n).
        J: constraint Jacobian, shape (n_lam, n).

    Raises:
        ModelError: the saddle-point matrix is singular.
    """

    def __init__(self, matrix: sparse.csc_array, J: sparse.csr_array) -> None:
        self._n, self._n_lam = len(matrix.indptr) - 1, len(J.indptr) - 1
        saddle = sparse.block_array([[matrix, J.T], [J, None]], format="csc") if self._n_lam else matrix
        try:
            self._factor = linalg.splu(sparse.csc_matrix(saddle))
        except RuntimeError as error:
            raise ModelError(
                "modes: the constraints are redundant or some mass is missing; the shifted matrix is singular"
            ) from error

    def __call__(self, y: Any) -> Any:
        return self._factor.solve(np.concatenate([np.ravel(y), np.zeros(self._n_lam)]))[: self._n]


def skew(K: sparse.csc_array, magnitude: Floats) -> bool:
    """Whether a stiffness has a skew part beyond rounding, as that of loads without a potential."""
    scale = sparse.diags_array(magnitude)
    scaled = sparse.csc_array(scale @ K @ scale)
    return bool(abs(scaled - scaled.T).max() > SKEW * abs(scaled).max())


def lowest(K: sparse.csc_array, M: sparse.csc_array, J: sparse.csr_array, n: int, magnitude: Floats) -> tuple[Floats, Floats]:
    """Eigenvalues nearest to a small negative shift, so that rigid-body modes and slightly unstable ones are found too.

    A body that can move freely has eigenvalues of zero, from which no shift can be derived; close to them the matrix is all but
    singular and the elastic modes drown in rounding. They are then computed again with a shift of the elastic modes' order.
    """
    return _lowest(_nearest, K, M, J, n, magnitude)


def lowest_of_skew(
    K: sparse.csc_array, M: sparse.csc_array, J: sparse.csr_array, n: int, magnitude: Floats
) -> tuple[Complexes, Complexes]:
    """The same of a stiffness that is not symmetric: eigenvalues by their real part, those of a flutter in complex pairs.

    Returns:
        Eigenvalues, and shapes with phi^H M phi = 1 whose real part is largest, columns, shape (n_u, n).
    """
    values, shapes = _lowest(_nearest_of_skew, K, M, J, n, magnitude)
    for k in range(n):
        shapes[:, k] /= np.sqrt(float(np.real(shapes[:, k].conj() @ (M @ shapes[:, k]))))
        shapes[:, k] *= np.exp(-0.5j * np.angle(np.sum(shapes[:, k] ** 2)))
    return np.asarray(values, complex), np.asarray(shapes, complex)


def left_shape(K: sparse.csc_array, M: sparse.csc_array, J: sparse.csr_array, value: float, magnitude: Floats) -> Floats:
    """psi with (K^T - value M) psi + J^T mu = 0, J psi = 0 at a simple eigenvalue, by inverse iteration."""
    scale = sparse.diags_array(magnitude)
    K, M, J = sparse.csc_array(scale @ K.T @ scale), sparse.csc_array(scale @ M @ scale), sparse.csr_array(J @ scale)
    inverse = ConstrainedInverse(sparse.csc_array(K - (1.0 - BESIDE) * value * M), J)
    psi = _any(len(magnitude))
    for _ in range(4):
        psi = inverse(M @ psi)
        psi /= np.sqrt(psi @ (M @ psi))
    return np.asarray(scale @ psi)


def _lowest(
    nearest: Callable[..., tuple[Any, Any]],
    K: sparse.csc_array,
    M: sparse.csc_array,
    J: sparse.csr_array,
    n: int,
    magnitude: Floats,
) -> tuple[Any, Any]:
    scale = sparse.diags_array(magnitude)  # positions, slopes and twists differ by orders of magnitude
    K, M, J = sparse.csc_array(scale @ K @ scale), sparse.csc_array(scale @ M @ scale), sparse.csr_array(J @ scale)
    count, typical = min(n + RIGID_MODES, len(magnitude) - len(J.indptr)), _typical(K, M, J)
    values, vectors = nearest(K, M, J, count, -1e-3 * typical)
    largest = np.abs(values).max()
    if np.abs(values).min() < 1e-6 * largest and largest > ROUNDING * typical:
        values, vectors = nearest(K, M, J, count, -0.1 * largest)
    chosen = np.argsort(values)[:n]
    return values[chosen], scale @ vectors[:, chosen]


def _nearest(K: sparse.csc_array, M: sparse.csc_array, J: sparse.csr_array, n: int, shift: float) -> tuple[Floats, Floats]:
    """The ``n`` eigenvalues nearest to a shift below them, on the null space of J."""
    n_u, inverse = len(M.indptr) - 1, ConstrainedInverse(sparse.csc_array(K - shift * M), J)
    operator: Any = linalg.LinearOperator((n_u, n_u), matvec=inverse, dtype=float)  # pyright: ignore[reportCallIssue]
    start = inverse(M @ _any(n_u))
    values, vectors = linalg.eigsh(K, n, M, sigma=shift, OPinv=operator, which="LM", v0=start)
    return np.asarray(values), np.asarray(vectors)


def _nearest_of_skew(
    K: sparse.csc_array, M: sparse.csc_array, J: sparse.csr_array, n: int, shift: float
) -> tuple[Complexes, Complexes]:
    """The same of a stiffness that is not symmetric."""
    n_u, inverse = len(M.indptr) - 1, ConstrainedInverse(sparse.csc_array(K - shift * M), J)
    if n > n_u - 2:  # as many as ARPACK does not find
        found: Any = np.linalg.eig(np.stack([inverse(column) for column in M.toarray().T], axis=1))
    else:
        operator: Any = linalg.LinearOperator((n_u, n_u), matvec=lambda x: inverse(M @ np.ravel(x)), dtype=float)  # pyright: ignore[reportCallIssue]
        found = linalg.eigs(operator, n, which="LM", v0=inverse(M @ _any(n_u)), tol=SEARCHED)  # pyright: ignore[reportArgumentType]
    largest = np.argsort(-np.abs(found[0]))[:n]
    return np.asarray(shift + 1.0 / found[0][largest], complex), np.asarray(found[1][:, largest], complex)


def _any(n: int) -> Floats:
    """A vector that no symmetry of a structure makes normal to a shape, the same at each call."""
    return np.random.default_rng(0).standard_normal(n)


def _typical(K: sparse.csc_array, M: sparse.csc_array, J: sparse.csr_array) -> float:
    """A squared frequency of the order of the lowest elastic ones, from a few steps of inverse iteration with a rough shift.

    Where nothing is elastic there is none, and 1 serves as well as any other. The axes of a joint at a point of a plate have
    neither mass nor stiffness: the constraints hold them.
    """
    if not K.count_nonzero():
        return 1.0
    rough = 1e-9 * K.diagonal().mean() / M.diagonal().mean()
    inverse = ConstrainedInverse(sparse.csc_array(K + rough * M), J)
    x, value = _any(len(K.indptr) - 1), 0.0
    for _ in range(4):
        x = inverse(M @ x)
        x /= np.sqrt(x @ (M @ x))
        value = float(x @ (K @ x))
    return max(abs(value), rough)


def gyroscopic(
    K: sparse.csc_array, G: sparse.csc_array, M: sparse.csc_array, J: sparse.csr_array, n: int, magnitude: Floats
) -> tuple[Complexes, Complexes]:
    """The ``n`` roots of smallest size of (K + s G + s^2 M) phi = 0 with skew-symmetric G, of each conjugate pair the upper one.

    With w = s phi the equation is linear, s phi = w and s M w = -K phi - G w. The shape is turned in phase so that its real part
    is largest. A small real shift keeps the matrix regular for bodies that can move freely; what rounding of their large motions
    leaves in the others is corrected by Newton's method.

    Returns:
        Roots s [1/s] by size, and shapes with phi^H M phi = 1, columns, shape (n_u, n).

    Source: F. Tisseur, K. Meerbergen, SIAM Review 43 (2001) 235-286, section 3.4.
    """
    scale = sparse.diags_array(magnitude)
    K, G, M = (sparse.csc_array(scale @ matrix @ scale) for matrix in (K, G, M))
    J = sparse.csr_array(J @ scale)
    unit = np.sqrt(_typical(K, M, J))  # time is counted in 1 / unit, so that phi and w have one size
    G, M = sparse.csc_array(unit * G), sparse.csc_array(unit**2 * M)
    shift, n_u = 0.03, len(magnitude)
    inverse = ConstrainedInverse(sparse.csc_array(K + shift * G + shift**2 * M), J)

    def operator(y: Floats) -> Floats:
        a, b = np.split(np.ravel(y), 2)
        phi = -inverse(M @ (b + shift * a) + G @ a)
        return np.concatenate([phi, a + shift * phi])

    size: Any = linalg.LinearOperator((2 * n_u, 2 * n_u), matvec=operator, dtype=float)  # pyright: ignore[reportCallIssue]
    count = min(2 * (n + RIGID_MODES), 2 * n_u - 2)
    start = operator(operator(_any(2 * n_u)))
    solution: Any = linalg.eigs(size, count, which="LM", v0=start, tol=SEARCHED)  # pyright: ignore[reportArgumentType]
    inverted, vectors = np.asarray(solution[0], complex), np.asarray(solution[1], complex)
    roots = (shift + 1.0 / inverted) * unit
    upper = np.flatnonzero(roots.imag > -1e-9 * np.abs(roots))
    candidates = upper[np.argsort(np.abs(roots[upper]))]
    found, shapes = _corrected(K, G, M, J, roots[candidates] / unit, vectors[:n_u, candidates], n)
    for k in range(n):
        shapes[:, k] /= np.sqrt(float(np.real(shapes[:, k].conj() @ (M @ shapes[:, k])))) / unit
        shapes[:, k] *= np.exp(-0.5j * np.angle(np.sum(shapes[:, k] ** 2)))
    return found * unit, scale @ shapes


def _corrected(
    K: sparse.csc_array,
    G: sparse.csc_array,
    M: sparse.csc_array,
    J: sparse.csr_array,
    roots: Complexes,
    shapes: Complexes,
    n: int,
) -> tuple[Complexes, Complexes]:
    """The first ``n`` of some roots and shapes after Newton's method on P(s) phi = 0, P = K + s G + s^2 M,

        x = P(s)^-1 P'(s) phi,    s <- s - phi.phi / phi.x,    phi <- x / |x|

    What rounding has made of one root twice comes together in it and is counted once. Multiple roots, as those of a body that
    drifts, stay as they are.
    """
    kept: list[tuple[complex, Complexes]] = []
    left: list[tuple[complex, Complexes]] = []
    for root, shape in zip(roots, shapes.T, strict=True):
        if len(kept) == n:
            break
        s, phi = complex(root), np.asarray(shape / np.linalg.norm(shape), complex)
        together = np.count_nonzero(np.abs(roots - s) <= CLOSE * abs(s)) > 1
        change = 0.0 if abs(s) < RIGID_ROOT or together else np.inf
        for _ in range(CORRECTIONS):
            if change <= ROUNDING * abs(s):
                break
            try:
                x = ConstrainedInverse(sparse.csc_array(K + s * G + s**2 * M), J)(2.0 * s * (M @ phi) + G @ phi)
            except ModelError:  # singular to the last digit: there is nothing to correct
                change = 0.0
                break
            step = 1.0 / np.vdot(phi, x)
            s, phi, change = s - complex(step), x / np.linalg.norm(x), float(abs(step))
        again = any(
            abs(s - t) <= SAME * abs(s) and abs(np.vdot(phi, psi)) > 1.0 - SAME for t, psi in kept if abs(t) >= RIGID_ROOT
        )
        if change <= SAME * abs(s) and not again:
            kept.append((s, phi))
        else:
            left.append((complex(root), shape))
    kept = sorted([*kept, *left][:n], key=lambda pair: abs(pair[0]))
    return np.array([s for s, _ in kept]), np.stack([phi for _, phi in kept], axis=1)
