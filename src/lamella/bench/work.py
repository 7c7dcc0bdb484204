"""Work against precision in motion: fixed steps and step control, on the cantilever P1 and on one that comes to rest."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial

import numpy as np

import lamella as lm
from lamella.bench.clock import cpu, median
from lamella.bench.exudyn_plate import INTEGRATION, ExudynPlate, node
from lamella.bench.peers import EXUDYN
from lamella.bench.row import Row
from lamella.integrate.base import Integrator
from lamella.model import Model
from lamella.roles import Floats
from lamella.verification.p1_motion.case import cantilever

MESH, FORCE = 6, -10.0
GRID = 50
"""Equal parts of a motion, at whose ends the deflections are compared; steps of fixed size end there too."""

Done = tuple[Floats, tuple[int, int, int]]
"""Deflections z_C [m]; steps, iterations, factorisations."""


def p1(runs: int) -> Iterator[Row]:
    """The first 0.2 s of P1, a vibration that goes on; Exudyn, which has fixed steps only, beside its own fine steps."""
    case, t_end = "p1-motion-work", 0.2
    model = cantilever(MESH, force=FORCE).compile()
    yield from own(case, model, t_end, 0.9, 25e-6, (0.25e-3, 0.5e-3, 1e-3, 2e-3, 4e-3), runs)
    way = "reduced integration"
    code = f"Exudyn ANCFThinPlate, {way}"
    if EXUDYN.find() is None:
        yield EXUDYN.missing(case, code)
        return
    clamp = {node(MESH, 0.0, j / MESH): 9 for j in range(MESH + 1)}

    def fixed(dt: float) -> Done:
        steps = round(t_end / dt)
        done = ExudynPlate(MESH, clamp, node(MESH, 1.0, 0.5), FORCE, INTEGRATION[way]).move(steps, dt)
        return done.z[-steps:][steps // GRID - 1 :: steps // GRID], (steps, done.iterations, done.factorisations)

    exact, _ = fixed(0.25e-3)
    yield from compared(case, code, [partial(fixed, dt) for dt in (1e-3, 2e-3, 4e-3)], exact, runs)


def settling(runs: int) -> Iterator[Row]:
    """P1 in slow air that damps every mode alike, until the plate rests: 6 s, in which the swings fall to e^-9."""
    model = cantilever(MESH, force=FORCE, mass_damping=3.0).compile()
    yield from own("settling-work", model, 6.0, 0.5, 0.25e-3, (1e-3, 2.5e-3, 5e-3, 10e-3), runs)


def own(case: str, model: Model, t_end: float, rho: float, finest: float, fixed: Sequence[float], runs: int) -> Iterator[Row]:
    """lamella with fixed steps and with tolerances, beside steps of ``finest`` [s]."""

    def move(integrator: Integrator) -> Done:
        result = lm.simulate(model, t_end, integrator, every=t_end / GRID, stride=10**9)
        assert len(result.at) == GRID + 1
        done = result.statistics
        return result["C.position"].values[1:, 2], (done.steps, done.newton_iterations, done.factorisations)

    exact, _ = move(lm.GeneralizedAlpha(dt=finest, rho_inf=rho))
    tolerances = (1e-4, 1e-5, 1e-6)
    ways: dict[str, list[Integrator]] = {
        "fixed steps": [lm.GeneralizedAlpha(dt=dt, rho_inf=rho) for dt in fixed],
        "step control": [lm.GeneralizedAlpha(dt=1e-3, rho_inf=rho, tolerance=tolerance) for tolerance in tolerances],
        "BDF": [lm.BDF(dt=1e-3, tolerance=tolerance) for tolerance in tolerances],
    }
    for way, integrators in ways.items():
        yield from compared(case, f"lamella, {way}", [partial(move, integrator) for integrator in integrators], exact, runs)


def compared(case: str, code: str, moves: Sequence[Callable[[], Done]], exact: Floats, runs: int) -> Iterator[Row]:
    """A row for each way to move: time, counts, and the root mean square of what the deflections differ, over the largest one."""
    for move in moves:
        seconds, (z, (steps, iterations, factorisations)) = median(partial(cpu, move), runs)
        yield Row(
            case=case,
            code=code,
            what=f"{steps} steps",
            time=seconds,
            unit="s",
            steps=steps,
            iterations=iterations,
            factorisations=factorisations,
            error=float(np.sqrt(np.mean((z - exact) ** 2)) / np.abs(exact).max()),
        )
