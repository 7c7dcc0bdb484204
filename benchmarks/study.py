"""A parameter study on worker processes against the same runs one after another: is the start of the workers paid back?

    python benchmarks/study.py [--runs 200] [--workers 2] [--steps 600]

A strip swings for some steps, with another thickness in each run. The serial time is that of the runs alone, in this process,
with kernels loaded; that of the study includes the start of its workers, their loading of kernels, and all writing. The aim is a
ratio of the study's time to (serial time / workers) of at most 1.15.
"""

from __future__ import annotations

import argparse
import os
import tempfile
import time
from pathlib import Path

import lamella as lm
from lamella.sweep.study import StudyFile
from lamella.sweep.task import Task, run_task

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


def study(model: Path, runs: int, workers: int, steps: int) -> lm.ParameterStudy:
    return lm.ParameterStudy(
        str(model),
        {"thickness": lm.Parameter("system.strip.laminate.thickness", range=("1 mm", "3 mm"), count=runs)},
        lm.GridDesign(),
        {"deflection": lm.SignalOutput("tip.position", component="z", statistic="min")},
        set=(f"analysis.swing.t_end={steps} ms",),
        workers=workers,
    )


def processor_seconds() -> float:
    """Time of processors used by this process and by those it has started and that have ended [s]."""
    spent = os.times()
    return spent.user + spent.system + spent.children_user + spent.children_system


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=200)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--steps", type=int, default=600, help="steps of each run")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        model = Path(folder) / "strip.yaml"
        model.write_text(MODEL)
        chosen = study(model, given.runs, given.workers, given.steps)
        checked = StudyFile(chosen).checked()
        rows = enumerate(chosen.rows(), start=1)
        tasks = [Task(k, checked.text, "strip", Path(folder), chosen.settings(row), chosen.outputs) for k, row in rows]
        run_task(tasks[0])  # loads or compiles kernels
        before = os.getloadavg()[0]
        start, used = time.perf_counter(), processor_seconds()
        serial_rows = [run_task(task) for task in tasks]
        serial, serial_used = time.perf_counter() - start, processor_seconds() - used
        start, used = time.perf_counter(), processor_seconds()
        result = lm.run_parameter_study(chosen, Path(folder) / "out", pictures=False)
        parallel = time.perf_counter() - start
        time.sleep(1.0)  # the workers have ended, and their time is counted
        parallel_used = processor_seconds() - used
    assert [row.values for row in serial_rows] == [row.values for row in result.rows], "the runs differ"
    aim = 1.15
    ratio = parallel / (serial / given.workers)
    load = f"load average before {before:.1f}, behind {os.getloadavg()[0]:.1f}"
    print(f"{given.runs} runs of {given.steps} steps, {serial / given.runs:.3f} s each; {load}")
    print(f"one after another {serial:.1f} s; study on {given.workers} workers {parallel:.1f} s, start and writing included")
    print(f"study / (serial / {given.workers}) = {ratio:.3f}; the aim is at most {aim}: {'met' if ratio <= aim else 'MISSED'}")
    share = parallel_used / serial_used
    print(f"processors' time, which other programs disturb less: {parallel_used:.1f} s against {serial_used:.1f} s, {share:.3f}")


if __name__ == "__main__":
    main()
