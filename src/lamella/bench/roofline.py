"""What the machine could do at most: rates of a matrix product and of a triad, beside which those of kernels are read."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from lamella._jit import njit
from lamella.bench.clock import best
from lamella.bench.row import Row
from lamella.roles import Floats

PRODUCT = 256
"""Rows of the matrices: large enough for the full rate, and done within the time that a busy machine leaves in one piece."""
TRIADS = {"in the second-level cache": 10_000, "in memory": 8_000_000}
"""Numbers in each of the three arrays: 240 kB and 192 MB together."""

FLOP = {"plate48: force": 9.8e3, "plate48: force + tangent": 140e3}
"""Multiplications and additions of an element with 4 x 4 points. Force: 2.3e3 for the sums along eta, 460 for each point (240 of
them for the sums along xi); tangent: counted on a prototype with the same sum factorisation."""
BYTES = {"plate48: force": 1.5e3, "plate48: force + tangent": 10.9e3}
"""Read or written for an element: 48 coordinates, their indices and factors, 48 forces, and 1176 entries of the tangent; elements
that differ read 3.5 kB of constants each."""


@njit
def triad(a: Floats, b: Floats, c: Floats) -> None:
    """a = b + 3 c, of McCalpin's STREAM: 24 bytes and two operations for each number."""
    for i in range(len(a)):
        a[i] = b[i] + 3.0 * c[i]


def run(case: str, runs: int) -> Iterator[Row]:
    """Rates of the machine on one core."""
    a = np.random.default_rng(1).standard_normal((PRODUCT, PRODUCT))
    seconds = best(lambda: a @ a, 0.5 * runs)
    rate = f"{2e-9 * PRODUCT**3 / seconds:.0f} Gflop/s"
    yield Row(case=case, code="machine", what=f"matrix product, {PRODUCT} rows", time=seconds * 1e3, unit="ms", note=rate)
    for where, n in TRIADS.items():
        arrays = [np.ones(n) for _ in range(3)]
        triad(*arrays)  # compiles it
        seconds = best(lambda arrays=arrays: triad(*arrays), 0.2 * runs)
        rate = f"{24e-9 * n / seconds:.0f} GB/s"
        yield Row(case=case, code="machine", what=f"triad {where}", time=seconds * 1e3, unit="ms", note=rate)


def rates(what: str, seconds: float) -> str:
    """Rates of a kernel that takes so many seconds an element; empty for those whose operations are not counted."""
    if what not in FLOP:
        return ""
    return f"{1e-9 * FLOP[what] / seconds:.0f} Gflop/s, {1e-9 * BYTES[what] / seconds:.0f} GB/s"
