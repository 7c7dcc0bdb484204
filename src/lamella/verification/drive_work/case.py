"""A cart driven along a rail carries a damped plate: the drive's work is the change of energy and the heat."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

import lamella as lm
from lamella.result import Result
from lamella.roles import Floats
from lamella.verification import Curves, Evidence, References
from lamella.verification.mechanism import G

slow = True

SIZE, THICKNESS, RHO, CART = (0.3, 0.5), 2e-3, 2700.0, 4.0
END = 0.4
WAY = lm.SmoothStep(start=0.0, end=0.4, t_end=0.3)
STEPS = (2e-3, 1e-3)
UPRIGHT = 3 * (2 * np.pi / 3 / np.sqrt(3),)  # rotation vector that turns x to y, y to z, z to x


def driven() -> lm.System:
    """The plate stands on the cart, clamped along its lower edge, and bends in the direction of the motion."""
    layup = lm.Laminate(lm.Isotropic(E=3e9, nu=0.3, rho=RHO), thickness=THICKNESS)
    system, ground = lm.System(), lm.Ground()
    cart = lm.RigidBody("cart", mass=CART, shape=lm.Box((0.4, 0.5, 0.1)))
    # the plate's x axis along the inertial y axis and its y axis upward: its normal points along x
    plate = lm.Plate("plate", SIZE, (1, 3), layup, rotation=UPRIGHT, position=(0.0, -0.15, 0.05), damping=2e-3)
    plate.marker("top", 0.15, 0.5)
    for item in (
        *(ground, cart, plate),
        lm.PrismaticJoint("rail", ground.marker("post", 0, 0, 0), cart.origin, axis=(1, 0, 0)),
        lm.FixedJoint("foot", cart.marker("deck", 0, 0, 0.05), plate.edge("y-")),
        lm.PrescribedMotion("drive", cart.origin, "x", WAY),
        lm.Gravity("weight", (0, 0, -G)),
    ):
        system.add(item)
    return system


def balance(result: Result) -> tuple[Floats, Floats]:
    """Work of the drive, force times given speed by the trapezoidal rule, and what becomes of it [J], each shape (n,)."""
    power = result["drive.force"].values[:, 0] * np.array([WAY.rate(t) for t in result.at])
    done = np.append(0.0, np.cumsum(0.5 * np.diff(result.at) * (power[1:] + power[:-1])))
    energy = result["energy.kinetic"].values + result["energy.strain"].values - result["work.loads"].values
    gained = energy + result["work.dissipated"].values
    return done, gained - gained[0]


def run() -> Iterator[Evidence]:
    """Yield the checks and pictures of this case."""
    references = References.beside(__file__)
    newton = lm.Newton(tolerance=1e-9)
    coarse, fine = (lm.simulate(driven(), END, lm.GeneralizedAlpha(dt=dt, rho_inf=0.9, newton=newton)) for dt in STEPS)
    errors = [float(np.abs(np.subtract(*balance(result))).max()) for result in (coarse, fine)]
    largest = fine["energy.kinetic"].values.max()
    yield references.check("work of the drive less energy and heat, 1 ms", errors[1] / largest)
    yield references.check("order of the difference", np.log2(errors[0] / errors[1]))
    recorded, (done, gained) = fine["work.supports"].values, balance(fine)
    parts = {name: (fine.at, fine[name].values) for name in ("energy.kinetic", "energy.strain", "work.dissipated")}
    yield Curves(
        "Work of the drive", "Time [s]", "Energy [J]", {"work": (fine.at, done)} | parts, {"energy and heat": (fine.at, gained)}
    )
    yield references.check("recorded work against force times speed", np.abs(recorded - done).max() / largest)
    yield references.check("share of heat", fine["work.dissipated"].values[-1] / largest)
    weight = (CART + RHO * THICKNESS * SIZE[0] * SIZE[1]) * G
    inertia = (fine.model.mass @ fine.final.a).reshape(-1, 3)[fine.model.is_position].sum(axis=0)
    held = fine["drive.force"].values[-1] + fine["rail.force"].values[-1] - (0.0, 0.0, weight)
    yield references.check("forces less inertia", np.abs(held - inertia).max() / weight)
