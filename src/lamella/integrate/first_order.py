"""The generalised-alpha method for first-order equations: how scalar fields follow their rates."""

from __future__ import annotations

import numpy as np

from lamella.memory import Memory
from lamella.roles import Floats


class FirstOrderRule(Memory):
    """Generalised-alpha for C Tdot + K T = F (Jansen, Whiting and Hulbert 2000), with the equation met at the end of the step:

        T' = T + dt ((1 - gamma) s + gamma s'),    alpha_m s' + (1 - alpha_m) s = alpha_f Tdot' + (1 - alpha_f) Tdot

    with the algorithmic rate s, alpha_m = (3 - rho) / (2 (1 + rho)), alpha_f = 1 / (1 + rho), gamma = 1/2 + alpha_m - alpha_f:
    second order, unconditionally stable, with spectral radius rho at infinity. For rho = 1 it is the trapezoidal rule, which for
    linear equations is the central difference C (T' - T) / dt + K (T' + T) / 2 = (F' + F) / 2.

    Args:
        rho: spectral radius at infinity, 0 to 1.
    """

    remembered = ("s", "_change", "_dt")

    def __init__(self, rho: float) -> None:
        self.alpha_m, self.alpha_f = 0.5 * (3.0 - rho) / (1.0 + rho), 1.0 / (1.0 + rho)
        self.gamma = 0.5 + self.alpha_m - self.alpha_f
        self.s, self._change, self._dt = np.zeros(0), np.zeros(0), 1.0

    def restart(self, rate: Floats) -> None:
        """Start from a consistent point: the algorithmic rate is the true one."""
        self.s, self._change = rate.copy(), np.zeros_like(rate)

    def jump(self, change: Floats) -> None:
        """Go on after the true rate has jumped."""
        self.s = self.s + change

    def weight(self, dt: float) -> float:
        """How much the new rate follows the new value [1/s]."""
        return self.alpha_m / (self.alpha_f * self.gamma * dt)

    def predicted(self, dt: float, value: Floats, rate: Floats) -> tuple[Floats, Floats]:
        """New values and rates if the algorithmic rate stayed the same."""
        return value + dt * self.s, (self.s - (1.0 - self.alpha_f) * rate) / self.alpha_f

    def algorithmic(self, rate: Floats, new_rate: Floats) -> Floats:
        """The new algorithmic rate s'."""
        if not len(rate):  # most systems have no fields, and the sums below take a hundredth of a small one's step
            return self.s
        return (self.alpha_f * new_rate + (1.0 - self.alpha_f) * rate - (1.0 - self.alpha_m) * self.s) / self.alpha_m

    def error(self, dt: float, s: Floats) -> Floats:
        """The first term that a step leaves out, dt^3 Tddd / 12, from the last changes of the rate."""
        return dt / 12.0 * (s - self.s - self._change * (dt / self._dt))

    def accept(self, dt: float, s: Floats) -> None:
        """Make a step final."""
        self._change, self._dt, self.s = s - self.s, dt, s
