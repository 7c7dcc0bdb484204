"""How a load enters a build: its block, and the factor that is recorded."""

from __future__ import annotations

from lamella.dofs import Build, Motion, Signal
from lamella.roles import ForceBlock


def add_load(build: Build, block: ForceBlock, profile: Motion) -> None:
    """Add the block of a load and the breakpoints of its profile.

    Its factor p(t), times the load factor of statics, is recorded as ``<name>.factor``.
    """
    build.loads.append(block)
    build.breakpoints.extend(profile.breakpoints)
    build.signals.append(
        Signal(f"{block.name}.factor", "1", (), lambda state: profile.value(state.t) * state.factor, f"factor of {block.name}")
    )
