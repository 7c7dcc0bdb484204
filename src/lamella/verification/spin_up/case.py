"""A flexible beam on a hub is spun up: the manoeuvre of Simo and Vu-Quoc."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

import lamella as lm
from lamella.verification import Curves, Evidence, References, Shape

slow = True

LENGTH, WIDTH = 10.0, 1.0
EA, EI, MASS_PER_LENGTH = 2.8e7, 1.4e4, 1.2
SPEED, RAMP = 6.0, 15.0
THICKNESS = float(np.sqrt(12 * EI / EA))


def beam() -> lm.System:
    """The beam as a strip along x, fixed by its edge to a hub that turns about -y, so that it turns from x to z."""
    steel = lm.Isotropic(E=EA / (WIDTH * THICKNESS), nu=0.0, rho=MASS_PER_LENGTH / (WIDTH * THICKNESS))
    system, ground = lm.System(), lm.Ground()
    system.add(ground)
    hub = system.add(lm.RigidBody("hub", mass=1.0, shape=lm.Cylinder(radius=0.1, length=0.1)))
    layup = lm.Laminate(steel, thickness=THICKNESS)
    strip = system.add(lm.Plate("beam", (LENGTH, WIDTH), (24, 1), layup, position=(0.0, -0.5 * WIDTH, 0.0)))
    strip.marker("tip", LENGTH, 0.5 * WIDTH)
    pin = system.add(lm.RevoluteJoint("pin", ground.origin, hub.origin, axis=(0, -1, 0)))
    system.add(lm.FixedJoint("mount", hub.marker("face", 0.0, 0.0, 0.0), strip.edge("x-")))
    system.add(lm.AngleDrive("motor", pin, speed=lm.Cycloid(t_end=RAMP, end=SPEED)))
    return system


def run() -> Iterator[Evidence]:
    """Yield the checks and pictures of this case."""
    references = References.beside(__file__)
    result = lm.simulate(beam(), 20.0, lm.GeneralizedAlpha(dt=1e-2, rho_inf=0.8))
    t, tip, angle = result.at, result["tip.position"].values, result["pin.angle"].values
    along = tip[:, 0] * np.cos(angle) + tip[:, 2] * np.sin(angle) - LENGTH
    across = -tip[:, 0] * np.sin(angle) + tip[:, 2] * np.cos(angle)
    steady = t > RAMP + 1.0
    yield references.check("steady extension of the tip", along[steady].mean())
    yield references.check("mean deflection after the ramp", across[steady].mean())
    yield references.check("angle at the end", angle[-1])
    yield Curves("Deflection of the tip across the beam", "Time [s]", "Deflection [m]", {"lamella": (t, across)})
    steady_state = {"steady, Simo and Vu-Quoc": ([t[-1]], [references.value("steady extension of the tip")])}
    yield Curves("Extension of the beam", "Time [s]", "Tip along the beam [m]", {"lamella": (t, along)}, steady_state)
    yield Shape("At 3 s, 6 s, 9 s and 16 s", result, at=(3.0, 6.0, 9.0, 16.0), view=(0.3, 1.0, -0.3))
