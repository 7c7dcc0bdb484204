"""Functions of time that stand for inputs: what is set is held until something else is."""

from __future__ import annotations

from lamella.math.profile import Constant, Integral
from lamella.memory import Memory


class Held(Integral, Memory):
    """A value that stays as it is until it is set.

    It stands in a declaration as a profile that is no speed, since time alone does not tell the integral of what is set later.

    Args:
        start: the value at the start.
    """

    remembered = ("now",)

    def __init__(self, start: float) -> None:
        super().__init__(Constant(0.0), start)
        self.now = start

    def __eq__(self, other: object) -> bool:
        return self is other  # two inputs that are equal now need not stay so

    def __hash__(self) -> int:
        return id(self)

    def shift(self, by: float) -> None:
        """Add to the value, to see what follows it."""
        self.now += by

    def hold(self, t: float, value: float) -> None:
        """Hold ``value`` from the time t [s] on."""
        self.now = value

    def value(self, t: float) -> float:
        return self.now


class HeldAcceleration(Held):
    """A motion x(t) = x_0 + v_0 (t - t_0) + a (t - t_0)^2 / 2 whose acceleration a is held; place and speed go on when it is set.

    Args:
        t: time of the start [s].
        start: x there.
        rate: x' there.
    """

    remembered = ("now", "_t", "_x", "_v")

    def __init__(self, t: float, start: float, rate: float) -> None:
        super().__init__(0.0)
        self._t, self._x, self._v = t, start, rate

    def shift(self, by: float) -> None:
        self._x += by

    def hold(self, t: float, value: float) -> None:
        self._t, self._x, self._v, self.now = t, self.value(t), self.rate(t), value

    def value(self, t: float) -> float:
        since = t - self._t
        return self._x + since * (self._v + 0.5 * self.now * since)

    def rate(self, t: float) -> float:
        return self._v + self.now * (t - self._t)

    def acceleration(self, t: float) -> float:
        return self.now
