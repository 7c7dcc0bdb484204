"""CPU time of calls and of other programs."""

from __future__ import annotations

import os
import statistics
import subprocess
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TypeVar

T = TypeVar("T")
ENOUGH = 10.0
"""Seconds after which a piece of work is not repeated any more."""

ONE_THREAD: dict[str, str] = dict.fromkeys(
    ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "CCX_NPROC_EQUATION_SOLVER", "LAMELLA_THREADS"), "1"
)
"""Environment in which the libraries of linear algebra, and CalculiX, use one core; read when they are loaded."""


def median(measure: Callable[[], tuple[float, T]], runs: int) -> tuple[float, T]:
    """Median of what ``measure`` gives as its first value, and its second value of the last run.

    Args:
        measure: gives a time [s] and a result.
        runs: how often, unless the runs take longer than :data:`ENOUGH` together.
    """
    times, result = [], None
    while not times or (len(times) < runs and sum(times) < ENOUGH):
        seconds, result = measure()
        times.append(seconds)
    assert result is not None
    return statistics.median(times), result


def cpu(call: Callable[[], T]) -> tuple[float, T]:
    """CPU time of a call [s] and what it returns."""
    start = time.process_time()
    result = call()
    return time.process_time() - start, result


def a_step(move: Callable[[int], T], steps: int, runs: int) -> tuple[float, T]:
    """Median of the CPU time of one step of a motion [s], and what the whole run of ``steps`` returns.

    The start, which differs between codes, falls out of the difference to a run of a tenth of the steps.

    Args:
        move: computes so many steps.
        steps: of the long run.
        runs: how often each is done.
    """
    return a_step_of(lambda count: cpu(lambda: move(count)), steps, runs)


def a_step_of(measure: Callable[[int], tuple[float, T]], steps: int, runs: int) -> tuple[float, T]:
    """The same for a program that tells its own time: ``measure`` gives the time of so many steps [s] and their result."""
    few = max(steps // 10, 1)
    short, _ = median(lambda: measure(few), runs)
    long, result = median(lambda: measure(steps), runs)
    return (long - short) / (steps - few), result


def cpu_of_program(command: Sequence[str], folder: Path) -> tuple[float, subprocess.CompletedProcess[str]]:
    """CPU time of another program and those it starts [s], user and system, with one thread; POSIX alone knows it."""
    import resource

    def spent() -> float:
        usage = resource.getrusage(resource.RUSAGE_CHILDREN)
        return usage.ru_utime + usage.ru_stime

    start = spent()
    done = subprocess.run(command, cwd=folder, env=os.environ | ONE_THREAD, capture_output=True, text=True, check=False)
    return spent() - start, done


def best(call: Callable[[], object], seconds: float = 0.2) -> float:
    """Shortest time of a short call [s], repeated for about ``seconds`` and at least three times.

    The shortest of many is what the processor needs; a median of calls this short tells more about its other work.
    """
    times: list[float] = []
    while len(times) < 3 or sum(times) < seconds:
        start = time.perf_counter()
        call()
        times.append(time.perf_counter() - start)
    return min(times)
