"""Runs on the cores of this machine: one process for each, so that it is known which run a process dies of."""

from __future__ import annotations

import gc
import multiprocessing
import os
import signal
import threading
from collections import Counter, deque
from collections.abc import Callable, Generator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import suppress
from multiprocessing.connection import wait as wait_for
from typing import Any

from lamella import threads
from lamella.errors import WorkerError
from lamella.sweep.task import Row, Task, ready, run_task

ATTEMPTS = 3
"""Times a run is tried whose worker dies."""

ONE_THREAD: dict[str, str] = dict.fromkeys(
    ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS", threads.VARIABLE), "1"
)
"""Environment of workers: with a process for each core, threads within them only get in each other's way."""

HINT = (
    "the worker processes end before their first run; a script that runs a study must do so below "
    "'if __name__ == \"__main__\":', since each worker imports it"
)


class Worker:
    """A process that runs one task at a time, and is replaced when it dies."""

    def __init__(self) -> None:
        self._start()

    def wait_ready(self) -> None:
        """Wait until the process has imported what it needs.

        Raises:
            WorkerError: it ended before, and so did those put in its place.
        """
        for _ in range(ATTEMPTS):
            if self._first.exception() is None:
                return
            self._start()
        raise WorkerError(HINT)

    def submit(self, task: Task) -> Future[Row]:
        """Start a task."""
        try:
            return self._pool.submit(run_task, task)
        except BrokenProcessPool:  # it died while it had nothing to do
            self.replace()
            return self._pool.submit(run_task, task)

    def replace(self) -> None:
        """Put a new process in the place of a dead one; it takes tasks at once, which wait for its start."""
        self.end()
        self._start()

    def end(self) -> None:
        """End the process, whatever it is doing."""
        self._pool.shutdown(wait=False, cancel_futures=True)
        if self._first.done() and not self._first.cancelled() and self._first.exception() is None:
            with suppress(ProcessLookupError, PermissionError):
                os.kill(self._first.result(), signal.SIGTERM)

    def _start(self) -> None:
        self._pool = ProcessPoolExecutor(1, multiprocessing.get_context("spawn"), _prepare, gc.get_threshold()[:1])
        self._first = self._pool.submit(ready)


class LocalWorkers:
    """The cores of this machine, as a context.

    Args:
        count: number of worker processes.
        say: takes a line for each worker that dies.
    """

    def __init__(self, count: int, say: Callable[[str], None]) -> None:
        self.count, self.say = count, say
        self._workers: list[Worker] = []

    def __enter__(self) -> LocalWorkers:
        self._before = {name: os.environ.get(name) for name in ONE_THREAD}
        os.environ.update(ONE_THREAD)  # inherited by the processes started within
        try:
            self._workers = [Worker() for _ in range(self.count)]
            for worker in self._workers:
                worker.wait_ready()
        except BaseException:
            self.__exit__()
            raise
        return self

    def __exit__(self, *_: Any) -> None:
        for worker in self._workers:
            worker.end()
        for name, value in self._before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value

    def run(self, tasks: Sequence[Task]) -> Generator[Row, None, None]:
        """Run tasks, a few at a time; rows come in the order in which they are finished."""
        waiting, tries = deque(tasks), Counter[int]()
        running: dict[Future[Row], tuple[Worker, Task]] = {}
        idle = list(self._workers)
        ended: list[Row] = []
        while waiting or running:
            while idle and waiting:  # before rows are dealt with: workers do not wait for the disk
                worker, task = idle.pop(), waiting.popleft()
                running[worker.submit(task)] = worker, task
            yield from ended
            ended = []
            for future in wait(running, return_when=FIRST_COMPLETED).done:
                worker, task = running.pop(future)
                error = future.exception()
                if isinstance(error, BrokenProcessPool):
                    tries[task.number] += 1
                    again = tries[task.number] < ATTEMPTS
                    self.say(f"run {task.number}: its worker process ended; {'it is run again' if again else 'given up'}")
                    worker.replace()
                    if again:
                        waiting.appendleft(task)
                    else:
                        ended.append(Row(task.number, "lost", message=f"its worker process ended, {ATTEMPTS} times"))
                elif error is not None:
                    ended.append(Row(task.number, "failed", message=f"{type(error).__name__}: {error}"))
                else:
                    ended.append(future.result())
                idle.append(worker)
        yield from ended


def _prepare(allocations: int) -> None:
    """In a new worker: leave Ctrl-C to the study's own process, end when that one has ended, and collect garbage as it does."""
    gc.set_threshold(allocations)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = multiprocessing.parent_process()
    assert parent is not None
    threading.Thread(target=_end_with, args=(parent.sentinel,), daemon=True).start()


def _end_with(sentinel: int) -> None:
    wait_for([sentinel])
    os._exit(1)
