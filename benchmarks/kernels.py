"""Times of the element kernels in microseconds an element: minimum over many repeats on one thread.

Run ``python benchmarks/kernels.py``; the first run also compiles. The goals for Plate48: at most 6 for force and tangent with
4 x 4 points, 0.5 for the force alone; for Plate36, 1.5 and 0.15 beyond what the same run measures for Plate48. The exit code is 1
when one is missed.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable

import numpy as np

from lamella.element import ELEMENTS
from lamella.element.shells import SHELLS

N_ELEMENTS = 40  # five full blocks of eight, about the 36 elements of a 6 x 6 plate
GOALS = {"force": 0.5, "force + tangent": 6.0, "force + extrapolated tangent": 6.0}
CONDENSING = {"force": 0.15, "force + tangent": 1.5, "force + extrapolated tangent": 1.5}
"""What Plate36 may take beyond Plate48, whose kernels it uses."""


def arguments(name: str, n: int):
    """Separate unit elements with an unsymmetric section, and a deformed state."""
    rng = np.random.default_rng(1)
    element = ELEMENTS[name]
    vectors = np.zeros((n, 4, element.vectors_per_node, 3))
    for node, (i, j) in enumerate(element.nodes):
        vectors[:, node, :3] = [[i, j, 0], [1, 0, 0], [0, 1, 0]]
    reference = vectors.reshape(n, -1)
    coords = np.arange(reference.size).reshape(reference.shape)
    root = rng.standard_normal((6, 6))
    q = (reference + 0.05 * rng.standard_normal(reference.shape)).reshape(-1)
    return ("plate", coords, np.ones(reference.shape), reference, root @ root.T), q


def microseconds(function: Callable[[], object], repeats: int = 400) -> float:
    """Shortest of many runs, for one element."""
    best = np.inf
    for _ in range(repeats):
        start = time.perf_counter()
        function()
        best = min(best, time.perf_counter() - start)
    return best * 1e6 / N_ELEMENTS


def measure(name: str, n_gauss: int) -> dict[str, float]:
    """All kernels of an element for one rule."""
    common, q = arguments(name, N_ELEMENTS)
    shell = SHELLS[name].strain_models["exact"](*common, n_gauss)
    damper = SHELLS[name].viscous(*common, 0.1, n_gauss)
    v, before = np.sin(q), q + 1e-3 * np.cos(q)
    f, k = np.empty(len(shell.f_coords)), np.empty(len(shell.k_rows))
    k_full = np.empty(len(damper.k_rows))
    return {
        "energy": microseconds(lambda: shell.energy(0, q)),
        "force": microseconds(lambda: shell.force(0, q, v, f)),
        "force + tangent": microseconds(lambda: shell.force_tangent(0, q, v, 1, 0, q, f, k)),
        "force + extrapolated tangent": microseconds(lambda: shell.force_tangent(0, q, v, 1, 0, before, f, k)),
        "viscous force": microseconds(lambda: damper.force(0, q, v, f)),
        "viscous force + tangent": microseconds(lambda: damper.force_tangent(0, q, v, 1, 1, q, f, k_full)),
    }


def main() -> int:
    rules = (3, 4, 5)
    missed, goals = 0, GOALS
    for name in ("plate48", "plate36"):
        times = {n: measure(name, n) for n in rules}
        print(f"{name + ', microseconds an element':40s}" + "".join(f"{n} x {n:<8d}" for n in rules) + "goal (4 x 4)")
        for kernel in times[4]:
            goal = goals.get(kernel)
            missed += goal is not None and times[4][kernel] > goal
            print(f"{kernel:40s}" + "".join(f"{times[n][kernel]:<12.2f}" for n in rules) + (f"{goal:.2f}" if goal else ""))
        goals = {kernel: times[4][kernel] + more for kernel, more in CONDENSING.items()}
    return int(missed > 0)


if __name__ == "__main__":
    sys.exit(main())
