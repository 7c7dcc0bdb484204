"""The unfolding solar array: four panels of 6 x 6 elements, 2174 independent coordinates, and the same with rigid panels."""

from __future__ import annotations

from collections.abc import Iterator

import lamella as lm
from lamella.bench.clock import a_step
from lamella.bench.row import Row
from lamella.bench.shares import shares
from lamella.examples import example
from lamella.io.model_file import read_model
from lamella.model import Model
from lamella.result import Result

CASE, CODE = "array-motion", "lamella"
STEPS = 150
INTEGRATOR = lm.GeneralizedAlpha(dt=1e-3, rho_inf=0.9)


def run(runs: int) -> Iterator[Row]:
    """Time and counts a step of 1 ms, and where the time of flexible panels goes."""
    for strain in ("exact", "rigid"):
        settings = [f"system.p{k}.strain={strain}" for k in range(1, 5)]
        model = read_model(example("solar-array").model, settings).system.compile()

        def move(steps: int, model: Model = model) -> Result:
            return lm.simulate(model, steps * INTEGRATOR.dt, INTEGRATOR)

        move(5)  # compiles what is not in the cache
        seconds, result = a_step(move, STEPS, runs)
        done = result.statistics
        yield Row(
            case=CASE,
            code=CODE,
            what=f"{strain} panels" if strain == "rigid" else "flexible panels",
            time=seconds * 1e3,
            unit="ms a step",
            steps=done.steps,
            iterations=done.newton_iterations / done.steps,
            factorisations=done.factorisations / done.steps,
        )
        if strain == "exact":
            yield from shares(CASE, CODE, lambda move=move: move(STEPS))
