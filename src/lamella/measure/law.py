"""Laws of force: what a spring, a stop or a latch answers to its measure."""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np

from lamella.dofs import Motion
from lamella.math.profile import Constant
from lamella.memory import Memory
from lamella.roles import Floats


class Law(Memory, ABC):
    """F(t, m, m'), the force that resists a measure m, so that V' = F for its elastic part.

    1. All arrays have one entry for each measure.
    2. ``force`` gives F, dF/dm and dF/dm'.
    3. ``energy`` is the potential V of the part that does not depend on m'; ``dissipation`` the power of the rest, at least 0.
    """

    damped: bool = False
    """Whether F depends on m'."""
    varies: bool = False
    """Whether V depends on time."""
    breakpoints: tuple[float, ...] = ()
    """Times [s] at which F jumps."""

    @abstractmethod
    def force(self, t: float, m: Floats, rate: Floats) -> tuple[Floats, Floats, Floats]:
        """F, dF/dm and dF/dm'."""

    @abstractmethod
    def energy(self, t: float, m: Floats) -> Floats:
        """V [J]."""

    def dissipation(self, t: float, m: Floats, rate: Floats) -> Floats:
        """Power turned into heat [W]."""
        return np.zeros_like(m)

    def reset(self) -> None:
        """Forget discrete state, if there is any."""


class SpringLaw(Law):
    """F = k (m - m_0(t)) + c m' + F_0(t), V = 1/2 k (m - m_0)^2 + F_0 m.

    Args:
        stiffness: k.
        damping: c.
        rest: m_0 as a function of time.
        preload: F_0 as a function of time.
    """

    def __init__(self, stiffness: float, damping: float, rest: Motion, preload: Motion) -> None:
        self.stiffness, self.damping_constant, self.rest, self.preload = stiffness, damping, rest, preload
        self.damped = damping > 0
        self.varies = not (type(rest) is type(preload) is Constant)  # an input is a Constant that changes
        self.breakpoints = (*rest.breakpoints, *preload.breakpoints)

    def force(self, t: float, m: Floats, rate: Floats) -> tuple[Floats, Floats, Floats]:
        F = self.stiffness * (m - self.rest.value(t)) + self.damping_constant * rate + self.preload.value(t)
        return F, np.full_like(m, self.stiffness), np.full_like(m, self.damping_constant)

    def energy(self, t: float, m: Floats) -> Floats:
        return 0.5 * self.stiffness * (m - self.rest.value(t)) ** 2 + self.preload.value(t) * m

    def dissipation(self, t: float, m: Floats, rate: Floats) -> Floats:
        return self.damping_constant * rate**2


class StopLaw(Law):
    """End stops: nothing between ``lower`` and ``upper``; beyond them, with the depth d,

        |F| = max(0, p(d) (1 + c_s d')),    p = k d^2 / (2 w) for d < w, k (d - w/2) beyond

    The onset over the small width w is quadratic, so that Newton's method meets no corner; damping in proportion to the pressure
    (Hunt and Crossley 1975) begins at zero and never pulls.

    Args:
        lower, upper: bounds of m, either may be infinite.
        stiffness: k.
        damping: c_s, inverse of the approach speed that doubles the force [s/m, s/rad].
        width: w.
    """

    def __init__(self, lower: float, upper: float, stiffness: float, damping: float, width: float) -> None:
        self.lower, self.upper, self.stiffness, self.damping_constant, self.width = lower, upper, stiffness, damping, width
        self.damped = damping > 0

    def _pressure(self, d: Floats) -> tuple[Floats, Floats]:
        """p and dp/dd."""
        k, w = self.stiffness, self.width
        d = np.maximum(d, 0.0)
        inside = d < w
        return np.where(inside, 0.5 * k * d**2 / w, k * (d - 0.5 * w)), np.where(inside, k * d / w, k)

    def force(self, t: float, m: Floats, rate: Floats) -> tuple[Floats, Floats, Floats]:
        F, F_m, F_rate = np.zeros_like(m), np.zeros_like(m), np.zeros_like(m)
        for sign, d in ((1.0, m - self.upper), (-1.0, self.lower - m)):
            p, slope = self._pressure(d)
            growth = 1.0 + self.damping_constant * sign * rate
            pushes = (growth > 0) & (d > 0)
            F += np.where(pushes, sign * p * growth, 0.0)
            F_m += np.where(pushes, slope * growth, 0.0)
            F_rate += np.where(pushes, p * self.damping_constant, 0.0)
        return F, F_m, F_rate

    def energy(self, t: float, m: Floats) -> Floats:
        k, w = self.stiffness, self.width
        total = np.zeros_like(m)
        for d in (m - self.upper, self.lower - m):
            d = np.maximum(d, 0.0)
            total += np.where(d < w, k * d**3 / (6.0 * w), k * w**2 / 6.0 + 0.5 * k * (d - w) * d)
        return total

    def dissipation(self, t: float, m: Floats, rate: Floats) -> Floats:
        elastic = sum(sign * self._pressure(d)[0] for sign, d in ((1.0, m - self.upper), (-1.0, self.lower - m)))
        return (self.force(t, m, rate)[0] - elastic) * rate


class LatchLaw(Law):
    """A spring and damper that does nothing until it is engaged, and from then on holds every m where it was at that moment.

        F = k (m - m_engaged) + c m'

    So it begins without a jump of force, but for the damping, and without energy. ``engage`` and ``reset`` change its one piece
    of discrete state.

    Args:
        stiffness: k.
        damping: c.
    """

    remembered = ("held",)

    def __init__(self, stiffness: float, damping: float) -> None:
        self.stiffness, self.damping_constant, self.damped = stiffness, damping, damping > 0
        self.held: Floats | None = None

    def engage(self, m: Floats) -> None:
        """Hold the measures at ``m`` from now on."""
        self.held = m.copy()

    def reset(self) -> None:
        """Let go, as at the start of a run."""
        self.held = None

    def force(self, t: float, m: Floats, rate: Floats) -> tuple[Floats, Floats, Floats]:
        if self.held is None:
            zero = np.zeros_like(m)
            return zero, zero, zero
        F = self.stiffness * (m - self.held) + self.damping_constant * rate
        return F, np.full_like(m, self.stiffness), np.full_like(m, self.damping_constant)

    def energy(self, t: float, m: Floats) -> Floats:
        return np.zeros_like(m) if self.held is None else 0.5 * self.stiffness * (m - self.held) ** 2

    def dissipation(self, t: float, m: Floats, rate: Floats) -> Floats:
        return np.zeros_like(m) if self.held is None else self.damping_constant * rate**2
