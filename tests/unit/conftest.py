"""Settings of the unit tests."""

from __future__ import annotations

from hypothesis import settings

# A first call imports or compiles, so the time of one example says nothing.
settings.register_profile("lamella", deadline=None)
settings.load_profile("lamella")
