"""Time of the linear solvers on plate-like matrices: numeric factorisation and one solution, milliseconds, best of many.

Run ``python benchmarks/linear.py``; set OMP_NUM_THREADS=1 to compare single threads (the LAPACK behind SciPy uses all cores).
"""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np

from lamella.assembly.pattern import Pattern
from lamella.roles import Floats
from lamella.solve.linear import Method, linear_solver
from lamella.solve.pardiso import library

GRIDS = {"7x7 nodes": (7, 7), "belt 41x2 nodes": (2, 41), "13x13 nodes": (13, 13), "25x25 nodes": (25, 25)}
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


def best(call: Callable[[], object], seconds: float = 1.0) -> float:
    """Shortest time of a call [ms], repeated for about ``seconds`` and at least three times."""
    times: list[float] = []
    while len(times) < 3 or sum(times) < seconds:
        start = time.perf_counter()
        call()
        times.append(time.perf_counter() - start)
    return 1e3 * min(times)


def main() -> None:
    none = np.zeros(0)
    print(f"{'matrix':18}{'n':>6}  {'solver':14}{'set-up':>9}{'factorise':>11}{'solve':>8}   [ms]")
    for name, (nx, ny) in GRIDS.items():
        pattern, k = plate_like(nx, ny)
        r = np.ones(pattern.n)
        for method in METHODS:
            linear_solver(pattern, method).factorise(k, none)  # compiled from here on
            start = time.perf_counter()
            solver = linear_solver(pattern, method)
            setup = 1e3 * (time.perf_counter() - start)
            factorise = best(lambda s=solver, k=k: s.factorise(k, none))
            solve = best(lambda s=solver, r=r: s.solve(r, none), 0.3)
            print(f"{name:18}{pattern.n:6d}  {method:14}{setup:9.1f}{factorise:11.3f}{solve:8.3f}")


if __name__ == "__main__":
    main()
