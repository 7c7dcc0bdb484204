"""Work in threads: how many there are, and how a piece of work is cut among them.

Kernels that are declared ``shared`` run side by side. Each piece of work writes to places of its own, in
the order in which one thread would write them, so that results are the same to the last bit for any number of threads.
"""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Sequence
from queue import SimpleQueue
from typing import TypeVar

from lamella.errors import ModelError
from lamella.lane import aligned
from lamella.roles import Floats

T = TypeVar("T")

VARIABLE = "LAMELLA_THREADS"
"""Environment variable with the number of threads."""
DEFAULT = 1
"""Threads that are used unless another number is asked for: on cores that have other work a second one may cost time."""
WORTHWHILE = 8e-4
"""Seconds of work, by the estimates of those who do it, from which it is cut: to hand it out and to wait for it takes some 40 us,
more on a busy machine."""
SHORTEST = 2e-4
"""Seconds that a piece should take at least."""
PIECES = 4
"""Pieces for each thread, so that one which is late is left with less of them."""

_chosen: int | None = None
_helpers: Helpers | None = None


class Share:
    """Work that is handed to a helper, who begins it unless it is taken back before."""

    def __init__(self, work: Callable[[], None]) -> None:
        self._work, self._done = work, threading.Lock()
        self._claim = iter((True,))  # whoever takes its only item has the share
        self._done.acquire()
        self.error: BaseException | None = None

    def begin(self) -> None:
        """Do the work, if it has not been taken back."""
        if next(self._claim, False):
            try:
                self._work()
            except BaseException as error:  # noqa: BLE001 - raised again by the thread that handed it out
                self.error = error
            self._done.release()

    def end(self) -> None:
        """Take the work back where it has not begun, else wait for its end."""
        if not next(self._claim, False):
            self._done.acquire()


class Helpers:
    """Threads that wait for shares of work. An executor of Python's library takes 10 us more until both threads are at work.

    Args:
        count: of the threads.
    """

    def __init__(self, count: int) -> None:
        self._shares: SimpleQueue[Share | None] = SimpleQueue()
        self._threads = [threading.Thread(target=self._help, name=f"lamella_{i}", daemon=True) for i in range(count)]
        for thread in self._threads:
            thread.start()

    def _help(self) -> None:
        while (share := self._shares.get()) is not None:
            share.begin()

    def hand(self, work: Callable[[], None]) -> Share:
        """Hand work to the thread that is free first."""
        share = Share(work)
        self._shares.put(share)
        return share

    def dismiss(self) -> None:
        """Let the threads end after what they have begun."""
        for _ in self._threads:
            self._shares.put(None)


def cores() -> int:
    """Number of cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def number() -> int:
    """Number of threads: that of :func:`use`, else of the environment, else one.

    Raises:
        ModelError: the environment asks for what is no number of threads.
    """
    if _chosen is None:
        text = os.environ.get(VARIABLE, "")
        use(_read(text) if text else DEFAULT)
    assert _chosen is not None
    return _chosen


def use(count: int | None) -> None:
    """Use so many threads from now on, 1 for none beside the calling one; None: what the environment says.

    Raises:
        ModelError: the number is not positive.
    """
    global _chosen
    if count is not None and count < 1:
        raise ModelError(f"threads: {count} is not accepted; choose a whole number from 1")
    _dismiss()
    _chosen = count


def _read(text: str) -> int:
    if not text.isascii() or not text.isdigit() or int(text) < 1:
        raise ModelError(f"{VARIABLE} = '{text}' is not accepted; choose a whole number from 1, or leave it out")
    return int(text)


def _dismiss() -> None:
    global _helpers
    if _helpers is not None:
        _helpers.dismiss()
    _helpers = None


def _lose() -> None:
    """In a process that was forked, which has none of its threads."""
    global _helpers
    _helpers = None


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_lose)


def run(calls: Sequence[Callable[[], T]], *, worthwhile: bool = True) -> list[T]:
    """Make all calls, the longest of which should come first, and return what they return.

    Each thread, the calling one too, takes the next call that no other has begun, so that none waits while there is work. The
    calling thread waits for no other that has not begun. Without ``worthwhile`` it makes them all.
    """
    global _helpers
    if not worthwhile or number() == 1 or len(calls) < 2:
        return [call() for call in calls]
    if _helpers is None:
        _helpers = Helpers(number() - 1)
    found: dict[int, T] = {}
    left = iter(range(len(calls)))

    def work() -> None:
        for i in left:
            found[i] = calls[i]()

    shares = [_helpers.hand(work) for _ in range(min(number(), len(calls)) - 1)]
    try:
        work()
    finally:  # also after an error: what they write to may be used for something else
        for _ in left:
            pass
        for share in shares:
            share.end()
    for share in shares:
        if share.error is not None:
            raise share.error
    return [found[i] for i in range(len(calls))]


def cut(n: int, seconds: float) -> list[tuple[int, int]]:
    """Ranges (first, end) of n things that take so many seconds each, one range where threads would not pay.

    Their number is a multiple of that of the threads: of five like pieces one of two threads would have three.
    """
    total, count = n * seconds, number()
    if count == 1 or total < WORTHWHILE:
        return [(0, n)]
    pieces = min(n, count * max(1, min(PIECES, int(total / (count * SHORTEST)))))
    return [(n * i // pieces, n * (i + 1) // pieces) for i in range(pieces)]


class Workspace(threading.local):
    """Work space of kernels, for each thread its own.

    Args:
        size: numbers.

    Attributes:
        array: that of the thread that asks, flat and aligned.
    """

    def __init__(self, size: int) -> None:
        self.array: Floats = aligned(size)

    def __reduce__(self) -> tuple[type[Workspace], tuple[int]]:
        return Workspace, (len(self.array),)
