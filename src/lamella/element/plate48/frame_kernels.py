"""The kernel of small-deformation models in moving frames: a constant stiffness with an update of low rank, turned."""

from __future__ import annotations

import numpy as np

from lamella._jit import njit
from lamella.roles import Floats


@njit
def turned_stiffness(K: Floats, H: Floats, G: Floats, R: Floats, factor: float, out: Floats) -> None:
    """Blocks factor R (K_kl + H_k G_l + (H_l G_k)^T) R^T of all pairs of vectors k <= l.

    Args:
        K: stiffness in the axes of the frames, shape (n_group, 3 n, 3 n).
        H: left factor of the update, shape (n_group, n, 3, 3).
        G: right factor of the update, shape (n_group, n, 3, 3).
        R: axes of the frames as columns, shape (n_group, 3, 3).
        factor: factor of all blocks.
        out: the blocks, nine entries each, row by row; flat.
    """
    block, half = np.empty((3, 3)), np.empty((3, 3))
    at = 0
    for g in range(H.shape[0]):
        for k in range(H.shape[1]):
            for m in range(k, H.shape[1]):
                for a in range(3):
                    for b in range(3):
                        value = K[g, 3 * k + a, 3 * m + b]
                        for c in range(3):
                            value += H[g, k, a, c] * G[g, m, c, b] + H[g, m, b, c] * G[g, k, c, a]
                        block[a, b] = factor * value
                for a in range(3):
                    for b in range(3):
                        half[a, b] = R[g, a, 0] * block[0, b] + R[g, a, 1] * block[1, b] + R[g, a, 2] * block[2, b]
                for a in range(3):
                    for b in range(3):
                        out[at] = half[a, 0] * R[g, b, 0] + half[a, 1] * R[g, b, 1] + half[a, 2] * R[g, b, 2]
                        at += 1
