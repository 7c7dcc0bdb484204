"""The linear solvers on matrices like those of plates: numeric factorisation and one solution."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial

import numpy as np

from lamella.assembly.pattern import Pattern
from lamella.bench.clock import best
from lamella.bench.row import Row
from lamella.roles import Floats
from lamella.solve.base import LinearSolver
from lamella.solve.linear import Method, linear_solver
from lamella.solve.pardiso import library

CASE = "linear"
GRIDS = {"7 x 7 nodes": (7, 7), "2 x 41 nodes": (2, 41), "13 x 13 nodes": (13, 13), "25 x 25 nodes": (25, 25)}
METHODS: tuple[Method, ...] = ("multifrontal", "band", "superlu", *(() if library() is None else ("pardiso",)))


def plate_like(nx: int, ny: int) -> tuple[Pattern, Floats]:
    """Pattern and values of a positive definite matrix with the blocks of nx by ny nodes of 12 coordinates."""
    rng = np.random.default_rng(0)
    corner = (np.arange(ny - 1)[:, None] * nx + np.arange(nx - 1)).ravel()
    coords = (12 * (corner[:, None] + np.array([0, 1, nx, nx + 1]))[:, :, None] + np.arange(12)).reshape(-1, 48)
    b = rng.standard_normal((len(coords), 48, 48))
    values = b @ b.transpose(0, 2, 1) + np.eye(48)
    rows, cols = np.broadcast_arrays(coords[:, :, None], coords[:, None, :])
    n, upper = 12 * nx * ny, rows <= cols
    entries, place = np.unique(rows[upper] * n + cols[upper], return_inverse=True)
    indptr = np.searchsorted(entries // n, np.arange(n + 1))
    pattern = Pattern(n, indptr, entries % n, True, 0, np.zeros(1, np.int64), np.zeros(0, np.int64))
    return pattern, np.bincount(place, weights=values[upper]).astype(np.float64)


def calls(solver: LinearSolver, k: Floats) -> dict[str, Callable[[], object]]:
    """What a solver does with a matrix, which it factorises first."""
    none, right = np.zeros(0), np.ones(solver.pattern.n)
    solver.factorise(k, none)
    return {"factorise": partial(solver.factorise, k, none), "solve": partial(solver.solve, right, none)}


def run(runs: int) -> Iterator[Row]:
    """Each solver on each grid; the shortest of many calls, ``runs`` times as long. Ratios are to the multifrontal one."""
    for name, (nx, ny) in GRIDS.items():
        pattern, k = plate_like(nx, ny)
        rows: dict[str, Row] = {}
        for method in METHODS:
            for what, call in calls(linear_solver(pattern, method), k).items():
                work = f"{name}, {pattern.n} unknowns: {what}"
                row = Row(case=CASE, code=f"lamella, {method}", what=work, time=best(call, 0.05 * runs) * 1e3, unit="ms")
                yield row.beside(rows.setdefault(what, row))
