"""A roller on an inclined sheet."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

import lamella as lm
from lamella.result import Result
from lamella.verification import Check, Curves, Evidence

slow = False

R, H, WIDTH, LENGTH, MASS, G = 0.1, 0.004, 0.1, 0.8, 5.0, 9.81
INERTIA = 0.5 * MASS * R**2
K, MU = 6e8, 0.3
END = 0.3


def rolled(theta: float) -> Result:
    """The roller let go on a sheet along x that is inclined by theta: gravity is turned instead of the sheet."""
    system, ground = lm.System(), lm.Ground()
    laminate = lm.Laminate(lm.Isotropic(E=70e9, nu=0.3, rho=2700), thickness=H)
    sheet = lm.Plate("sheet", (LENGTH, WIDTH), (8, 1), laminate, strain="rigid", position=(0.0, -0.5 * WIDTH, 0.0))
    solid = lm.Cylinder(radius=R, length=1.5 * WIDTH)
    z = R + 0.5 * H - sink(theta)
    roller = lm.RigidBody("roller", mass=MASS, shape=solid, position=(0.15, 0.0, z), rotation=(-0.5 * np.pi, 0.0, 0.0))
    friction = lm.BristleFriction(stiffness=1e9, damping=1e5)
    law = {"stiffness": K, "damping": 0.05, "mu": MU, "friction": friction, "points": 20}
    contact = lm.CylinderContact("line", sheet, roller.origin, R, 1.5 * WIDTH, **law)  # type: ignore[arg-type]
    hold = lm.FixedJoint("hold", ground.marker("left", 0.0, -0.5 * WIDTH, 0.0), sheet.corner("x-y-"))
    for item in (ground, sheet, roller, contact, hold, lm.Gravity("weight", (G * np.sin(theta), 0.0, -G * np.cos(theta)))):
        system.add(item)
    newton = lm.Newton(tolerance=1e-8, max_iterations=50, keep=0.5)
    return lm.simulate(system, END, lm.GeneralizedAlpha(dt=1e-3, rho_inf=0.6, newton=newton))


def sink(theta: float) -> float:
    """Depth of a long cylinder under its weight: N = w k int (delta - x^2 / (2 R))^(3/2) dx = 3 pi / 8 w k sqrt(2 R) delta^2."""
    return float(np.sqrt(MASS * G * np.cos(theta) / (0.375 * np.pi * WIDTH * K * np.sqrt(2 * R))))


def run() -> Iterator[Evidence]:
    """Yield the checks and pictures of this case."""
    places, references = {}, {}
    for name, theta in (("rolls", 0.2), ("slides", 1.0)):
        result = rolled(theta)
        R_e = R + 0.5 * H - 0.8 * sink(theta)  # friction acts at the depth in the mean, weighted by the pressure
        if name == "rolls":
            a = G * np.sin(theta) / (1 + INERTIA / (MASS * R_e**2))
            turning, source, tolerance = a / R_e, "rolling without slip", 6e-3
            # Points that touch lie up to the depth nearer to the axis than others, 1.2 % of R, so they cannot all roll; slip of a
            # third of that in the mean brakes by mu times it, 0.12 % of the weight, where 20 % drive.
            why = "conforming slip brakes by mu depth / (3 R sin theta)"
        else:
            a = G * (np.sin(theta) - MU * np.cos(theta))
            turning, source, tolerance = MU * MASS * G * R_e * np.cos(theta) / INERTIA, "Coulomb friction", 2e-3
            why = "R_e is a mean over depths of up to 1.2 % of R, known to a sixth of that"
        v, omega = result["roller.velocity"].values[:, 0], result["roller.angular_velocity"].values[:, 1]
        yield Check(f"speed when it {name}", v[-1], a * END, tolerance, source=source, unit="m/s", reason=why)
        yield Check(
            f"angular velocity when it {name}", omega[-1], turning * END, tolerance, source=source, unit="rad/s", reason=why
        )
        lost = result["energy.balance"].values[-1] / (0.5 * MASS * v[-1] ** 2)
        why = "relative to the kinetic energy: steps of 1 ms, and the stretch of the bristles, 1e-3 of the radius"
        yield Check(f"energy unaccounted for when it {name}", lost, 0.0, 2e-4, "absolute", "conservation of energy", reason=why)
        places[name] = (result.at, v)
        t = np.linspace(0.0, END, 7)
        references[f"{source}, {theta:g} rad"] = (t, a * t)
    yield Curves("A roller on an inclined sheet", "Time [s]", "Speed [m/s]", places, references)
