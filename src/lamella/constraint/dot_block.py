"""The block of all constraints that are sums of dot products of vectors: those of rigid bodies and of most joints."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from lamella._jit import njit
from lamella.dofs import DotRow
from lamella.roles import ConstraintBlock, Floats, Ints


class DotBlock(ConstraintBlock):
    """Phi_i = sum over terms c u . w - constant_i - motion_i(t), with u and w linear in the coordinate vectors x_k.

    Multiplied out, a row is a quadratic form of its coordinate vectors:

        Phi_i = sum_p w_p x_kp . x_lp + sum_s c_s . x_ks - constant_i - motion_i(t)

    so that Phi_q is linear in q, (Phi_q^T lam)_q is constant but for lam, and gamma = sum_p 2 w_p v_kp . v_lp - motion''.

    Args:
        name: name of the block, for messages.
        rows: the rows.
        body: see :class:`lamella.roles.ConstraintBlock`.
    """

    def __init__(self, name: str, rows: Sequence[DotRow], *, body: bool = False) -> None:
        self.name, self.n_lam, self.rows, self.body = name, len(rows), tuple(rows), body
        pairs, singles, self._constant = _multiplied_out(rows)
        self._row = np.array([key[0] for key in pairs], dtype=np.int64)
        self._k = np.array([3 * key[1] for key in pairs], dtype=np.int64)
        self._l = np.array([3 * key[2] for key in pairs], dtype=np.int64)
        self._w = np.array(list(pairs.values()), dtype=float)
        self._single_row = np.array([key[0] for key in singles], dtype=np.int64)
        self._single = np.array([3 * key[1] for key in singles], dtype=np.int64)
        self._c = np.array(list(singles.values()), dtype=float).reshape(-1, 3)
        self._motions = [(i, row.motion) for i, row in enumerate(rows) if row.motion is not None]
        self.moves = bool(self._motions)
        axis = np.arange(3)
        both = np.stack([self._k, self._l], axis=1)
        self.j_rows = np.concatenate([np.repeat(self._row, 6), np.repeat(self._single_row, 3)])
        self.j_cols = np.concatenate([(both[:, :, None] + axis).reshape(-1), (self._single[:, None] + axis).reshape(-1)])
        self.k_rows, self.k_cols = (self._k[:, None] + axis).reshape(-1), (self._l[:, None] + axis).reshape(-1)
        self._curvature = np.where(self._k == self._l, 2.0 * self._w, self._w)

    @property
    def labels(self) -> tuple[str, ...]:
        return tuple(row.label for row in self.rows)

    def prescribed(self, t: float) -> Floats:
        return self._moved("value", t)

    def phi(self, t: float, q: Floats, out: Floats) -> None:
        _values(self._row, self._k, self._l, self._w, self._single_row, self._single, self._c, self._constant, q, out)
        if self._motions:
            out -= self._moved("value", t)

    def jacobian(self, t: float, q: Floats, out: Floats) -> None:
        _jacobian(self._k, self._l, self._w, self._c, q, out)

    def curvature(self, t: float, q: Floats, lam: Floats, out: Floats) -> None:
        out[:] = np.repeat(lam[self._row] * self._curvature, 3)

    def phi_t(self, t: float, q: Floats, out: Floats) -> None:
        out[:] = -self._moved("rate", t)

    def gamma(self, t: float, q: Floats, v: Floats, out: Floats) -> None:
        _products(self._row, self._k, self._l, self._w, v, out)
        out *= 2.0
        if self._motions:
            out -= self._moved("acceleration", t)

    def _moved(self, derivative: str, t: float) -> Floats:
        values = np.zeros(self.n_lam)
        for i, motion in self._motions:
            values[i] = getattr(motion, derivative)(t)
        return values


Pairs = dict[tuple[int, int, int], float]
Singles = dict[tuple[int, int], Floats]


def _multiplied_out(rows: Sequence[DotRow]) -> tuple[Pairs, Singles, Floats]:
    """Weights of (row, k, l) with k <= l, vectors of (row, k), and what is left on the right-hand side, shape (n,)."""
    pairs: Pairs = {}
    singles: Singles = {}
    constant = np.array([row.constant for row in rows], dtype=float)
    for i, row in enumerate(rows):
        for c, u, w in row.terms:
            constant[i] -= c * float(u.constant @ w.constant)
            for k, a in zip(u.vectors.tolist(), u.weights.tolist(), strict=True):
                for m, b in zip(w.vectors.tolist(), w.weights.tolist(), strict=True):
                    key = (i, min(k, m), max(k, m))
                    pairs[key] = pairs.get(key, 0.0) + c * a * b
            for moving, fixed in ((u, w.constant), (w, u.constant)):
                if fixed.any():
                    for k, a in zip(moving.vectors.tolist(), moving.weights.tolist(), strict=True):
                        singles[i, k] = singles.get((i, k), np.zeros(3)) + c * a * fixed
    return pairs, singles, constant


@njit
def _products(row: Ints, k: Ints, m: Ints, w: Floats, x: Floats, out: Floats) -> None:
    """out_i = sum_p w_p x_kp . x_mp."""
    out[:] = 0.0
    for p in range(row.size):
        a, b = k[p], m[p]
        out[row[p]] += w[p] * (x[a] * x[b] + x[a + 1] * x[b + 1] + x[a + 2] * x[b + 2])


@njit
def _values(
    row: Ints, k: Ints, m: Ints, w: Floats, single_row: Ints, single: Ints, c: Floats, constant: Floats, x: Floats, out: Floats
) -> None:
    """out_i = sum_p w_p x_kp . x_mp + sum_s c_s . x_ks - constant_i."""
    _products(row, k, m, w, x, out)
    for s in range(single_row.size):
        a = single[s]
        out[single_row[s]] += c[s, 0] * x[a] + c[s, 1] * x[a + 1] + c[s, 2] * x[a + 2]
    for i in range(len(out)):
        out[i] -= constant[i]


@njit
def _jacobian(k: Ints, m: Ints, w: Floats, c: Floats, x: Floats, out: Floats) -> None:
    """Derivatives of each pair by x_k, then by x_m; then those of the single vectors."""
    at = 0
    for p in range(k.size):
        for i in range(3):
            out[at + i] = w[p] * x[m[p] + i]
            out[at + 3 + i] = w[p] * x[k[p] + i]
        at += 6
    for s in range(len(c)):
        for i in range(3):
            out[at + i] = c[s, i]
        at += 3
