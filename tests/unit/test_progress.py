"""The progress display where there is no terminal: a few plain lines."""

from __future__ import annotations

import io

import pytest

from lamella import progress
from lamella.progress import ProgressBar
from lamella.result import Cause, Outcome, Statistics


def test_plain_lines_are_few_and_say_where_the_solution_is(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(progress, "INTERVAL", 0.0)
    stream, statistics = io.StringIO(), Statistics(steps=1000, newton_iterations=2500)
    bar = ProgressBar("swing", 0.0, 2.0, statistics=statistics, stream=stream)
    for step in range(1001):
        bar.sample(step * 2e-3, [])
    bar.close(Outcome(Cause.COMPLETED, 2.0, 2.0), statistics)
    lines = stream.getvalue().splitlines()
    assert len(lines) == 11
    assert lines[0].startswith("swing:  10 %, t = 0.2 s, step 0.002 s, 2.5 iterations a step")
    assert lines[-1].startswith("swing: completed at 2, t = 2 s")


def test_early_end_is_told() -> None:
    stream = io.StringIO()
    bar = ProgressBar("still", 0.0, 1.0, "", stream=stream)
    bar.close(Outcome(Cause.SINGULAR, 0.0, 1.0), Statistics())
    assert "still: stopped at 0 of 1: the system matrix is singular" in stream.getvalue()
