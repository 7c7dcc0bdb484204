"""What is shown while kernels are compiled: a line that moves on a terminal, a few plain lines elsewhere."""

from __future__ import annotations

import io
import re

import numba
import pytest

from lamella import compilation, progress
from lamella.compilation import Compilation, compilation_notice
from lamella.progress import ProgressBar
from lamella.result import Cause, Outcome, Statistics


class Terminal(io.StringIO):
    """Takes what is written as a terminal would."""

    def isatty(self) -> bool:
        return True


def compiled() -> None:
    """Compile a kernel that no cache has."""

    def doubled(x):
        return 2.0 * x

    assert numba.njit(doubled)(2.0) == 4.0


def test_plain_lines_are_few_and_say_what_is_compiled(monkeypatch: pytest.MonkeyPatch) -> None:
    now = iter([100.0, 101.0, 101.0, 103.0, 103.5, 103.5, 104.5, 104.5, 106.0])
    monkeypatch.setattr(compilation.time, "monotonic", lambda: next(now))
    said: list[str] = []
    shown = Compilation(said.append)
    for name in ("a.one", "a.two"):
        shown.begin(name)
        shown.end()
    monkeypatch.setattr(compilation, "BETWEEN_LINES", 3.0)
    for name in ("a.three", "a.four"):
        shown.begin(name)
        shown.end()
    shown.close()
    assert said == [
        "compiling kernels (first run only, 10 to 20 s) ...",
        "first run: 2 kernels compiled in 3 s, now a.three",
        "compiled 4 kernels in 5.5 s",
    ]


def test_nothing_is_shown_where_nothing_is_compiled_or_nothing_is_to_be_shown() -> None:
    stream = io.StringIO()
    with compilation_notice(True, stream=stream):
        pass
    with compilation_notice(False, stream=stream):
        compiled()
    assert stream.getvalue() == ""


def test_lines_go_where_they_are_asked_for() -> None:
    said: list[str] = []
    stream = io.StringIO()
    with compilation_notice(False, said.append, stream):
        compiled()
    with compilation_notice(True, stream=stream):
        compiled()
    assert len(said) == len(stream.getvalue().splitlines()) == 2
    assert re.fullmatch(r"compiled 1 kernel in \d+\.\d s", said[-1])


def test_terminal_shows_a_line_that_is_gone_afterwards() -> None:
    stream = Terminal()
    with compilation_notice(True, stream=stream):
        compiled()
    text = stream.getvalue()
    assert "first run: 0 kernels compiled in 0 s, now test_compilation.doubled" in text
    assert "\x1b[2K" in text  # the line is erased
    assert text.endswith("compiled 1 kernel in " + text.split()[-2] + " s\n")


def test_a_bar_that_is_shown_says_what_it_waits_for() -> None:
    stream, noted = Terminal(), []
    bar = ProgressBar("swing", 0.0, 1.0, statistics=Statistics(), stream=stream)
    bar.note = noted.append  # type: ignore[method-assign]
    with compilation_notice(True, stream=stream):
        compiled()
    bar.close(Outcome(Cause.COMPLETED, 1.0, 1.0), Statistics())
    assert noted == ["compiling test_compilation.doubled, 0 done", ""]
    assert progress.SHOWN == []
