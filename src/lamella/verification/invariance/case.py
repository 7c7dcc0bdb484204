"""The same plate described in other ways gives the same answer."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

import lamella as lm
from lamella.math.rotation import matrix_from_vector
from lamella.verification import Check, References

slow = False

SIZE, MESH = (1.5, 1.0), (3, 2)
ANGLES = (0.0, 30.0, 90.0)
AT = (1.2, 0.8)


@dataclass(frozen=True)
class View:
    """A way to describe the same plate.

    Args:
        rotation: turns the whole model [rad].
        position: moves the whole model [m].
        exchanged: the plate's x and y axes change places, so that nodes are numbered along the other direction.
        length, mass: size of the units, in m and kg; the unit of time stays.
    """

    rotation: tuple[float, float, float] = (0.0, 0.0, 0.0)
    position: tuple[float, float, float] = (0.0, 0.0, 0.0)
    exchanged: bool = False
    length: float = 1.0
    mass: float = 1.0

    @property
    def R(self) -> np.ndarray:
        """Rotation of the whole model."""
        return matrix_from_vector(np.asarray(self.rotation))

    def back(self, r: np.ndarray) -> np.ndarray:
        """Positions (as rows) in the original description [m]."""
        return (r * self.length - np.asarray(self.position)) @ self.R


VIEWS = {
    "turned": View(rotation=(0.7, -1.2, 0.5)),
    "moved": View(position=(3.0, -2.0, 5.0)),
    "with x and y exchanged": View(exchanged=True),
    "in millimetres and tonnes": View(length=1e-3, mass=1e3),
    "all at once": View((0.7, -1.2, 0.5), (3.0, -2.0, 5.0), True, 1e-3, 1e3),
}


def described(view: View) -> lm.System:
    """A laminate clamped on its edge x = 0 with a force at (1.2, 0.8), in a description of its own.

    Exchanged axes: y' = x and x' = W - y keep the normal; fibres turn by -90 degrees, so angles from the new x axis grow by 90.
    """
    L, F = view.length, view.mass * view.length
    P = view.mass / view.length  # unit of stress
    ply = lm.Lamina(E1=181e9 / P, E2=10.3e9 / P, G12=7.7e9 / P, nu12=0.28, rho=1560 * L**3 / view.mass)
    turn, origin, size, mesh, at, edge, angles = view.R, np.zeros(3), SIZE, MESH, AT, "x-", ANGLES
    if view.exchanged:
        turn = turn @ np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
        origin, size, mesh = np.array([0.0, SIZE[1], 0.0]), (SIZE[1], SIZE[0]), (MESH[1], MESH[0])
        at, edge, angles = (SIZE[1] - AT[1], AT[0]), "y-", tuple(angle + 90.0 for angle in ANGLES)
    layup = lm.Laminate(ply, angles=angles, thickness=1.5e-3 / L)
    place = (view.R @ origin + view.position) / L
    system = lm.System()
    given = {"position": tuple(place), "rotation": rotation_vector(turn)}
    plate = system.add(lm.Plate("plate", (size[0] / L, size[1] / L), mesh, layup, **given))
    system.add(lm.Clamp("root", plate.edge(edge)))
    force = view.R @ np.array([0.0, 0.0, -10.0]) / F
    system.add(lm.PointForce("load", plate.marker("tip", at[0] / L, at[1] / L), tuple(force)))
    return system


def rotation_vector(R: np.ndarray) -> tuple[float, float, float]:
    """Rotation vector of a rotation by less than pi."""
    axis = np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
    sine, cosine = 0.5 * np.linalg.norm(axis), 0.5 * (np.trace(R) - 1.0)
    vector = axis / (2.0 * sine) * np.arctan2(sine, cosine) if sine else np.zeros(3)
    return (float(vector[0]), float(vector[1]), float(vector[2]))


def solved(view: View) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Static position of the tip, its path in motion (both taken back) and the clamp's static force in the original axes [N]."""
    system, newton = described(view), lm.Newton(tolerance=1e-11, keep=0.0)
    still = lm.equilibrium(system, newton=newton)
    moving = lm.simulate(system, 0.05, lm.GeneralizedAlpha(dt=1e-3, newton=lm.Newton(tolerance=1e-10)))
    force = still["root.force"].values * view.mass * view.length @ view.R
    return view.back(still["tip.position"].values), view.back(moving["tip.position"].values), force


def run() -> Iterator[Check]:
    """Yield the checks of this case."""
    references = References.beside(__file__)
    still, path, force = solved(View())
    at_rest = np.array([*AT, 0.0])
    for name, view in VIEWS.items():
        other_still, other_path, other_force = solved(view)
        change = float(np.linalg.norm(other_still - still) / np.linalg.norm(still - at_rest))
        yield references.check(f"static deflection {name}", change)
        yield references.check(f"clamp's force {name}", float(np.linalg.norm(other_force - force)) / 10.0)
        yield references.check(f"motion {name}", np.abs(other_path - path).max() / np.abs(path - at_rest).max())
