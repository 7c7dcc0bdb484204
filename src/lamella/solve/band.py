"""Cholesky factorisation in band storage (LAPACK), for symmetric positive definite matrices."""

from __future__ import annotations

import numpy as np
from scipy.linalg import get_lapack_funcs
from scipy.sparse.csgraph import reverse_cuthill_mckee

from lamella.assembly.pattern import Pattern
from lamella.roles import Floats, Ints
from lamella.solve.base import PIVOT_TOLERANCE, SymmetricFactor

_pbtrf, _pbtrs = get_lapack_funcs(("pbtrf", "pbtrs"), dtype=np.float64)


def _bandwidth(pattern: Pattern, position: Ints) -> int:
    """Number of sub-diagonals when coordinate i stands at ``position[i]``."""
    if not len(pattern.indices):
        return 0
    return int(np.abs(position[pattern.rows] - position[pattern.indices]).max())


def band_order(pattern: Pattern) -> tuple[Ints, int]:
    """Order of the coordinates that makes the band narrow: reverse Cuthill-McKee, or the given order where that is narrower.

    On a rectangle of elements the given order, node by node along the shorter side, is narrower: the levels of Cuthill-McKee
    start at a corner and run along two sides.

    Returns:
        The coordinate at each position, shape (n,), and the number of sub-diagonals.

    Source: A. George, J. W. H. Liu, Computer Solution of Large Sparse Positive Definite Systems (1981), chapter 4.
    """
    given = np.arange(pattern.n)
    order = np.asarray(
        reverse_cuthill_mckee(pattern.matrix(np.ones(len(pattern.indices))).tocsr(), symmetric_mode=True), np.int64
    )
    width_given, width = _bandwidth(pattern, given), _bandwidth(pattern, np.argsort(order))
    return (given, width_given) if width_given <= width else (order, width)


class BandCholesky(SymmetricFactor):
    """K = L L^T in lower band storage, entry (i, j) at [i - j, j], columns contiguous, factorised in place by LAPACK's dpbtrf.

    Args:
        pattern: a symmetric pattern; its multipliers are ignored.
    """

    def __init__(self, pattern: Pattern) -> None:
        self.pattern = pattern
        self._order, self.bandwidth = band_order(pattern)
        position = np.argsort(self._order)
        self.cost = float(pattern.n) * self.bandwidth**2 / 2
        self.size = pattern.n * (self.bandwidth + 1)
        self._band = np.zeros((self.bandwidth + 1, pattern.n), order="F")
        self._flat = self._band.reshape(-1, order="F")
        p, q = position[pattern.rows], position[pattern.indices]
        column, row = np.minimum(p, q), np.maximum(p, q)
        self._slot = column * (self.bandwidth + 1) + row - column
        self._diagonal = np.zeros(pattern.n)

    def factorise(self, k: Floats) -> int:
        """Scatter into the band and factorise; -1, or the coordinate of the first pivot that is not positive."""
        self._flat.fill(0.0)
        self._flat[self._slot] = k
        self._diagonal[:] = self._band[0]
        _, info = _pbtrf(self._band, lower=1, overwrite_ab=1)
        if info > 0:
            return int(self._order[info - 1])
        small = ~(self._band[0] ** 2 > PIVOT_TOLERANCE * self._diagonal)
        return int(self._order[np.argmax(small)]) if small.any() else -1

    def solve(self, r: Floats) -> Floats:
        """K^-1 r by forward and back substitution."""
        x = np.empty_like(r)
        x[self._order], _ = _pbtrs(self._band, r[self._order], lower=1, overwrite_b=1)
        return x
