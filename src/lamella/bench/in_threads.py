"""What a second thread brings: the parts of a step on 40 x 40 elements, and whole steps of small and large plates."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from functools import partial

import numpy as np

import lamella as lm
from lamella import threads
from lamella._jit import shared
from lamella.assembly.equations import Equations
from lamella.assembly.point import Weights
from lamella.bench.row import Row
from lamella.lane import WIDTH, load, spread, store
from lamella.roles import Floats
from lamella.solve.multifrontal import Multifrontal
from lamella.verification.p1_motion.case import cantilever

CASE = "threads"
COUNTS = (1, 2)
MESH = 40
PLATES = (6, 12, 20, 40)
STEPS = 6
ROUNDS = 300_000
"""Rounds of :func:`_multiply`, which take some 0.5 ms."""
INTEGRATOR = lm.GeneralizedAlpha(dt=1e-3, rho_inf=0.9)
WEIGHTS = Weights(1.0, 0.0, 4.0 / INTEGRATOR.dt**2)

Work = Callable[[], object]


def parts(mesh: int) -> dict[str, Work]:
    """The parts of a Newton iteration, for the number of threads in use."""
    equations = Equations(cantilever(mesh).compile())
    matrix, point = equations.matrix, equations.start()
    point.u += 1e-3 * equations.magnitude * np.sin(np.arange(equations.n_u))
    q, before = equations.coordinates(point), equations.coordinates(equations.start())
    (block, f), k = equations.forces.parts[0], matrix.parts[0]
    factor, values = Multifrontal(matrix.pattern), equations.linearise(point, WEIGHTS, before)[2].copy()
    right = np.sin(np.arange(equations.n_u))

    def iteration() -> None:
        r, _, values, _ = equations.linearise(point, WEIGHTS, before)
        factor.factorise(values)
        factor.solve(r)

    numbers = np.ones((2, 4 * WIDTH))
    return {
        "machine: arithmetic alone": lambda: threads.run([partial(_multiply, row, ROUNDS) for row in numbers]),
        f"{mesh} x {mesh}: force": lambda: block.force(0.0, q, q, f),
        f"{mesh} x {mesh}: force + tangent": lambda: block.force_tangent(0.0, q, q, 1.0, 0.0, before, f, k),
        f"{mesh} x {mesh}: sums into the matrix": lambda: matrix.add_up(WEIGHTS.alpha_a),
        f"{mesh} x {mesh}: factorisation": lambda: factor.factorise(values),
        f"{mesh} x {mesh}: solution": lambda: factor.solve(right),
        f"{mesh} x {mesh}: Newton iteration": iteration,
    }


@shared
def _multiply(numbers: Floats, rounds: int) -> None:
    """Nothing but arithmetic, as much as a core can do: what two threads may bring at most where they share nothing else.

    Cores of a virtual machine may be two halves of one, which together do some 1.3 times as much as one of them alone.
    """
    half, one = spread(0.5), spread(1.0)
    a, b, c, d = load(numbers, 0), load(numbers, 1), load(numbers, 2), load(numbers, 3)
    e, f, g, h = a, b, c, d
    for _ in range(rounds):  # eight sums, as additions of one would wait for each other
        a, b, c, d = half * a + one, half * b + one, half * c + one, half * d + one
        e, f, g, h = half * e + one, half * f + one, half * g + one, half * h + one
    store(numbers, 0, a + b + c + d + e + f + g + h)


def compared(works: list[Work], rounds: int, repetitions: int = 3) -> list[float]:
    """Least elapsed time of the same work for each number of threads [s]; they take turns, as the machine may have other work."""
    least = [np.inf for _ in works]
    for _ in range(rounds):
        for i, (count, work) in enumerate(zip(COUNTS, works, strict=True)):
            threads.use(count)
            work()  # wakes the threads, whose work space is made when it is first used
            for _ in range(repetitions):
                start = time.perf_counter()
                work()
                least[i] = min(least[i], time.perf_counter() - start)
    return least


def rows(what: str, seconds: list[float], unit: str) -> Iterator[Row]:
    """A line for each number of threads."""
    for count, one in zip(COUNTS, seconds, strict=True):
        note = f"{seconds[0] / one:.2f} times as fast" if count > 1 else ""
        code = f"lamella, {count} thread{'s' * (count > 1)}"
        yield Row(case=CASE, code=code, what=what, time=one * 1e3, unit=unit, ratio=one / seconds[0], note=note)


def run(runs: int) -> Iterator[Row]:
    """Elapsed times, the least of many: with a second thread CPU time does not tell what is gained."""
    before = threads.number()
    try:
        works = []
        for count in COUNTS:
            threads.use(count)
            works.append(parts(MESH))
        for name in works[0]:
            yield from rows(name, compared([work[name] for work in works], 10 * runs), "ms elapsed")
        for mesh in PLATES:
            yield from rows(f"{mesh} x {mesh}: step", _step(mesh, runs), "ms a step, elapsed")
    finally:
        threads.use(before)


def _step(mesh: int, rounds: int) -> list[float]:
    """Time of one step, beyond what the start takes."""
    moves: list[list[Work]] = []
    for count in COUNTS:
        threads.use(count)
        equations = Equations(cantilever(mesh).compile())
        moves.append([partial(lm.simulate, equations, steps * INTEGRATOR.dt, INTEGRATOR) for steps in (1, 1 + STEPS)])
    short, long = (compared([move[i] for move in moves], rounds, 1) for i in (0, 1))
    return [(b - a) / STEPS for a, b in zip(short, long, strict=True)]
