"""A progress display for solutions: a bar on a terminal, a few plain lines elsewhere."""

from __future__ import annotations

import sys
import time
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, TextIO

if TYPE_CHECKING:
    from lamella.result import Outcome, Statistics
    from lamella.roles import Floats
    from lamella.state import State

INTERVAL = 0.1
"""Shortest time between two updates [s]: drawing must cost nothing beside a step of a millisecond."""

LINES = 10
"""Plain lines over the whole way."""


SHOWN: list[ProgressBar | CountBar] = []
"""Bars on the terminal now, the last one below the others."""


def rich_bar(label: str, stream: TextIO) -> tuple[Any, Any]:
    """A started bar on a terminal and its task, whose ``completed`` goes from 0 to 1."""
    from rich.console import Console  # imported late: 0.1 s that a quiet run never needs
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

    columns = (
        TextColumn("{task.description}"),
        BarColumn(bar_width=30),
        TextColumn("{task.percentage:>3.0f} %  {task.fields[text]}"),
        TimeElapsedColumn(),
        TextColumn("to go"),
        TimeRemainingColumn(),
    )
    bar = Progress(*columns, console=Console(file=stream), transient=False, refresh_per_second=8)
    bar.start()
    return bar, bar.add_task(label, total=1.0, text="")


class ProgressBar:
    """Shows how far a solution is, the time to go, its step size and its Newton iterations; it is a recorder's sink.

    Args:
        label: what is solved, for example ``motion``.
        start: axis value at the start.
        end: axis value at the end.
        unit: unit of the axis, for example ``s``; empty for a load factor.
        statistics: counts that the solution keeps up to date; shown when given.
        stream: where to write, standard error by default.
    """

    def __init__(
        self,
        label: str,
        start: float,
        end: float,
        unit: str = "s",
        statistics: Statistics | None = None,
        stream: TextIO | None = None,
    ) -> None:
        self.label, self.start, self.end, self.unit, self.statistics = label, start, end, unit, statistics
        self._stream = stream or sys.stderr
        self._at = start
        self._step = 0.0
        self._begun: float | None = None
        self._shown = 0.0
        self._lines = 0
        self._bar, self._task = rich_bar(label, self._stream) if self._stream.isatty() else (None, None)
        if self._bar is not None:
            SHOWN.append(self)

    def sample(self, at: float, values: Sequence[Floats]) -> None:
        """Show the axis value reached; the clock starts after the first step, since that one may wait for compilation."""
        now = time.monotonic()
        if at != self.start and self._begun is None:
            self._begun = now
        self._step, self._at = at - self._at, at
        if self._begun is None or now - self._shown < INTERVAL:
            return
        self._shown = now
        if self._bar is not None:
            self._bar.update(self._task, completed=self.share, text=self.text())
        elif (lines := int(self.share * LINES + 1e-9)) > self._lines:
            self._lines = lines
            elapsed = self._elapsed()
            to_go = elapsed * (1.0 / self.share - 1.0)
            print(
                f"{self.label}: {100 * self.share:3.0f} %, {self.text()}, {elapsed:.0f} s, {to_go:.0f} s to go", file=self._stream
            )

    def frame(self, at: float, state: State) -> None:
        """Nothing is drawn for a frame."""

    def close(self, outcome: Outcome, statistics: Statistics) -> None:
        """Show how the solution ended."""
        self.statistics, self._at = statistics, outcome.reached
        if self._bar is not None:
            self._bar.update(self._task, completed=self.share, text=self.text())
            self._bar.stop()
            SHOWN.remove(self)
        print(f"{self.label}: {outcome}, {self.text()}, {self._elapsed():.1f} s", file=self._stream)

    def note(self, text: str) -> None:
        """Say what is waited for, on a terminal, until the next step."""
        if self._bar is not None:
            self._bar.update(self._task, text=text)

    def _elapsed(self) -> float:
        """Seconds since the first step."""
        return 0.0 if self._begun is None else time.monotonic() - self._begun

    @property
    def share(self) -> float:
        """Share of the way that is done, 0 to 1."""
        way = self.end - self.start
        return min(max((self._at - self.start) / way, 0.0), 1.0) if way else 1.0

    def text(self) -> str:
        """Axis value, size of the last step, and Newton iterations for each step."""
        unit = f" {self.unit}" if self.unit else ""
        words = [f"{'t = ' if self.unit == 's' else ''}{self._at:.4g}{unit}"]
        if self._step:
            words.append(f"step {abs(self._step):.2g}{unit}")
        if self.statistics is not None and self.statistics.steps:
            words.append(f"{self.statistics.newton_iterations / self.statistics.steps:.1f} iterations a step")
        return ", ".join(words)


class CountBar:
    """Shows how many of a number of things are done and the time to go.

    Args:
        label: what is done, for example ``study``.
        before: number done before the clock starts; they say nothing about the time to go.
        total: number in all.
        what: their name, for example ``runs``.
        stream: where to write, standard error by default.
    """

    def __init__(self, label: str, before: int, total: int, what: str, stream: TextIO | None = None) -> None:
        self.label, self.before, self.total, self.what = label, before, total, what
        self._stream = stream or sys.stderr
        self._done, self._note, self._lines = before, "", 0
        self._begun = time.monotonic()
        self._bar, self._task = rich_bar(label, self._stream) if self._stream.isatty() else (None, None)
        if self._bar is not None:
            SHOWN.append(self)
            self._bar.update(self._task, total=total - before, text=self.text())

    def count(self, done: int, note: str = "") -> None:
        """Show the number done, with a note behind it."""
        self._done, self._note = done, note
        if self._bar is not None:
            self._bar.update(self._task, completed=done - self.before, text=self.text())
        elif (lines := done * LINES // self.total) > max(self._lines, self.before * LINES // self.total):
            self._lines = lines
            elapsed = time.monotonic() - self._begun
            to_go = elapsed * (self.total - done) / (done - self.before)
            print(f"{self.label}: {self.text()}, {elapsed:.0f} s, {to_go:.0f} s to go", file=self._stream, flush=True)

    def note(self, text: str) -> None:
        """Say what is waited for, on a terminal, until one more is done."""
        if self._bar is not None:
            self._bar.update(self._task, text=text or self.text())

    def end(self) -> None:
        """Show how far it got."""
        if self._bar is not None:
            self._bar.stop()
            SHOWN.remove(self)
        print(f"{self.label}: {self.text()}, {time.monotonic() - self._begun:.1f} s", file=self._stream, flush=True)

    def text(self) -> str:
        """The number done of all, and the note."""
        return f"{self._done} of {self.total} {self.what}" + (f", {self._note}" if self._note else "")
