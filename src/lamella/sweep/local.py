"""Runs on the cores of this machine: one process for each, so that it is known which run a process dies of."""

from __future__ import annotations

import os
import signal
from collections import Counter, deque
from collections.abc import Callable, Generator, Sequence
from contextlib import suppress
from multiprocessing.connection import Connection, wait
from typing import Any, cast

from lamella.errors import WorkerError
from lamella.sweep.processes import Source, begin
from lamella.sweep.task import Row, Task

ATTEMPTS = 3
"""Times a run is tried whose worker dies, and times a worker is started that dies before its first run."""

HINT = (
    "the worker processes end before their first run; a script that runs a study must do so below "
    "'if __name__ == \"__main__\":', since each worker imports it"
)


class Died(Exception):  # noqa: N818  # it is no error
    """A worker process has ended by itself."""


class Worker:
    """A process that runs one task at a time, and is replaced when it dies.

    Args:
        source: where processes come from.
    """

    def __init__(self, source: Source) -> None:
        self._source = source
        self._failed_starts = 0
        self._start()

    def _start(self) -> None:
        self._process: int | None = None
        self.connection: Connection = self._source.worker()

    def give(self, task: Task) -> None:
        """Start a task."""
        try:
            self.connection.send(task)
        except OSError:  # it died while it had nothing to do
            self.replace()
            with suppress(OSError):  # so has the new one, as is seen when its row is asked for
                self.connection.send(task)

    def take(self) -> Row | None:
        """The row of its task; None when it has just begun.

        Raises:
            Died: it has ended.
            WorkerError: it ended before its first run, and so did those put in its place.
        """
        try:
            said = self.connection.recv()
        except (EOFError, OSError):
            if self._process is None:
                self._failed_starts += 1
                if self._failed_starts == ATTEMPTS:
                    raise WorkerError(HINT) from None
            raise Died from None
        if isinstance(said, Row):
            return said
        self._process, self._failed_starts = said, 0
        return None

    @property
    def begun(self) -> bool:
        """Whether it was ready for tasks."""
        return self._process is not None

    def replace(self) -> None:
        """Put a new process in the place of a dead one."""
        self.end()
        self._start()

    def end(self) -> None:
        """End the process, whatever it is doing."""
        if self._process is not None:
            with suppress(ProcessLookupError, PermissionError):
                os.kill(self._process, signal.SIGTERM)
        self.connection.close()


class LocalWorkers:
    """The cores of this machine, as a context.

    Args:
        count: largest number of worker processes.
        say: takes a line for each worker that dies.
    """

    def __init__(self, count: int, say: Callable[[str], None]) -> None:
        self.count, self.say = count, say
        self._workers: list[Worker] = []

    def __enter__(self) -> LocalWorkers:
        self._source = begin()
        return self

    def __exit__(self, *_: Any) -> None:
        for worker in self._workers:
            worker.end()
        self._source.end()

    def run(self, tasks: Sequence[Task]) -> Generator[Row, None, None]:
        """Run tasks, one in each worker; rows come in the order in which they are finished.

        Raises:
            WorkerError: no worker can be started.
        """
        waiting, tries = deque(tasks), Counter[int]()
        running: dict[Connection, tuple[Worker, Task]] = {}
        self._workers = [Worker(self._source) for _ in range(min(self.count, len(tasks)))]
        idle = list(self._workers)
        ended: list[Row] = []
        while waiting or running:
            while idle and waiting:  # before rows are dealt with: workers do not wait for the disk
                worker, task = idle.pop(), waiting.popleft()
                worker.give(task)
                running[worker.connection] = worker, task
            yield from ended
            ended = []
            for connection in cast("list[Connection]", wait(list(running))):
                worker, task = running[connection]
                begun = worker.begun
                try:
                    row = worker.take()
                except Died:
                    row = self._row_of_dead(task, tries) if begun else None
                    del running[connection]
                    worker.replace()
                    if row is None:
                        worker.give(task)
                        running[worker.connection] = worker, task
                        continue
                else:
                    if row is None:
                        continue
                    del running[connection]
                ended.append(row)
                idle.append(worker)
        yield from ended

    def _row_of_dead(self, task: Task, tries: Counter[int]) -> Row | None:
        """What is known of a run whose worker has died; None when it is run again."""
        tries[task.number] += 1
        again = tries[task.number] < ATTEMPTS
        self.say(f"run {task.number}: its worker process ended; {'it is run again' if again else 'given up'}")
        return None if again else Row(task.number, "lost", message=f"its worker process ended, {ATTEMPTS} times")
