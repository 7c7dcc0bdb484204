"""Cost over size: a plate from 8 x 8 to 64 x 64 elements and a belt of up to 400 x 8, in motion."""

from __future__ import annotations

import statistics
import tracemalloc
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from math import log

import numpy as np

import lamella as lm
from lamella.assembly.equations import Equations
from lamella.bench.clock import a_step, cpu, median
from lamella.bench.contact import LENGTH, THICKNESS, WIDTH
from lamella.bench.row import Row
from lamella.result import Result
from lamella.solve.base import LinearSolver
from lamella.solve.layout import layout_of
from lamella.solve.linear import linear_solver
from lamella.verification.p1_motion.case import cantilever

CASE, CODE = "scale", "lamella"
STEPS = 6
INTEGRATOR = lm.GeneralizedAlpha(dt=1e-3, rho_inf=0.9)
PLATES = (8, 16, 32, 64)
BELTS = ((50, 8), (100, 8), (200, 8), (400, 8))


def belt(along: int, across: int) -> lm.System:
    """A free circular belt that is pulled at one point."""
    laminate = lm.Laminate(lm.Isotropic(E=1e9, nu=0.3, rho=1200), thickness=THICKNESS)
    system = lm.System()
    body = system.add(lm.Shell("belt", lm.BeltSurface(LENGTH, WIDTH), (along, across), laminate))
    system.add(lm.PointForce("pull", body.marker("A", 0.25 * LENGTH, 0.5 * WIDTH), (0, 50, 0)))
    return system


def weighed(n: int) -> lm.System:
    """The cantilever plate, which is let go: a load that is the same on every mesh, unlike that of one node."""
    system = cantilever(n, force=0.0)
    system.add(lm.Gravity("weight"))
    return system


def set_up(system: lm.System) -> tuple[Equations, LinearSolver]:
    """All that comes before the first step, but for the accelerations at the start."""
    equations = Equations(system.compile())
    return equations, linear_solver(equations.matrix.pattern)


def peak_memory(make: Callable[[], lm.System]) -> float:
    """The most that set-up and one step hold at once, beside what Python and its libraries take [MB]."""
    tracemalloc.start()
    try:
        lm.simulate(make(), INTEGRATOR.dt, INTEGRATOR)
        return tracemalloc.get_traced_memory()[1] * 1e-6
    finally:
        tracemalloc.stop()


def measured(what: str, motions: Mapping[str, Callable[[], lm.System]], runs: int) -> tuple[int, tuple[Row, ...]]:
    """Independent coordinates, and the rows of one mesh: of all its motions, and the rest with the first of them."""
    make = next(iter(motions.values()))
    seconds, (equations, solver) = median(lambda: cpu(lambda: set_up(make())), runs)
    matrix, none = equations.matrix, np.zeros(0)
    layout, right = layout_of(matrix.pattern), np.ones(matrix.pattern.n)
    row = partial(Row, case=CASE, code=CODE)
    counts = f"{layout.cost / 1e6:.0f} million multiplications and additions, {layout.size * 8e-6:.0f} MB of factor"
    factorised = statistics.median(cpu(partial(solver.factorise, matrix.mass, none))[0] for _ in range(3 * runs))
    solved = statistics.median(cpu(partial(solver.solve, right, none))[0] for _ in range(9 * runs))
    rows = (
        row(what=f"{what}: set-up", time=seconds, unit="s", note=f"{matrix.pattern.n} coordinates"),
        row(what=f"{what}: factorisation", time=factorised * 1e3, unit="ms", note=counts),
        row(what=f"{what}: solution", time=solved * 1e3, unit="ms"),
        *(stepped(f"{what}: {name}", Equations(moving().compile()), runs) for name, moving in motions.items()),
        row(what=f"{what}: peak memory", time=peak_memory(make), unit="MB"),
    )
    return matrix.pattern.n, rows


def stepped(what: str, equations: Equations, runs: int) -> Row:
    """The mean of the first steps."""

    def move(steps: int) -> Result:
        return lm.simulate(equations, steps * INTEGRATOR.dt, INTEGRATOR)

    step, result = a_step(move, STEPS, 3 * runs)
    done = result.statistics
    return Row(
        case=CASE,
        code=CODE,
        what=what,
        time=step * 1e3,
        unit="ms a step",
        steps=done.steps,
        iterations=done.newton_iterations / done.steps,
        factorisations=done.factorisations / done.steps,
    )


def run(runs: int) -> Iterator[Row]:
    """Meshes from coarse to fine; the note tells the exponent of the coordinates that leads from the mesh before to this one."""
    lm.simulate(cantilever(3), 2 * INTEGRATOR.dt, INTEGRATOR)  # compiles what is not in the cache
    plates = [
        (f"plate {n} x {n}", {"step, let go": partial(weighed, n), "step, sudden force at a node": partial(cantilever, n)})
        for n in PLATES
    ]
    belts = [(f"belt {n} x {m}", {"step": partial(belt, n, m)}) for n, m in BELTS]
    for family in (plates, belts):
        before: tuple[int, tuple[Row, ...]] | None = None
        for what, motions in family:
            n, rows = measured(what, motions, runs)
            if before is None:
                yield from rows
            else:
                yield from (_compared(row, coarser, n / before[0]) for row, coarser in zip(rows, before[1], strict=True))
            before = n, rows


def _compared(row: Row, coarser: Row, growth: float) -> Row:
    """The row with the exponent e of coarser to this one, time ~ n^e; times of small meshes may be lost in those of the start."""
    if min(row.time, coarser.time) <= 0.0:
        return row
    return row.noting(f"exponent {log(row.time / coarser.time) / log(growth):.2f}")
