"""The closed belt of the cases on rings: 0.8 m wide and 2.5 m long, once around, free in space."""

from __future__ import annotations

from typing import Literal

import numpy as np

import lamella as lm
from lamella.roles import Floats

LENGTH, WIDTH, THICKNESS = 2.5, 0.8, 4e-3
RADIUS = LENGTH / (2 * np.pi)
E_X, E_Y, G_XY, RHO = 1.0e9, 0.4e9, 0.2e9, 1200.0
WAVES = np.array([2, 3, 4])
"""Numbers of waves around the ring whose frequencies are compared."""

Element = Literal["plate48", "plate36"]
ELEMENTS: tuple[Element, ...] = ("plate48", "plate36")


def belt(mesh: tuple[int, int], nu: float = 0.0, element: Element = "plate48") -> lm.System:
    """The belt, stress-free as a circular cylinder about z, with Poisson's ratio nu_xy."""
    system = lm.System()
    section = lm.Laminate(lm.Lamina(E1=E_X, E2=E_Y, nu12=nu, G12=G_XY, rho=RHO), angles=(0,), thickness=THICKNESS)
    shell = lm.Shell("belt", lm.BeltSurface(length=LENGTH, width=WIDTH), mesh, section, element=element)
    shell.marker("node", 0.0, 0.0)
    system.add(shell)
    return system


def rayleigh() -> Floats:
    """Frequencies [Hz] of the free inextensible ring with 2, 3 and 4 waves, nu = 0.

    omega^2 = n^2 (n^2 - 1)^2 / (n^2 + 1) E h^2 / (12 rho R^4) (Rayleigh, The Theory of Sound, art. 233).
    """
    n = WAVES
    return n * (n**2 - 1) / np.sqrt(n**2 + 1) * np.sqrt(E_X * THICKNESS**2 / (12 * RHO)) / (2 * np.pi * RADIUS**2)
