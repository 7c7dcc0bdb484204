"""Worker processes: forked from one that has imported what runs need, or each started on its own where that is not done.

Nothing heavy is imported here, so that the start can come before everything else, and run beside it.
"""

from __future__ import annotations

import gc
import multiprocessing
import os
import signal
import sys
import threading
from collections.abc import Callable, Generator
from contextlib import contextmanager, suppress
from multiprocessing import reduction, resource_tracker
from multiprocessing.connection import Connection, Pipe
from multiprocessing.connection import wait as wait_for
from typing import Any, Protocol

ONE_THREAD: dict[str, str] = dict.fromkeys(
    ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS", "LAMELLA_THREADS"), "1"
)
"""Environment of workers: with a process for each core, threads within them only get in each other's way."""


class Source(Protocol):
    """Where worker processes come from."""

    def worker(self) -> Connection:
        """A new process that does :func:`work`, by the connection to it; it takes tasks at once, which wait for its start."""
        ...

    def end(self) -> None:
        """No more are wanted, and those there are may end; they are not waited for."""


class Forks:
    """A process that imports what a run needs, once, and is forked into workers. It computes nothing and has one thread.

    When it has ended, or has threads from what the user's script imports, workers start on their own.
    """

    def __init__(self) -> None:
        self._used = False
        self._control, other = Pipe()
        self._process = _spawned(serve_forks, other)

    def worker(self) -> Connection:
        own, other = Pipe()
        try:
            reduction.send_handle(self._control, other.fileno(), self._process.pid)
        except OSError:  # it has ended
            _spawned(work, other)
        else:
            self._used = True
            other.close()
        return own

    def end(self) -> None:
        self._control.close()
        if not self._used:  # it may not have come so far as to notice
            self._process.terminate()


class Spawns:
    """Workers that are started on their own: systems other than Linux have libraries that do not bear to be forked."""

    def worker(self) -> Connection:
        own, other = Pipe()
        _spawned(work, other)
        return own

    def end(self) -> None:
        pass


_early: list[Source] = []


def begin() -> Source:
    """A source of workers, which starts while the caller goes on."""
    if _early:
        return _early.pop()
    return Forks() if sys.platform == "linux" else Spawns()


@contextmanager
def begun() -> Generator[None, None, None]:
    """Within, the next source has its start behind it, or is on its way."""
    _early.append(begin())
    try:
        yield
    finally:
        while _early:
            _early.pop().end()


def serve_forks(control: Connection, allocations: int) -> None:
    """Fork a worker for each connection that comes, until no more can come; then end them all."""
    _leave_interrupts()
    gc.disable()
    from lamella.sweep.task import import_all

    import_all()
    gc.freeze()  # what is there stays: to look through it for garbage would take a tenth of the time, and copy shared memory
    gc.enable()
    if len(os.listdir("/proc/self/task")) > 1:  # a fork would leave locked what another thread holds
        return
    workers: list[int] = []
    while (connection := _received(control)) is not None:
        worker = os.fork()
        if worker == 0:
            control.close()
            work(connection, allocations)
            return
        connection.close()
        workers.append(worker)
    for worker in workers:
        os.kill(worker, signal.SIGTERM)
        os.waitpid(worker, 0)


def _received(control: Connection) -> Connection | None:
    try:
        return Connection(reduction.recv_handle(control))
    except (EOFError, OSError):
        return None


def work(connection: Connection, allocations: int) -> None:
    """Say the process's number, and then do tasks, until the other end is closed or the study's process has ended.

    Args:
        connection: from which tasks come and to which rows go.
        allocations: after which garbage is collected, as in the study's process.
    """
    _leave_interrupts()
    gc.set_threshold(allocations)
    from lamella.sweep.task import Row, run_task

    parent = multiprocessing.parent_process()
    assert parent is not None
    threading.Thread(target=_end_with, args=(parent.sentinel,), daemon=True).start()
    with suppress(EOFError, OSError):
        connection.send(os.getpid())
        while True:
            task = connection.recv()
            try:
                row = run_task(task)
            except Exception as error:  # noqa: BLE001  # of a run alone: the others go on
                row = Row(task.number, "failed", message=f"{type(error).__name__}: {error}")
            connection.send(row)


def _spawned(target: Callable[[Connection, int], None], connection: Connection) -> Any:
    """A new process with one end of a pipe, in the environment of workers."""
    process = multiprocessing.get_context("spawn").Process(target=target, args=(connection, gc.get_threshold()[0]), daemon=True)
    before = {name: os.environ.get(name) for name in ONE_THREAD}
    os.environ.update(ONE_THREAD)
    with _no_interrupts():  # nor in the new process, until it leaves them to this one
        try:
            process.start()
        finally:
            for name, value in before.items():
                if value is None:
                    os.environ.pop(name, None)
                else:
                    os.environ[name] = value
            connection.close()
    return process


@contextmanager
def _no_interrupts() -> Generator[None, None, None]:
    """Ctrl-C waits, also for processes that are started meanwhile."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    resource_tracker.ensure_running()  # which would let Ctrl-C through again when it is started within
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _leave_interrupts() -> None:
    """Leave Ctrl-C to the study's own process."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if hasattr(signal, "pthread_sigmask"):
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})


def _end_with(sentinel: int) -> None:
    wait_for([sentinel])
    os._exit(1)
