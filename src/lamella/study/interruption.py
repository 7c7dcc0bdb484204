"""Ctrl-C between two samples: a solution is never interrupted while one is being recorded or written."""

from __future__ import annotations

import signal
import threading
from collections.abc import Sequence
from types import FrameType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from lamella.result import Outcome, Statistics
    from lamella.roles import Floats
    from lamella.state import State


class Interruption:
    """A sink that turns Ctrl-C into a ``KeyboardInterrupt`` after the next sample.

    It stands last, so the others have that sample. A second Ctrl-C interrupts at once. Before the first sample, while kernels may
    be compiled, and after the end, Ctrl-C is as usual.
    """

    def __init__(self) -> None:
        self._asked, self._installed = False, False
        self._before: Any = None

    def sample(self, at: float, values: Sequence[Floats]) -> None:
        """Raise if the user has asked for it.

        Raises:
            KeyboardInterrupt: Ctrl-C was pressed since the last sample.
        """
        if not self._installed and threading.current_thread() is threading.main_thread():
            self._installed, self._before = True, signal.signal(signal.SIGINT, self._ask)
        if self._asked:
            self._restore()
            raise KeyboardInterrupt

    def frame(self, at: float, state: State) -> None:
        """Nothing is done for a frame."""

    def close(self, outcome: Outcome, statistics: Statistics) -> None:
        """Give Ctrl-C its usual meaning back."""
        self._restore()

    def _ask(self, number: int, frame: FrameType | None) -> None:
        self._asked = True
        self._restore()

    def _restore(self) -> None:
        if self._before is not None:
            signal.signal(signal.SIGINT, self._before)
            self._before = None
