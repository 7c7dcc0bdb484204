"""Settings of the unit tests."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from hypothesis import settings

from lamella import threads
from lamella.solve import schedule

# A first call imports or compiles, so the time of one example says nothing.
settings.register_profile("lamella", deadline=None)
settings.load_profile("lamella")


@pytest.fixture
def always_cut(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Small meshes are cut among threads like large ones; the number of threads is restored."""
    monkeypatch.setattr(threads, "WORTHWHILE", 0.0)
    monkeypatch.setattr(threads, "SHORTEST", 1e-6)
    monkeypatch.setattr(schedule, "HANDED_OUT", 0.0)
    monkeypatch.setattr(schedule, "SAVED", 1.0)
    yield
    threads.use(None)
