"""The composite plates P1 and P2 under a sudden force, in fixed steps of 1 ms."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial

import lamella as lm
from lamella.bench import kratos
from lamella.bench.clock import a_step_of, cpu
from lamella.bench.exudyn_plate import INTEGRATION, ExudynPlate, node
from lamella.bench.peers import EXUDYN, KRATOS
from lamella.bench.row import Row, beside_first
from lamella.bench.shares import shares
from lamella.verification.p1_motion.case import cantilever
from lamella.verification.p2_motion.case import pinned

DT, MESH, STEPS = 1e-3, 6, 200
RHO = 0.9
INTEGRATOR = lm.GeneralizedAlpha(dt=DT, rho_inf=RHO)
FORCES = {"p1-motion": -10.0, "p2-motion": -2.0}

Move = Callable[[int], tuple[float, tuple[int, int, float]]]
"""Number of steps to CPU time [s]; iterations, factorisations, mean deflection [m]."""


def p1(runs: int) -> Iterator[Row]:
    """Clamped at x = 0, a force at the middle of the free edge."""
    clamp = {node(MESH, 0.0, j / MESH): 9 for j in range(MESH + 1)}
    yield from beside("p1-motion", cantilever(MESH, force=FORCES["p1-motion"]), clamp, node(MESH, 1.0, 0.5), runs)


def p2(runs: int) -> Iterator[Row]:
    """Corners pinned, a force at the centre."""
    pins = {node(MESH, x, y): 3 for x in (0.0, 1.0) for y in (0.0, 1.0)}
    yield from beside("p2-motion", pinned(MESH, FORCES["p2-motion"]), pins, node(MESH, 0.5, 0.5), runs)


def beside(case: str, system: lm.System, held: dict[int, int], loaded: int, runs: int) -> Iterator[Row]:
    """lamella, then Exudyn with both integrations and Kratos, then where lamella's time goes."""
    model = system.compile()

    def own(steps: int) -> tuple[float, tuple[int, int, float]]:
        seconds, result = cpu(lambda: lm.simulate(model, steps * DT, INTEGRATOR))
        done = result.statistics
        return seconds, (done.newton_iterations, done.factorisations, float(result["C.position"].values[:, 2].mean()))

    def exudyn(reduced: int, steps: int) -> tuple[float, tuple[int, int, float]]:
        seconds, done = cpu(lambda: ExudynPlate(MESH, held, loaded, FORCES[case], reduced).move(steps, DT))
        return seconds, (done.iterations, done.factorisations, float(done.z.mean()))

    def corotational(kind: str, steps: int) -> tuple[float, tuple[int, int, float]]:
        done = kratos.move(kind, MESH, FORCES[case], steps, DT, RHO)
        return done.seconds, (done.iterations, done.iterations, float(done.z.sum() / (steps + 1)))  # begins at zero

    own(2)  # compiles what is not in the cache
    moves: dict[str, Move] = {"lamella Plate48": own}
    if EXUDYN.find() is not None:
        moves |= {f"Exudyn ANCFThinPlate, {way}": partial(exudyn, value) for way, value in INTEGRATION.items()}
    if case == "p1-motion" and KRATOS.find() is not None:
        moves |= {f"Kratos, {kind}": partial(corotational, kind) for kind in kratos.ELEMENTS}
    yield from beside_first([moved(case, code, move, runs) for code, move in moves.items()])
    if EXUDYN.find() is None:
        yield EXUDYN.missing(case)
    if case == "p1-motion" and KRATOS.find() is None:
        yield KRATOS.missing(case)
    yield from shares(case, "lamella Plate48", lambda: lm.simulate(model, STEPS * DT, INTEGRATOR))


def moved(case: str, code: str, move: Move, runs: int) -> Row:
    """Time and counts a step."""
    seconds, (iterations, factorisations, mean) = a_step_of(move, STEPS, runs)
    return Row(
        case=case,
        code=code,
        what=f"{MESH} x {MESH}",
        time=seconds * 1e3,
        unit="ms a step",
        steps=STEPS,
        iterations=iterations / STEPS,
        factorisations=factorisations / STEPS,
        value=mean,
        quantity="mean z_C [m]",
    )
