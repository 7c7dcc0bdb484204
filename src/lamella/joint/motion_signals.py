"""Signals of what a joint leaves free: the angle about its axis and the displacement along it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lamella.dofs import Signal
from lamella.kinematics import Frame, VectorRows
from lamella.state import State


class TurnCounter:
    """An angle without jumps: of all values that differ by full turns, the one nearest to the last.

    A time that does not grow begins a new run.
    """

    def __init__(self) -> None:
        self._t, self._angle = np.inf, 0.0

    def __call__(self, t: float, angle: float) -> float:
        if t > self._t:
            angle += 2.0 * np.pi * np.round((self._angle - angle) / (2.0 * np.pi))
        self._t, self._angle = t, angle
        return angle


@dataclass(frozen=True)
class Turn:
    """An angle of a joint, or a share of it: that which turns u into w about t, with u and w taken perpendicular to t.

        S = |t| t . (u x w),   C = (t x u) . (t x w),   angle = atan2(S, C)

    Args:
        u: vector of a.
        w: vector of b.
        t: axis, of any length.
        weight: share of the joint's angle; the shares of a joint sum to 1.
    """

    u: VectorRows
    w: VectorRows
    t: VectorRows
    weight: float = 1.0


def angle_signals(name: str, turn: Turn) -> list[Signal]:
    """A joint's angle, counting turns, and its rate (C S' - S C') / (S^2 + C^2)."""
    counter = TurnCounter()

    def values(state: State) -> tuple[float, float, float, float]:
        """S, C and their rates for t scaled to unit length, which changes neither the angle nor its rate."""
        x, v = state.q.reshape(-1, 3), state.v.reshape(-1, 3)
        u, w, t = turn.u.at(x), turn.w.at(x), turn.t.at(x)
        du, dw, dt = turn.u.rate(v), turn.w.rate(v), turn.t.rate(v)
        length = np.linalg.norm(t)
        dt, t = dt / length, t / length
        dt -= (dt @ t) * t
        s_rate = dt @ np.cross(u, w) + t @ (np.cross(du, w) + np.cross(u, dw))
        a, b = np.cross(t, u), np.cross(t, w)
        c_rate = (np.cross(dt, u) + np.cross(t, du)) @ b + a @ (np.cross(dt, w) + np.cross(t, dw))
        return float(t @ np.cross(u, w)), float(a @ b), float(s_rate), float(c_rate)

    def angle(state: State) -> float:
        s, c, _, _ = values(state)
        return counter(state.t, float(np.arctan2(s, c)))

    def rate(state: State) -> float:
        s, c, s_rate, c_rate = values(state)
        return (c * s_rate - s * c_rate) / (s * s + c * c)

    return [
        Signal(f"{name}.angle", "rad", (), angle, f"angle of {name}"),
        Signal(f"{name}.rate", "rad/s", (), rate, f"angular velocity of {name}"),
    ]


def slide_signals(name: str, a: Frame, b: Frame) -> list[Signal]:
    """Displacement of b's origin along a's z axis, and its rate."""
    offset = b.origin - a.origin

    def displacement(state: State) -> float:
        x = state.q.reshape(-1, 3)
        return float(offset.at(x) @ a.z.at(x))

    def rate(state: State) -> float:
        x, v = state.q.reshape(-1, 3), state.v.reshape(-1, 3)
        return float(offset.rate(v) @ a.z.at(x) + offset.at(x) @ a.z.rate(v))

    return [
        Signal(f"{name}.displacement", "m", (), displacement, f"displacement of {name}"),
        Signal(f"{name}.speed", "m/s", (), rate, f"speed of {name}"),
    ]
