"""The element kernels on 40 elements with 4 x 4 integration points, in microseconds an element."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import numpy as np

from lamella.bench import roofline
from lamella.bench.clock import best
from lamella.bench.row import Row
from lamella.element import ELEMENTS
from lamella.element.shells import SHELLS
from lamella.roles import Floats

CASE, CODE = "kernels", "lamella"
N_ELEMENTS = 40  # five full blocks of eight, about the 36 elements of a 6 x 6 plate
N_GAUSS = 4


def arguments(name: str, n: int) -> tuple[tuple[Any, ...], Floats]:
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


def calls(name: str) -> dict[str, Callable[[], object]]:
    """What the kernels of an element compute for :data:`N_ELEMENTS` elements."""
    common, q = arguments(name, N_ELEMENTS)
    shell = SHELLS[name].strain_models["exact"](*common, N_GAUSS)
    damper = SHELLS[name].viscous(*common, 0.1, N_GAUSS)
    v, before = np.sin(q), q + 1e-3 * np.cos(q)
    f, k, k_full = (np.empty(n) for n in (len(shell.f_coords), len(shell.k_rows), len(damper.k_rows)))
    return {
        "energy": partial(shell.energy, 0, q),
        "force": partial(shell.force, 0, q, v, f),
        "force + tangent": partial(shell.force_tangent, 0, q, v, 1, 0, q, f, k),
        "force + extrapolated tangent": partial(shell.force_tangent, 0, q, v, 1, 0, before, f, k),
        "viscous force": partial(damper.force, 0, q, v, f),
        "viscous force + tangent": partial(damper.force_tangent, 0, q, v, 1, 1, q, f, k_full),
    }


def run(runs: int) -> Iterator[Row]:
    """Each kernel of both elements; the shortest of many calls, ``runs`` times as long, and what the machine could do."""
    yield from roofline.run(CASE, runs)
    for name in ("plate48", "plate36"):
        for what, call in calls(name).items():
            call()  # compiles what is not in the cache
            seconds = best(call, 0.1 * runs) / N_ELEMENTS
            work = f"{name}: {what}"
            note = roofline.rates(work, seconds)
            yield Row(case=CASE, code=CODE, what=work, time=seconds * 1e6, unit="µs an element", note=note)
