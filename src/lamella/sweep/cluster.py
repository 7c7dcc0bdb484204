"""Runs on a Dask cluster that is there already, given by the address of its scheduler."""

from __future__ import annotations

import logging
from collections.abc import Callable, Generator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, wait
from contextlib import suppress
from typing import Any

from lamella import __version__, threads
from lamella.errors import MissingExtraError, WorkerError
from lamella.sweep.task import Row, Task, run_task

TIMEOUT = 10.0
"""Seconds in which a scheduler must answer."""

FROZEN = 60.0
"""Seconds in which it must answer when it has answered before: it may have a lot to do."""

PATIENCE = 15.0
"""Seconds without a finished run after which it is asked whether there are workers."""


def _run_alone(task: Task) -> Row:
    """A run on one thread, in a worker, which has neighbours on its machine."""
    threads.use(1)
    return run_task(task)


class ClusterWorkers:
    """The workers of a Dask cluster, as a context. Dask gives the runs of a worker that dies to others.

    Args:
        address: of the scheduler, such as ``tcp://10.0.0.1:8786``.
        say: takes a line, such as that there is no worker yet.

    Raises:
        MissingExtraError: Dask is not installed.
    """

    def __init__(self, address: str, say: Callable[[str], None]) -> None:
        try:
            import distributed
        except ImportError as error:
            raise MissingExtraError("a study on a cluster needs Dask: pip install 'lamella[cluster]'") from error
        self._dask, self.address, self.say = distributed, address, say
        self._client: Any = None

    def __enter__(self) -> ClusterWorkers:
        log = logging.getLogger("distributed.client")
        self._level = log.level
        log.setLevel(logging.CRITICAL)  # what it would say of lost connections is said here, once
        try:
            self._dask.comm.resolve_address(self.address)  # a client made with an impossible address cannot be closed
            if self.address.startswith("tls:") and not self._dask.Security().get_connection_args("client")["ssl_context"]:
                raise ValueError("the configuration of Dask has no certificates for TLS")
            self._client = self._dask.Client(self.address, timeout=TIMEOUT, set_as_default=False)
        except (OSError, ValueError, ImportError) as error:
            log.setLevel(self._level)
            raise WorkerError(
                f"the cluster '{self.address}' cannot be reached within {TIMEOUT:g} s ({_first_line(error)}); "
                "accepted is the address of a running scheduler of Dask, such as tcp://127.0.0.1:8786"
            ) from error
        return self

    def __exit__(self, *_: Any) -> None:
        with suppress(OSError):  # one that answers no more
            self._client.close(timeout=TIMEOUT)
        logging.getLogger("distributed.client").setLevel(self._level)

    def run(self, tasks: Sequence[Task]) -> Generator[Row, None, None]:
        """Run tasks; rows come in the order in which they are finished. Those under way are cancelled when no more are asked for.

        Raises:
            WorkerError: the cluster was lost, or its workers have no or another lamella.
        """
        executor = self._client.get_executor(pure=False)
        running: dict[Future[Row], Task] = {executor.submit(_run_alone, task): task for task in tasks}
        try:
            while running:
                done = wait(running, timeout=PATIENCE, return_when=FIRST_COMPLETED).done
                if not done:
                    self._check_workers()
                for future in done:
                    yield self._row(future, running.pop(future))
        finally:
            if running and self._client.status == "running":
                for future in running:
                    future.cancel()

    def _row(self, future: Future[Row], task: Task) -> Row:
        if future.cancelled():  # not by us: Dask cancels what it has lost the scheduler of
            raise self._lost()
        error = future.exception()
        if error is None:
            row = future.result()
            if row.version != __version__:
                raise WorkerError(
                    f"the cluster '{self.address}' has lamella {row.version}, here is {__version__}; accepted is the same on both"
                )
            return row
        if isinstance(error, self._dask.scheduler.KilledWorker):
            return Row(task.number, "lost", message="the workers it ran on ended, too often")
        if isinstance(error, self._dask.client.FutureCancelledError):
            raise self._lost() from error
        if isinstance(error, ImportError) or isinstance(error.__cause__, ImportError):
            raise WorkerError(
                f"the cluster '{self.address}' cannot run lamella ({_first_line(error.__cause__ or error)}); "
                "its scheduler and its workers need it installed, as it is here"
            ) from error
        return Row(task.number, "failed", message=f"{type(error).__name__}: {_first_line(error)}")

    def _check_workers(self) -> None:
        if self._client.status != "running":
            raise self._lost()
        try:
            if not self._client.sync(self._client.scheduler.ncores, callback_timeout=FROZEN):
                self.say(f"the cluster '{self.address}' has no worker yet; waiting")
        except (OSError, RuntimeError, ValueError) as error:
            raise self._lost() from error

    def _lost(self) -> WorkerError:
        return WorkerError(f"the cluster '{self.address}' was lost")


def _first_line(error: BaseException) -> str:
    return (str(error).splitlines() or [""])[0] or type(error).__name__
