"""What happened in a run, in lines for the console."""

from __future__ import annotations

from lamella.result import Outcome

MOST = 20
"""Events listed; a contact that opens and closes may have thousands."""


def event_lines(outcome: Outcome) -> list[str]:
    """One line for each event, the first ones where there are very many."""
    lines = [str(event) for event in outcome.events[:MOST]]
    rest = len(outcome.events) - MOST
    return [*lines, f"and {rest} more events"] if rest > 0 else lines
