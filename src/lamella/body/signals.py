"""Signals that bodies record."""

from __future__ import annotations

from lamella.dofs import PointRows, Signal

AXES = ("x", "y", "z")


def marker_signals(name: str, where: str, rows: PointRows) -> list[Signal]:
    """Position and velocity of a marker."""
    return [
        Signal(f"{name}.position", "m", AXES, lambda state: rows.at(state.q.reshape(-1, 3)), f"position of {where}"),
        Signal(f"{name}.velocity", "m/s", AXES, lambda state: rows.moved(state.v.reshape(-1, 3)), f"velocity of {where}"),
    ]
