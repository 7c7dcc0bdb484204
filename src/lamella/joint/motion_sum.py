"""Sums of functions of time that supports follow."""

from __future__ import annotations

from dataclasses import dataclass

from lamella.dofs import Motion


@dataclass(frozen=True)
class MotionSum:
    """The function sum_k c_k m_k(t), such as the component of a motion in space along a direction.

    Args:
        parts: pairs (c_k, m_k).
    """

    parts: tuple[tuple[float, Motion], ...]

    def value(self, t: float) -> float:
        """Its value [m]."""
        return sum(c * motion.value(t) for c, motion in self.parts)

    def rate(self, t: float) -> float:
        """Its first derivative [m/s]."""
        return sum(c * motion.rate(t) for c, motion in self.parts)

    def acceleration(self, t: float) -> float:
        """Its second derivative [m/s^2]."""
        return sum(c * motion.acceleration(t) for c, motion in self.parts)

    @property
    def breakpoints(self) -> tuple[float, ...]:
        """Times [s] at which the value or a derivative jumps."""
        return tuple(sorted({t for _, motion in self.parts for t in motion.breakpoints}))
