"""Small-deformation strain models against the exact one, for loads that vanish."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

import lamella as lm
from lamella.element.plate48.block import STRAIN_MODELS
from lamella.roles import Floats
from lamella.verification import Check, References

slow = False

PLY = lm.Lamina(E1=181e9, E2=10.3e9, G12=7.17e9, nu12=0.28, rho=1600)
SECTIONS = {"symmetric laminate": ((0, 45, 45, 0), -0.04), "unsymmetric laminate": ((0, 45, -45, 90), -2e-3)}
"""Fibre angles, and the largest of three forces [N]."""


def run() -> Iterator[Check]:
    """Yield the checks of this case."""
    references = References.beside(__file__)
    for section, (angles, largest) in SECTIONS.items():
        forces = (largest, largest / 2, largest / 4)
        exact = np.array([corner(angles, force, "exact") for force in forces])
        for name in sorted(set(STRAIN_MODELS) - {"exact"}):
            small = np.array([corner(angles, force, name) for force in forces])
            gap = np.abs(exact - small)
            check = references.check(f"{section}: difference of z relative to z, smallest load", gap[2, 2] / abs(exact[2, 2]))
            yield replace(check, quantity=f"{check.quantity}, strain = {name}")
            check = references.check(f"{section}: order of the difference of z", np.log2(gap[1, 2] / gap[2, 2]))
            yield replace(check, quantity=f"{check.quantity}, strain = {name}")
            if name == "linear":
                bent = small[0] - 2 * small[1]
                yield references.check(f"{section}: linear model, proportional to the load", np.abs(bent / small[0, 2]).max())


def corner(angles: tuple[int, ...], force: float, strain: str) -> Floats:
    """Displacement of the loaded corner [m], shape (3,)."""
    system = lm.System()
    section = lm.Laminate(PLY, angles=angles, thickness=2e-3)
    plate = system.add(lm.Plate("plate", (0.6, 0.4), (4, 3), section, strain=strain))  # pyright: ignore[reportArgumentType]
    system.add(lm.Clamp("root", plate.edge("x-")))
    system.add(lm.PointForce("force", plate.marker("corner", 0.6, 0.4), (0.0, 0.0, force)))
    result = lm.equilibrium(system, newton=lm.Newton(tolerance=1e-13, keep=0.0))
    return result["corner.position"].values - [0.6, 0.4, 0.0]
