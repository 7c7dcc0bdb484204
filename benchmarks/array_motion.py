"""The unfolding solar array in motion: time and counts a step, and where the time goes.

    python benchmarks/array_motion.py [--seconds 0.3]

Four panels of 6x6 elements, 2174 independent coordinates, steps of 1 ms; rigid panels for comparison. Counts do not depend on the
machine.
"""

from __future__ import annotations

import argparse
import cProfile
import pstats
import time

import lamella as lm
from lamella.examples import example
from lamella.io.model_file import read_model
from lamella.model import Model

PARTS = {
    "factorisation": ("front_kernels.py", "factorise"),
    "solution": ("multifrontal.py", "solve"),
    "element tangents": ("kernels.py", "force_tangent"),
    "element forces": ("kernels.py", "force"),
    "sums and mass": ("operator.py", "into"),
    "recording": ("result.py", "sample"),
}
INTEGRATOR = lm.GeneralizedAlpha(dt=1e-3, rho_inf=0.9)


def model(strain: str) -> Model:
    return read_model(example("solar-array").model, [f"system.p{k}.strain={strain}" for k in range(1, 5)]).system.compile()


def shares(compiled: Model, seconds: float) -> dict[str, float]:
    """Parts of a run's time [%], as a profiler sees them."""
    profile = cProfile.Profile()
    profile.runcall(lm.simulate, compiled, seconds, INTEGRATOR)
    stats = pstats.Stats(profile)
    rows = {(path.rsplit("/", 1)[-1], name): row for (path, _, name), row in stats.stats.items()}  # pyright: ignore
    return {part: 100.0 * rows[key][3] / stats.total_tt for part, key in PARTS.items() if key in rows}  # pyright: ignore


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=0.3, help="time computed [s]")
    seconds = parser.parse_args().seconds
    print(f"{'panels':8} {'ms a step':>10} {'iterations':>11} {'factorisations':>15}")
    for strain in ("exact", "rigid"):
        compiled = model(strain)
        lm.simulate(compiled, 5e-3, INTEGRATOR)  # compiles what is not in the cache
        times, counts = [], None
        for _ in range(2):
            start = time.process_time()
            counts = lm.simulate(compiled, seconds, INTEGRATOR).statistics
            times.append(time.process_time() - start - counts.seconds_compile)
        assert counts is not None
        iterations, factorisations = counts.newton_iterations / counts.steps, counts.factorisations / counts.steps
        print(f"{strain:8} {min(times) / counts.steps * 1e3:10.2f} {iterations:11.2f} {factorisations:15.2f}")
    print("\nwhere the time of exact panels goes [%]")
    for part, share in shares(model("exact"), seconds).items():
        print(f"  {part:18} {share:5.1f}")


if __name__ == "__main__":
    main()
