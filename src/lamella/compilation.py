"""Shows the first compilation of kernels while it goes on: a line that moves on a terminal, a few plain lines elsewhere."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from contextlib import AbstractContextManager, contextmanager, nullcontext
from typing import TYPE_CHECKING, Any, TextIO

from lamella import progress

if TYPE_CHECKING:
    from collections.abc import Iterator

BETWEEN_LINES = 4.0
"""Least time between two plain lines [s]."""

Say = Callable[[str], None]


def compilation_notice(shown: bool, say: Say | None = None, stream: TextIO | None = None) -> AbstractContextManager[None]:
    """A context within which the compilation of kernels is shown; with compiled kernels nothing is.

    Args:
        shown: show it on ``stream``, as a line that moves if that is a terminal.
        say: takes plain lines instead, where there is no terminal.
        stream: where to write, standard error by default.
    """
    to = stream or sys.stderr
    if shown and to.isatty():
        return _shown(Compilation(stream=to))
    if say is None and not shown:
        return nullcontext()
    return _shown(Compilation(say or (lambda text: print(text, file=to, flush=True))))


@contextmanager
def _shown(compilation: Compilation) -> Iterator[None]:
    from lamella._jit import watched  # imported late: Numba takes most of a second

    try:
        with watched(compilation):
            yield
    finally:
        compilation.close()


class Compilation:
    """Counts kernels that are compiled and shows which one is, how many are done and since when. See :class:`lamella._jit.Watch`.

    How many there will be is not known before a model has been solved, so neither is the time to go.

    Args:
        say: takes plain lines.
        stream: a terminal for a line that moves.
    """

    def __init__(self, say: Say | None = None, stream: TextIO | None = None) -> None:
        self._say, self._stream = say, stream
        self.done, self.seconds, self._name = 0, 0.0, ""
        self._begun = self._said = 0.0
        self._line: Any = None
        self._spinner: Any = None

    def begin(self, name: str) -> None:
        """Show the kernel that is compiled."""
        self._name, self._begun = name, time.monotonic()
        if self._say is not None:
            if not self._said:
                self._say("compiling kernels (first run only, 10 to 20 s) ...")
                self._said = self._begun
            elif self._begun - self._said >= BETWEEN_LINES:
                self._said = self._begun
                self._say(self.text())
        elif progress.SHOWN:
            progress.SHOWN[-1].note(f"compiling {name}, {self.done} done")
        else:
            self._start_line()

    def end(self) -> None:
        """Count it."""
        if self._line is not None:
            self._line.stop()
            self._line = None
        elif self._say is None and progress.SHOWN:
            progress.SHOWN[-1].note("")
        self.seconds += time.monotonic() - self._begun
        self.done += 1

    def close(self) -> None:
        """Say how many there were."""
        if self.done:
            text = f"compiled {self.done} kernel{'s' if self.done > 1 else ''} in {self.seconds:.1f} s"
            if self._say is not None:
                self._say(text)
            else:
                print(text, file=self._stream, flush=True)

    def text(self) -> str:
        """How many are done, which one is compiled, and since when."""
        elapsed = self.seconds + time.monotonic() - self._begun
        return f"first run: {self.done} kernels compiled in {elapsed:.0f} s, now {self._name}"

    def _start_line(self) -> None:
        """A line that a thread of its own draws again and again, and that is gone when the kernel is compiled."""
        from rich.console import Console  # imported late, as in progress
        from rich.live import Live
        from rich.spinner import Spinner

        self._spinner = self._spinner or Spinner("dots")
        console = Console(file=self._stream)
        self._line = Live(get_renderable=self._drawn, console=console, transient=True, refresh_per_second=8)
        self._line.start()

    def _drawn(self) -> Any:
        self._spinner.update(text=self.text())
        return self._spinner
