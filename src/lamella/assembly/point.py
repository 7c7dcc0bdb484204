"""Where equations are evaluated, and how the unknown moves that point."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from lamella.roles import Floats


@dataclass
class Point:
    """A point at which equations are evaluated; independent coordinates and multipliers are the unknowns.

    Args:
        t: time [s].
        u, ud, udd: independent coordinates, velocities and accelerations, shape (n_u,).
        lam: multipliers, shape (n_lam,).
        factor: load factor; scales loads and prescribed motions in statics, 1 in motion.
        at_rest: True in statics, where supports that move are frozen at time t.
    """

    t: float
    u: Floats
    ud: Floats
    udd: Floats
    lam: Floats
    factor: float = 1.0
    at_rest: bool = False

    def moved_to(self, u: Floats) -> Point:
        """The same point at other coordinates."""
        return Point(self.t, u, self.ud, self.udd, self.lam, self.factor, self.at_rest)

    def copy(self) -> Point:
        """An independent copy."""
        return Point(self.t, self.u.copy(), self.ud.copy(), self.udd.copy(), self.lam.copy(), self.factor, self.at_rest)


class Weights(NamedTuple):
    """dq = alpha_q du, dv = alpha_v du, da = alpha_a du: how coordinates, velocities and accelerations follow the unknown.

    Scalar fields have no accelerations; their rates follow by ``rate`` instead of alpha_v.
    """

    alpha_q: float = 1.0
    alpha_v: float = 0.0
    alpha_a: float = 0.0
    rate: float = 0.0


STATIC = Weights()
