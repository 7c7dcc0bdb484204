"""A parameter study on worker processes beside the same runs one after another: is the start of the workers paid back?"""

from __future__ import annotations

import multiprocessing
import os
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import lamella as lm
from lamella.bench.row import Row
from lamella.sweep.study import StudyFile
from lamella.sweep.task import Task, run_task

CASE, WORKERS, STEPS = "study", 2, 600
RUNS = 70
"""Runs of the study for each run of the benchmark: some 200 for the default of three."""
MODEL = """\
lamella: 1
system:
  strip:
    type: plate
    size: [1 m, 100 mm]
    mesh: [8, 1]
    laminate: {ply: {type: isotropic, E: 70 GPa, nu: 0.3, rho: 2700}, thickness: 2 mm}
    markers: {tip: [1 m, 50 mm]}
  root: {type: clamp, on: strip.x-}
  load: {type: point_force, on: strip.tip, force: [0, 0, -0.1 N]}
analysis:
  swing: {type: motion, t_end: 1 s, integrator: {dt: 1 ms, rho_inf: 0.9}}
"""


def study(model: Path, count: int) -> lm.ParameterStudy:
    """A strip that swings, with another thickness in each run."""
    return lm.ParameterStudy(
        str(model),
        {"thickness": lm.Parameter("system.strip.laminate.thickness", range=("1 mm", "3 mm"), count=count)},
        lm.GridDesign(),
        {"deflection": lm.SignalOutput("tip.position", component="z", statistic="min")},
        set=(f"analysis.swing.t_end={STEPS} ms",),
        workers=WORKERS,
    )


def run(runs: int) -> Iterator[Row]:
    """Elapsed time of all runs here, over the number of workers; and of the study, with start of its workers and writing."""
    with tempfile.TemporaryDirectory() as folder:
        model = Path(folder) / "strip.yaml"
        model.write_text(MODEL, "utf-8")
        chosen = study(model, RUNS * runs)
        checked = StudyFile(chosen).checked()
        rows = enumerate(chosen.rows(), start=1)
        tasks = [Task(k, checked.text, "strip", Path(folder), chosen.settings(row), chosen.outputs) for k, row in rows]
        run_task(tasks[0])  # loads or compiles kernels
        start, used = time.perf_counter(), _cpu_time()
        for task in tasks:
            run_task(task)
        serial, alone = (time.perf_counter() - start) / WORKERS, _cpu_time() - used
        start, used = time.perf_counter(), _cpu_time()
        lm.run_parameter_study(chosen, Path(folder) / "out", pictures=False)
        parallel, together = time.perf_counter() - start, _cpu_time() - used
    what = f"{len(tasks)} runs of {STEPS} steps"
    load = f"load average at the end {os.getloadavg()[0]:.1f}; CPU time {alone:.3g} s"
    all_cpu = f"CPU time of all processes {together:.3g} s, {together / alone:.3g} of that one after another"
    own = Row(case=CASE, code=f"one after another, over {WORKERS}", what=what, time=serial, unit="s elapsed", note=load)
    yield own
    yield Row(case=CASE, code=f"study on {WORKERS} workers", what=what, time=parallel, unit="s elapsed", note=all_cpu).beside(own)


def _cpu_time() -> float:
    """CPU time of this process and of those it has started and that have ended [s]; others on the machine do not add to it."""
    for child in multiprocessing.active_children():
        child.join()
    used = os.times()
    return used.user + used.system + used.children_user + used.children_system
