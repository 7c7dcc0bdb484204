"""The cantilever plate P1 in equilibrium: CPU time to a deflection within 0.2 % of the converged one, over meshes."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Literal

import lamella as lm
from lamella.bench import calculix, kratos
from lamella.bench.clock import cpu, cpu_of_program, median
from lamella.bench.exudyn_plate import INTEGRATION, STATIC_STEPS, ExudynPlate, node
from lamella.bench.peers import CALCULIX, EXUDYN, KRATOS, Peer
from lamella.bench.row import Row
from lamella.errors import LamellaError
from lamella.verification import References
from lamella.verification.p1_motion.case import cantilever
from lamella.verification.p1_static import case as verified

CASE, FORCE = "p1-static", -10.0
MESHES = (4, 6, 8, 10, 12, 16, 20)
GOAL = 2e-3
"""Relative error to reach; that of the converged deflection itself is 0.02 %."""

TOO_LONG, LONG = 5.0, 1.0
"""A code goes on to finer meshes until a run takes this many seconds, and until this many once the goal is reached."""

NEW_PROCESS = "from lamella.bench.static import own; own({})"


@dataclass(frozen=True)
class Bent:
    """Counts of a static solution and the deflection under the force [m]."""

    steps: int
    iterations: int
    factorisations: int
    z: float


@dataclass(frozen=True)
class Solver:
    """A code: its name, what solves on n x n elements and gives the CPU time [s] too, and the peer it needs."""

    code: str
    solve: Callable[[int], tuple[float, Bent]]
    peer: Peer | None = None


def own(n: int, n_gauss: Literal[3, 4] = 4) -> tuple[float, Bent]:
    """lamella, from the description of the system to its equilibrium."""
    seconds, result = cpu(lambda: lm.equilibrium(cantilever(n, n_gauss, FORCE)))
    done = result.statistics
    return seconds, Bent(done.steps, done.newton_iterations, done.factorisations, float(result["C.position"][2]))


def exudyn(way: str, n: int) -> tuple[float, Bent]:
    """Exudyn, from the description of the system to its equilibrium."""
    clamp = {node(n, 0.0, j / n): 9 for j in range(n + 1)}
    seconds, done = cpu(lambda: ExudynPlate(n, clamp, node(n, 1.0, 0.5), FORCE, INTEGRATION[way]).bend())
    return seconds, Bent(STATIC_STEPS, done.iterations, done.factorisations, float(done.z[0]))


def ccx(n: int) -> tuple[float, Bent]:
    """CalculiX, a process of its own; each iteration factorises."""
    done = calculix.bend(n, FORCE)
    return done.seconds, Bent(done.increments, done.iterations, done.iterations, done.z)


def corotational(kind: str, n: int) -> tuple[float, Bent]:
    """Kratos, from the description of the plate to its equilibrium; each iteration factorises."""
    done = kratos.bend(kind, n, FORCE)
    return done.seconds, Bent(kratos.STATIC_STEPS, done.iterations, done.iterations, float(done.z[-1]))


SOLVERS = (
    Solver("lamella Plate48", own),
    Solver("lamella Plate48, reduced integration", partial(own, n_gauss=3)),
    *(Solver(f"Exudyn ANCFThinPlate, {way}", partial(exudyn, way), EXUDYN) for way in INTEGRATION),
    Solver("CalculiX S8R", ccx, CALCULIX),
    *(Solver(f"Kratos, {kind}", partial(corotational, kind), KRATOS) for kind in kratos.ELEMENTS),
)


def run(runs: int) -> Iterator[Row]:
    """Each code over its meshes; ratios are those of the coarsest meshes that reach the goal."""
    own(MESHES[0])  # compiles what is not in the cache
    fastest = None
    for solver in SOLVERS:
        if solver.peer is not None and solver.peer.find() is None:
            yield solver.peer.missing(CASE, solver.code)
            continue
        rows = list(over_meshes(solver, runs))
        first = next((row for row in rows if abs(row.error) <= GOAL), None)
        if fastest is None:
            fastest = first
        yield from (row.beside(fastest) if row is first and fastest is not None else row for row in rows)
        if solver.solve is own and first is not None:
            yield in_new_process(int(first.what.split()[0]), runs).beside(first)


def over_meshes(solver: Solver, runs: int) -> Iterator[Row]:
    """Rows of one code, from coarse to fine; a mesh on which it fails has a row that says so."""
    z = References.beside(verified.__file__).value("z_C at -10 N, converged")
    for n in MESHES:
        mesh = f"{n} x {n}"
        try:
            seconds, bent = median(partial(solver.solve, n), runs)
        except (LamellaError, RuntimeError, ValueError) as error:
            yield Row(
                case=CASE,
                code=solver.code,
                what=mesh,
                note=f"failed: {next(iter(str(error).strip().splitlines()), type(error).__name__)[:100]}",
            )
            continue
        error = bent.z / z - 1.0
        yield Row(
            case=CASE,
            code=solver.code,
            what=mesh,
            time=seconds,
            unit="s",
            steps=bent.steps,
            iterations=bent.iterations,
            factorisations=bent.factorisations,
            value=bent.z,
            quantity="z_C [m]",
            error=error,
        )
        if seconds > (LONG if abs(error) <= GOAL else TOO_LONG):
            return


def in_new_process(n: int, runs: int) -> Row:
    """lamella with the start of Python and the loading of compiled kernels, as CalculiX is measured."""
    command = [sys.executable, "-c", NEW_PROCESS.format(n)]
    seconds, _ = median(lambda: cpu_of_program(command, Path.cwd()), runs)
    return Row(case=CASE, code="lamella, new process", what=f"{n} x {n}", time=seconds, unit="s", note="with the start of Python")
