"""The compiled form of a temperature field: two values at each node of a plate, bilinear between them."""

from __future__ import annotations

import numpy as np

from lamella.body.mesh import PlateMesh
from lamella.dofs import Build
from lamella.element.plate48.heated import NODES
from lamella.errors import DeclarationError
from lamella.math.gauss import gauss_rule
from lamella.roles import Floats, Ints

TYPICAL = 100.0
"""Typical change of a temperature [K]."""
NAMES = ("T_N", "T_M")


class TemperatureMesh:
    """T = T_0 + T_N + z T_M on a plate; node k holds T_N at coordinate first + 2 k and T_M behind it.

    Args:
        name: the field's name.
        plate: the compiled plate.
        reference: temperature T_0 at which the plate is free of stress [K].
    """

    def __init__(self, name: str, plate: PlateMesh, reference: float) -> None:
        self.name, self.plate, self.reference, self.first = name, plate, reference, -1
        self.magnitude: Floats = np.tile([TYPICAL, TYPICAL / plate.laminate.h], plate.n_nodes)
        self.uniform: Floats = np.tile([TYPICAL, 0.0], plate.n_nodes)
        j, i = np.divmod(np.arange(plate.nx * plate.ny), plate.nx)
        self._corners = np.stack([(j + b) * (plate.nx + 1) + i + a for a, b in NODES], axis=1)

    def place(self, build: Build, T_N: float, T_M: float) -> None:
        """Number the values and give them their initial values."""
        self.first = build.scalars(self, np.tile([T_N, T_M], self.plate.n_nodes))
        nodes = self.first + 2 * self._corners
        self.coords: Ints = np.concatenate([nodes, nodes + 1], axis=1)
        """Coordinates of T_N at an element's four nodes and then of T_M, shape (n_element, 8)."""

    def describe(self, coordinate: int) -> str:
        """A value in words, by its coordinate."""
        node, which = divmod(coordinate - self.first, 2)
        j, i = divmod(node, self.plate.nx + 1)
        return f"temperature {NAMES[which]} at node ({i}, {j}) of plate '{self.plate.name}'"

    def weights(self, x: Floats, y: Floats) -> tuple[Ints, Floats]:
        """Elements of points (x, y) [m] of the plate, shape (n,), and the bilinear functions there, shape (n, 4)."""
        p = self.plate
        i, j = np.minimum((x / p.lx).astype(int), p.nx - 1), np.minimum((y / p.ly).astype(int), p.ny - 1)
        xi, eta = x / p.lx - i, y / p.ly - j
        return j * p.nx + i, np.stack([(xi if a else 1 - xi) * (eta if b else 1 - eta) for a, b in NODES], axis=-1)

    def at(self, q: Floats, x: Floats, y: Floats) -> tuple[Floats, Floats]:
        """T_N [K] and T_M [K/m] at points (x, y) [m], each of shape (n,), from all coordinates."""
        element, shape = self.weights(np.asarray(x, float), np.asarray(y, float))
        values = q[self.coords[element]]
        return (shape * values[:, :4]).sum(axis=1), (shape * values[:, 4:]).sum(axis=1)

    def height(self, side: str) -> float:
        """Height z of a side, ``top`` or ``bottom``, above the reference surface [m]."""
        return float(self.plate.laminate.z[-1 if side == "top" else 0])

    def integrals(self) -> tuple[Floats, Floats, Floats]:
        """Over an element: int N_a [m^2] (4,), int N_a N_b [m^2] (4, 4) and int dN_a/dx_i dN_b/dx_j (2, 2, 4, 4)."""
        p, (s, w) = self.plate, gauss_rule(2)
        one, mixed = np.zeros(4), np.zeros((4, 4))
        slopes = np.zeros((2, 2, 4, 4))
        for xi, w_xi in zip(s, w, strict=True):
            for eta, w_eta in zip(s, w, strict=True):
                area = w_xi * w_eta * p.lx * p.ly
                N = np.array([(xi if a else 1 - xi) * (eta if b else 1 - eta) for a, b in NODES])
                d = [
                    np.array([(2 * a - 1) * (eta if b else 1 - eta) / p.lx for a, b in NODES]),
                    np.array([(2 * b - 1) * (xi if a else 1 - xi) / p.ly for a, b in NODES]),
                ]
                one += area * N
                mixed += area * np.outer(N, N)
                slopes += area * np.array([[np.outer(u, v) for v in d] for u in d])
        return one, mixed, slopes


class ElementSum:
    """sum over elements of w . q_e, with the weights collected node by node.

    Args:
        coords: coordinates of the elements, shape (n_element, m).
        weights: w, the same for all elements, shape (m,).
    """

    def __init__(self, coords: Ints, weights: Floats) -> None:
        self._coords, places = np.unique(coords, return_inverse=True)
        self._weights = np.bincount(places.reshape(-1), np.tile(weights, len(coords)))

    def __call__(self, q: Floats) -> float:
        """The sum for all coordinates q (n_q,)."""
        return float(self._weights.dot(q.take(self._coords)))


def field_of(build: Build, plate: PlateMesh, item: str) -> TemperatureMesh:
    """The temperature field of a plate.

    Raises:
        DeclarationError: the plate has none.
    """
    for field in build.fields:
        if isinstance(field, TemperatureMesh) and field.plate is plate:
            return field
    raise DeclarationError(
        item, f"plate '{plate.name}' has no temperature field", f"add TemperatureField(..., on={plate.name}) to the system"
    )
