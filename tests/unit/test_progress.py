"""The progress display where there is no terminal: a few plain lines."""

from __future__ import annotations

import io

import pytest

from lamella import progress
from lamella.progress import CountBar, ProgressBar
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


def test_counts_tell_the_time_to_go_from_what_was_done_since_the_start(monkeypatch: pytest.MonkeyPatch) -> None:
    now = iter([100.0, 120.0, 150.0, 160.0])
    monkeypatch.setattr(progress.time, "monotonic", lambda: next(now))
    stream = io.StringIO()
    bar = CountBar("study", 50, 100, "runs", stream)  # half of it was done another day
    bar.count(51)  # less than a tenth more: nothing is said
    bar.count(60, "1 failed")
    bar.count(75)
    bar.end()
    assert stream.getvalue().splitlines() == [
        "study: 60 of 100 runs, 1 failed, 20 s, 80 s to go",
        "study: 75 of 100 runs, 50 s, 50 s to go",
        "study: 75 of 100 runs, 60.0 s",
    ]
