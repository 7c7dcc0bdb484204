"""The steady running of a belt that sticks where it enters a pulley and slips where it leaves it, as the textbooks have it.

Material length is length at the stretch 1. With its flux c [m/s], the same everywhere, a belt of the stretch s runs with c s, and
G = T - rho c^2 s presses it on the pulleys. It sticks at the speed of the pulley, omega R = c s, with the tension with which it
enters, and slips over the angle ln(G_1 / G_2) / mu, where dG = mu G dtheta (Euler, Eytelwein; Reynolds 1874; Grashof 1883).
With equal pulleys, as far apart as half a circle is long, the unknown tensions follow from

    R (G_1 - G_2) - 2 rho g R^2 = M + d omega_2,    omega_2 / omega_1 = s_2 / s_1,    material length = the belt's.

Weight works on both pulleys alike: that of the half circles, whose centres of gravity are 2 R / pi beyond the axles, takes a part
of the moment of the tensions on pulley 2, and drives pulley 1. The sag of the strands carries their own.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import root

from lamella.roles import Floats

Law = Callable[[Floats], Floats]
"""Tension [N] by stretch [-]."""
STRETCHES = np.linspace(0.9, 1.1, 8001)
"""Where laws are inverted, by linear interpolation."""


@dataclass(frozen=True)
class Drive:
    """The belt drive.

    Args:
        radius: at which the belt runs [m].
        mu: coefficient of friction.
        mass: of the belt per material length [kg/m].
        omega: angular velocity of pulley 1 [rad/s].
        gravity: across the strands [m/s^2].
        load, damper: what brakes pulley 2 [N m] and [N m s].
    """

    radius: float
    mu: float
    mass: float
    omega: float
    gravity: float
    load: float
    damper: float

    @property
    def weight(self) -> float:
        """Moment of the weight of half a circle of the belt about the axle [N m]."""
        return 2.0 * self.mass * self.gravity * self.radius**2


@dataclass(frozen=True)
class Running:
    """Steady running: tensions [N], stretches [-], angular velocity of pulley 2 [rad/s], torque [N m], angle of slip [rad]."""

    T1: float
    T2: float
    stretch1: float
    stretch2: float
    omega2: float
    torque: float
    slip: float


def steady(law: Law, drive: Drive, guess: tuple[float, float]) -> Running:
    """Steady running of a belt with a law of tension.

    Args:
        law: tension by stretch.
        drive: the rest of the machine; the material length of the belt is that of its path.
        guess: tensions of the tight and the slack strand [N].
    """
    R, strand, tension = drive.radius, np.pi * drive.radius, law(STRETCHES)

    def rest(unknown: Floats) -> tuple[list[float], Running]:
        """What torque and material length leave, and the running."""
        T1, T2 = (float(T) for T in unknown)
        s1, s2 = (float(np.interp(T, tension, STRETCHES)) for T in (T1, T2))
        lost = drive.mass * (drive.omega * R / s1) ** 2
        G1, G2 = T1 - lost * s1, T2 - lost * s2
        slip, omega2 = float(np.log(G1 / G2)) / drive.mu, drive.omega * s2 / s1
        angle = np.linspace(0.0, slip, 201)
        slipping = np.interp(G2 * np.exp(drive.mu * angle), tension - lost * STRETCHES, STRETCHES)
        sticking = (strand + R * (np.pi - slip)) * (1.0 / s1 + 1.0 / s2)
        material, torque = sticking + 2.0 * R * float(np.trapezoid(1.0 / slipping, angle)), R * (G1 - G2) - drive.weight
        found = Running(T1, T2, s1, s2, omega2, torque, slip)
        return [torque - drive.load - drive.damper * omega2, (material - 4.0 * strand) * 1e3], found

    solution = root(lambda u: rest(u)[0], guess)
    return rest(solution.x)[1]
