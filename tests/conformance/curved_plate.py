"""A plate whose reference configuration is bent by hand: a piece of a cylinder or cone with parameters that are no lengths."""

from __future__ import annotations

import numpy as np

import lamella as lm
from lamella.math.rotation import matrix_from_vector
from lamella.roles import Declaration

SIZE, RADIUS, STRETCH = (1.5, 0.8), 0.9, 1.7
PLACE, TURN = np.array((0.4, -0.2, 0.3)), (0.1, -0.3, 0.7)
R = matrix_from_vector(np.array(TURN))
SECTION = lm.Laminate(lm.Isotropic(E=2e9, nu=0.3, rho=1200.0), thickness=0.02)


def nodal_vectors(x, y, cone=0.0, skew=0.0, start=(0.0, 0.0), rate=1.0):
    """r, r_x, r_y, r_xy of a cone about the axis of y with the radius RADIUS + cone Y, Y = STRETCH y, from its angle x / RADIUS.

    ``skew`` lets the lines of constant x wind about the axis: the angle is x / RADIUS + skew y. Parameters begin at ``start``,
    and x grows at ``rate`` times that of the plate.
    """
    x, y = start[0] + rate * x, start[1] + y
    angle, radius = x / RADIUS + skew * y, RADIUS + cone * STRETCH * y
    out, around, axis = np.array((np.cos(angle), 0, np.sin(angle))), np.array((-np.sin(angle), 0, np.cos(angle))), np.eye(3)[1]
    r = radius * out + STRETCH * y * axis
    r_x = radius / RADIUS * around
    r_y = cone * STRETCH * out + radius * skew * around + STRETCH * axis
    r_xy = cone * STRETCH / RADIUS * around - radius / RADIUS * skew * out
    return np.array([PLACE + R @ r, rate * R @ r_x, R @ r_y, rate * R @ r_xy])


class Bent(Declaration):
    """Gives the plate that was added before it another reference configuration."""

    def __init__(self, plate, **shape):
        self.name, self.plate, self.shape = f"bent {plate.name}", plate, shape

    def contribute(self, build) -> None:
        mesh = self.plate.compiled(build)
        vectors = [nodal_vectors(i * mesh.lx, j * mesh.ly, **self.shape) for j in range(mesh.ny + 1) for i in range(mesh.nx + 1)]
        number = list(build.bodies).index(self.plate.name)
        build.q[number][: 4 * mesh.n_nodes] = np.concatenate(vectors)


def bent_plate(system, name="plate", mesh=(6, 3), size=SIZE, **shape):
    """A bent plate in a system."""
    plate = lm.Plate(name, size, mesh, SECTION)
    system.add(plate)
    system.add(Bent(plate, **shape))
    return plate
