"""What the benchmark's authors computed.

Figures are those of their repository (github.com/THREAD-2-3/beltDriveSimulation, MIT licence): stored results of 480 cable
elements and steps of 10 us at 2.45 s. Paper: Ntarladima, Pieber and Gerstmayr, Nonlinear Dynamics (2023),
doi 10.1007/s11071-023-08973-y.
"""

from __future__ import annotations

import numpy as np

from lamella.roles import Floats

TIGHT, SLACK = 664.5, 186.3
"""Tensions of the strands [N]."""
SPEED, TORQUE = 11.3250, 47.655
"""Angular velocity of pulley 2 [rad/s] and torque on pulley 1 [N m]."""
EA, SHRINKAGE = 8000.0, 0.05
"""Axial stiffness of their cable [N], and the strain that it lacks: T = EA (stretch - 1 + 0.05)."""

TABLE = (
    (0.0003, 664.5), (0.0250, 664.5), (0.0500, 664.5), (0.1000, 664.5), (0.1500, 664.5), (0.2000, 664.5), (0.2500, 664.5),
    (0.2961, 664.5), (0.3013, 664.5), (0.3039, 663.9), (0.3053, 660.1), (0.3079, 651.2), (0.3118, 638.1), (0.3170, 621.1),
    (0.3236, 600.6), (0.3301, 580.8), (0.3367, 561.7), (0.3445, 539.7), (0.3524, 518.6), (0.3602, 498.3), (0.3681, 478.9),
    (0.3759, 460.3), (0.3838, 442.4), (0.3917, 425.3), (0.3995, 408.9), (0.4074, 393.1), (0.4152, 377.9), (0.4231, 363.4),
    (0.4309, 349.5), (0.4401, 333.9), (0.4506, 317.0), (0.4610, 301.0), (0.4702, 287.7), (0.4807, 273.2), (0.4912, 259.5),
    (0.5003, 248.1), (0.5108, 235.7), (0.5213, 223.9), (0.5304, 214.1), (0.5409, 203.5), (0.5461, 198.4), (0.5487, 196.0),
    (0.5513, 194.5), (0.5553, 193.4), (0.5605, 192.9), (0.5684, 192.7), (0.5801, 192.6), (0.5906, 192.6), (0.5998, 192.5),
    (0.6063, 192.3), (0.6102, 191.9), (0.6129, 191.0), (0.6155, 188.9), (0.6181, 186.0), (0.6207, 186.3), (0.6403, 186.3),
    (0.7005, 186.3), (0.8000, 186.3), (0.9009, 186.3), (0.9401, 186.3), (0.9454, 186.2), (0.9467, 187.6), (0.9493, 190.6),
    (0.9532, 194.5), (0.9598, 200.7), (0.9702, 211.1), (0.9807, 222.1), (0.9899, 232.3), (1.0003, 244.4), (1.0108, 257.3),
    (1.0200, 269.1), (1.0304, 283.3), (1.0396, 296.4), (1.0501, 312.1), (1.0606, 328.7), (1.0697, 343.9), (1.0802, 362.3),
    (1.0907, 381.8), (1.0998, 399.7), (1.1103, 421.2), (1.1195, 441.0), (1.1299, 464.8), (1.1404, 490.2), (1.1496, 513.5),
    (1.1600, 541.6), (1.1705, 571.4), (1.1797, 598.8), (1.1875, 623.4), (1.1914, 636.2), (1.1940, 644.6), (1.1967, 649.8),
    (1.2006, 653.4), (1.2058, 655.3), (1.2124, 656.0), (1.2202, 656.1), (1.2281, 656.1), (1.2346, 656.3), (1.2398, 656.5),
    (1.2438, 657.1),
)  # fmt: skip


def law(stretch: Floats) -> Floats:
    """Tension of their cable [N]."""
    return EA * (stretch - 1.0 + SHRINKAGE)


def tension() -> tuple[Floats, Floats]:
    """Tension around the loop, against the belt's motion.

    Returns:
        Distance in space from the place where the belt meets pulley 1 [m], and tension [N], shapes (n,).
    """
    material, T = np.array(TABLE).T
    stretch = 1.0 - SHRINKAGE + T / EA
    steps = 0.5 * (stretch[1:] + stretch[:-1]) * np.diff(material)
    return np.concatenate([[0.0], np.cumsum(steps)]) + material[0], T
