"""A plate hung on a rod swings as the double pendulum it is."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy import linalg

import lamella as lm
from lamella.verification import Check, Curves, Evidence, References

slow = False

WIDTH, HEIGHT, THICKNESS, RHO = 0.4, 0.6, 0.02, 2700.0
ROD, G = 0.8, 9.81
ANGLE = 2e-3


def double_pendulum() -> tuple[np.ndarray, np.ndarray]:
    """Angular frequencies [rad/s] and shapes (angle of the rod, angle of the plate) of small swings out of the plate's plane."""
    m, a = WIDTH * HEIGHT * THICKNESS * RHO, 0.5 * HEIGHT
    J = m * HEIGHT**2 / 12
    M = np.array([[m * ROD**2, m * ROD * a], [m * ROD * a, m * a**2 + J]])
    squares, shapes = linalg.eigh(np.diag([m * G * ROD, m * G * a]), M)
    return np.sqrt(squares), shapes / np.abs(shapes).max(axis=0)


def hanging(rod: float, plate: float) -> lm.System:
    """The plate on its rod with both at angles [rad] to the plumb line."""
    layup = lm.Laminate(lm.Isotropic(E=70e9, nu=0.3, rho=RHO), thickness=THICKNESS)
    hook = ROD * np.array([0.0, np.sin(rod), -np.cos(rod)])
    corner = hook + HEIGHT * np.array([0.0, np.sin(plate), -np.cos(plate)]) - np.array([0.5 * WIDTH, 0.0, 0.0])
    system, ground = lm.System(), lm.Ground()
    system.add(ground)
    given = {"position": tuple(corner), "rotation": (0.5 * np.pi + plate, 0.0, 0.0)}
    body = system.add(lm.Plate("plate", (WIDTH, HEIGHT), (1, 1), layup, **given))
    system.add(lm.DistanceJoint("rod", ground.marker("peg", 0, 0, 0), body.marker("hook", 0.5 * WIDTH, HEIGHT)))
    system.add(lm.Gravity("weight", (0, 0, -G)))
    return system


def run() -> Iterator[Evidence]:
    """Yield the checks and pictures of this case."""
    references = References.beside(__file__)
    omega, shapes = double_pendulum()
    weight = WIDTH * HEIGHT * THICKNESS * RHO * G
    for mode, name in enumerate(("slow", "fast")):
        period = 2 * np.pi / omega[mode]
        system = hanging(*(ANGLE * shapes[:, mode]))
        result = lm.simulate(system, 2 * period, lm.GeneralizedAlpha(dt=period / 400, rho_inf=0.8))
        position = result["hook.position"].values
        t, y = result.at, position[:, 1]
        k = np.flatnonzero(y[:-1] * y[1:] < 0)
        crossings = t[k] - y[k] * (t[k + 1] - t[k]) / (y[k + 1] - y[k])
        source, why = "double pendulum", "(omega dt)^2 = 2.5e-4 with 400 steps in a period"
        yield Check(
            f"period of the {name} swing", 2 * np.diff(crossings).mean(), period, 2e-4, source=source, unit="s", reason=why
        )
        yield references.check(f"stretch of the rod, {name} swing", np.abs(np.linalg.norm(position, axis=1) / ROD - 1).max())
        swing = ROD * np.sin(ANGLE * shapes[0, mode]) * np.cos(omega[mode] * t)
        yield Curves(f"The {name} swing", "Time [s]", "y of the hook [m]", {"lamella": (t, y)}, {"double pendulum": (t, swing)})
        late = t > 0.5 * period
        yield references.check(f"mean tension / weight, {name} swing", result["rod.tension"].values[late].mean() / weight)
