"""PARDISO of Intel's Math Kernel Library (optional: ``pip install lamella[mkl]``), called directly with cached pointers."""

from __future__ import annotations

import ctypes
import weakref
from functools import cache
from importlib import metadata

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from lamella.assembly.pattern import Pattern
from lamella.errors import MissingExtraError, SingularSystemError
from lamella.roles import Floats, Ints
from lamella.solve.base import BACKWARD_ERROR_LIMIT, LinearSolver, not_finite
from lamella.solve.saddle import SaddleMatrix, probe
from lamella.solve.superlu import CONDITION_LIMIT, REFINE_ABOVE, SuperLUSolver

_SYMMETRIC, _UNSYMMETRIC = -2, 11
_ANALYSE_FACTORISE, _FACTORISE, _SOLVE, _RELEASE = 12, 22, 33, -1
_SEQUENTIAL = 1


@cache
def library() -> ctypes.CDLL | None:
    """The library of the installed ``mkl`` package on one thread, None when it is not installed."""
    try:
        files = metadata.files("mkl") or []
    except metadata.PackageNotFoundError:
        return None
    for file in files:
        if file.name.startswith(("libmkl_rt", "mkl_rt")):
            mkl = ctypes.CDLL(str(file.locate()))
            mkl.MKL_Set_Threading_Layer(_SEQUENTIAL)
            return mkl
    return None


class _Handle:
    """One matrix in PARDISO: its memory, parameters and the pointers of every call."""

    def __init__(self, mkl: ctypes.CDLL, kind: int, matrix: sparse.csr_array) -> None:
        n = len(matrix.indptr) - 1
        self._mkl, self.matrix = mkl, matrix
        self._b, self._x = np.zeros(n), np.zeros(n)
        self._indptr, self._indices = matrix.indptr.astype(np.int32), matrix.indices.astype(np.int32)
        self.parameters = np.zeros(64, dtype=np.int32)
        self.parameters[0] = 1  # no defaults
        self.parameters[1] = 2  # nested dissection
        self.parameters[9] = 13  # pivots below 10^-13 are perturbed, and counted
        self.parameters[10] = self.parameters[12] = 1  # scaling and matching: else saddle points come out wrong, silently
        self.parameters[34] = 1  # indices from 0
        self._memory = np.zeros(64, dtype=np.int64)
        self._integers = np.array([1, 1, kind, 0, n, 1, 0, 0], dtype=np.int32)  # phase at 3, error at 7
        one, at = self._integers.ctypes.data, self._integers.itemsize
        numbers = [one + i * at for i in range(8)]
        self._arguments = [
            ctypes.c_void_p(address)
            for address in (
                self._memory.ctypes.data,
                *numbers[:5],
                matrix.data.ctypes.data,
                self._indptr.ctypes.data,
                self._indices.ctypes.data,
                None,
                numbers[5],
                self.parameters.ctypes.data,
                numbers[6],
                self._b.ctypes.data,
                self._x.ctypes.data,
                numbers[7],
            )
        ]
        weakref.finalize(self, _release, mkl, self._arguments, self._integers, list(vars(self).values()))

    def call(self, phase: int) -> int:
        """Run a phase; 0, or PARDISO's error."""
        self._integers[3] = phase
        self._mkl.pardiso(*self._arguments)
        return int(self._integers[7])

    def solve(self, b: Floats) -> Floats:
        """Solution with the last factors."""
        self._b[:] = b
        self.call(_SOLVE)
        return self._x.copy()


def _release(mkl: ctypes.CDLL, arguments: list[ctypes.c_void_p], integers: NDArray[np.int32], kept_alive: object) -> None:
    """Give PARDISO's memory back; the arrays its pointers refer to are kept until then."""
    integers[3] = _RELEASE
    mkl.pardiso(*arguments)


def _pardiso_rows(a: sparse.csc_array, symmetric: bool) -> tuple[Ints, Ints, sparse.csr_array]:
    """What PARDISO takes of a matrix: rows of its upper triangle (of all entries when unsymmetric) with the whole diagonal.

    Returns:
        Which entries of the matrix are taken, their places in the result, and the result with zeros.
    """
    n = len(a.indptr) - 1
    rows, cols = np.asarray(a.indices, np.int64), np.repeat(np.arange(n), np.diff(a.indptr))
    stored = np.flatnonzero(rows <= cols) if symmetric else np.arange(len(rows))
    rows, cols = rows[stored], cols[stored]
    missing = np.setdiff1d(np.arange(n), rows[rows == cols])
    rows, cols = np.append(rows, missing), np.append(cols, missing)
    order = np.lexsort((cols, rows))
    indptr = np.searchsorted(rows[order], np.arange(n + 1))
    result = sparse.csr_array((np.zeros(len(order)), cols[order], indptr), shape=(n, n))
    return stored, np.argsort(order)[: len(stored)], result


class PardisoSolver(LinearSolver):
    """Factorisation of the equilibrated saddle-point matrix, symmetric indefinite or unsymmetric, with matching and scaling.

    The analysis uses the values of the first matrix and is repeated when the factors of a later one are poor. PARDISO perturbs
    the pivots of a singular matrix without an error, so each factorisation is checked; what fails is given to SuperLU, which
    names the coordinate of a singular matrix.

    Raises:
        MissingExtraError: the package ``mkl`` is not installed.

    Source: O. Schenk, K. Gartner, Electron. Trans. Numer. Anal. 23 (2006) 158-179.
    """

    def __init__(self, pattern: Pattern) -> None:
        mkl = library()
        if mkl is None:
            raise MissingExtraError("linear solver 'pardiso' needs the package mkl; install it with: pip install 'lamella[mkl]'")
        self.pattern = pattern
        self._a = SaddleMatrix(pattern)
        self._stored, self._slots, self._matrix = _pardiso_rows(self._a.matrix, pattern.symmetric)
        self._handle = _Handle(mkl, _SYMMETRIC if pattern.symmetric else _UNSYMMETRIC, self._matrix)
        self._probe = probe(self._a.size)
        self._analysed = self._ready = False
        self._fallback: SuperLUSolver | None = None

    @property
    def negative_pivots(self) -> int | None:
        """From PARDISO's count for a symmetric matrix."""
        if self._fallback is not None:
            return self._fallback.negative_pivots
        if not self.pattern.symmetric or not self._ready:
            return None
        return int(self._handle.parameters[22]) - self.pattern.n_lam

    def factorise(self, k: Floats, j: Floats) -> None:
        """Equilibrate, factorise and check."""
        self._ready, self._fallback = False, None
        error = not_finite(self.pattern, k, j)
        if error is not None:
            raise error
        self._a.fill(k, j)
        self._matrix.data[self._slots] = self._a.matrix.data[self._stored]
        if not (self._analysed and self._usable(_FACTORISE)):
            self._analysed = self._usable(_ANALYSE_FACTORISE)
        if not self._analysed:
            fallback = SuperLUSolver(self.pattern)
            fallback.factorise(k, j)
            self._fallback = fallback
        self._ready = True

    def _usable(self, phase: int) -> bool:
        """Factorise; whether the factors are accurate and the matrix is regular."""
        if self._handle.call(phase) or self._handle.parameters[13]:  # an error, or perturbed pivots
            return False
        z = self._handle.solve(self._probe)
        norm = np.abs(z).max(initial=0.0)
        error = np.abs(self._a.matrix @ z - self._probe).max(initial=0.0)
        return bool(norm < CONDITION_LIMIT and error <= BACKWARD_ERROR_LIMIT * (norm + 1.0))

    def solve(self, r: Floats, s: Floats) -> tuple[Floats, Floats]:
        """Solve, with one step of iterative refinement when the residual is not small."""
        if not self._ready:
            raise SingularSystemError("there is no factorisation to solve with; factorise a regular matrix first")
        if self._fallback is not None:
            return self._fallback.solve(r, s)
        b = self._a.scaled(r, s)
        z = self._handle.solve(b)
        residual = b - self._a.matrix @ z
        if np.abs(residual).max(initial=0.0) > REFINE_ABOVE * np.abs(b).max(initial=0.0):
            z += self._handle.solve(residual)
        return self._a.unscaled(z)
