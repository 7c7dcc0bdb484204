"""Rigid panels that unfold from a zig-zag, driven at their tip: a mechanism with one degree of freedom, in closed form."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from lamella.math.profile import TrapezoidalSpeed

if TYPE_CHECKING:
    from lamella.roles import Floats

LENGTH, MASS = 1.5, 1560 * 1.5 * 2.0 * 1.5e-3
"""Length [m] and mass [kg] of a panel of the example ``solar-array``."""
FOLDED, UNFOLDED = np.radians(75), np.radians(10)
"""Angles of its panels to the x axis at the start and at the end [rad]."""
LAW = TrapezoidalSpeed(t_end=5.0, ramp=0.1, end=4 * LENGTH * (np.cos(UNFOLDED) - np.cos(FOLDED)))
"""Displacement of the tip [m], said here again so that a changed model is noticed."""


def driving_force(t: Floats) -> Floats:
    """Force [N] that drives the tip along x at times t [s], both of shape (n,).

    Four panels of length L and mass m stand at angles +-phi to the x axis; the middle hinge follows at half the way of the tip,
    X = 4 L cos(phi). The drive's power is the change of kinetic energy:

        T = 1/2 m L^2 phi'^2 g,   g = 21 sin^2 phi + cos^2 phi + 1/3,   F = (dT/dt) / X'
    """
    x, v, a = (np.array([f(time) for time in t]) for f in (LAW.value, LAW.rate, LAW.acceleration))
    phi = np.arccos(np.cos(FOLDED) + x / (4 * LENGTH))
    sine, cosine = np.sin(phi), np.cos(phi)
    rate = -v / (4 * LENGTH * sine)
    second = -(a / (4 * LENGTH) + cosine * rate**2) / sine
    g, slope = 21 * sine**2 + cosine**2 + 1 / 3, 40 * sine * cosine
    return -MASS * LENGTH * (g * second + 0.5 * slope * rate**2) / (4 * sine)
