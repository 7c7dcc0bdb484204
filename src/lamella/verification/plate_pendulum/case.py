"""A plate that swings on a ball joint at its corner: rigid, stiff and flexible."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal

import numpy as np

import lamella as lm
from lamella.result import Result
from lamella.verification import Curves, Evidence, References, Shape
from lamella.verification.mechanism import G

slow = False

SIZE, RHO = (0.6, 0.4), 7800.0
END = 0.4


def swinging(strain: Literal["exact", "rigid"], E: float, thickness: float) -> Result:
    """A level plate let go, with the far corner recorded as ``tip``."""
    layup = lm.Laminate(lm.Isotropic(E=E, nu=0.3, rho=RHO), thickness=thickness)
    system, ground = lm.System(), lm.Ground()
    plate = lm.Plate("plate", SIZE, (3, 2), layup, strain=strain)
    plate.marker("tip", *SIZE)
    ball = lm.SphericalJoint("ball", ground.marker("hook", 0, 0, 0), plate.corner("x-y-"))
    for item in (ground, plate, ball, lm.Gravity("weight", (0, 0, -G))):
        system.add(item)
    return lm.simulate(system, END, lm.GeneralizedAlpha(dt=2e-3, rho_inf=0.9, newton=lm.Newton(tolerance=1e-9)))


def rigid_body(thickness: float) -> Result:
    """A rigid body with the mass and inertia of the plate's mid-surface."""
    (a, b), mass = SIZE, RHO * thickness * SIZE[0] * SIZE[1]
    inertia = tuple(mass * np.array((b**2, a**2, a**2 + b**2)) / 12)
    system, ground = lm.System(), lm.Ground()
    body = lm.RigidBody("body", mass=mass, inertia=inertia, position=(0.5 * a, 0.5 * b, 0.0))
    body.marker("tip", 0.5 * a, 0.5 * b, 0.0)
    ball = lm.SphericalJoint("ball", ground.marker("hook", 0, 0, 0), body.marker("corner", -0.5 * a, -0.5 * b, 0.0))
    for item in (ground, body, ball, lm.Gravity("weight", (0, 0, -G))):
        system.add(item)
    return lm.simulate(system, END, lm.GeneralizedAlpha(dt=2e-3, rho_inf=0.9, newton=lm.Newton(tolerance=1e-9)))


def run() -> Iterator[Evidence]:
    """Yield the checks and pictures of this case."""
    references = References.beside(__file__)
    body, rigid = rigid_body(0.02), swinging("rigid", 210e9, 0.02)
    tips = [result["tip.position"].values for result in (body, rigid)]
    yield references.check("rigid plate against rigid body, tip", np.abs(tips[0] - tips[1]).max())
    forces = [result["ball.force"].values[20:] for result in (body, rigid)]
    yield references.check("rigid plate against rigid body, force", np.abs(forces[0] - forces[1]).max() / np.abs(forces[0]).max())
    stiff = swinging("exact", 210e9, 0.02)
    yield references.check("stiff plate against rigid body, tip", np.abs(stiff["tip.position"].values - tips[0]).max() / SIZE[0])
    flexible = swinging("exact", 2e9, 0.01)
    work = np.abs(flexible["work.loads"].values).max()
    balance = flexible["energy.balance"].values
    yield references.check("energy lost by the flexible plate", -balance[-1] / work)
    yield references.check("energy gained by the flexible plate", balance.max() / work)
    away = np.abs(flexible["tip.position"].values - tips[0]).max() / SIZE[0]
    yield references.check("flexible plate away from rigid body, tip", away)
    curves = {
        "stiff plate": (stiff.at, stiff["tip.position"].values[:, 2]),
        "flexible plate": (flexible.at, flexible["tip.position"].values[:, 2]),
    }
    yield Curves("Far corner of a plate let go", "Time [s]", "z [m]", curves, {"rigid body": (body.at, tips[0][:, 2])})
    yield Shape("The flexible plate", flexible, at=(0.1, 0.2, 0.3, 0.4))
