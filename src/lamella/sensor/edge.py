"""Sensors at the edges of plates and shells: where an edge passes a plane, and the force along it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from lamella.body.base import Marker
from lamella.body.grid import Grid
from lamella.body.ground import Ground
from lamella.body.plate import Edge
from lamella.body.quadrature import N_GAUSS, edge_weights
from lamella.body.rigid import RigidBody
from lamella.body.signals import AXES
from lamella.declaration import declaration
from lamella.dofs import Build, Signal
from lamella.errors import DeclarationError
from lamella.kinematics import VectorRows, vectors_of
from lamella.math.gauss import gauss_rule
from lamella.math.rotation import matrix_from_vector
from lamella.roles import Declaration, Floats, Ints
from lamella.units import Number

if TYPE_CHECKING:
    from lamella.state import State

Direction = tuple[Number, Number, Number]


@declaration
class EdgeCrossing(Declaration):
    """The point at which an edge passes a plane: the edge of a web or belt under a sensor past which it runs.

    The edge is a cubic r(s) in each element, so the places where (r(s) - c).n = 0 are roots of cubics. Of several, as a closed
    belt has them, the one nearest to the marker c is taken; where there is none, the signal is not a number.

    Args:
        name: unique name; the result holds ``<name>.position`` [m], in the inertial frame.
        on: the edge.
        at: the marker c, of the ground or a rigid body.
        normal: the direction n across the plane, in the axes of the marker's body, along the way of the belt.
    """

    name: str
    on: Edge
    at: Marker
    normal: Direction = (1.0, 0.0, 0.0)

    @property
    def item(self) -> str:
        """The sensor in messages."""
        return f"EdgeCrossing '{self.name}'"

    def __post_init__(self) -> None:
        if not isinstance(self.at.body, (RigidBody, Ground)):
            raise DeclarationError(
                self.item, f"the marker {self.at} is on a deformable body", "accepted is a RigidBody's or the Ground's"
            )
        if not any(self.normal):
            raise DeclarationError(self.item, "normal = (0, 0, 0)", "accepted is a vector that is not zero")

    def contribute(self, build: Build) -> None:
        """Add the signal."""
        mesh = self.on.body.compiled(build)
        nodes = mesh.edge_nodes(self.on.side)
        slope = mesh.edge_slope(self.on.side)[0]
        length = mesh.lx if slope == "r_x" else mesh.ly
        if mesh.loops[slope == "r_y"]:
            nodes = np.append(nodes, nodes[0])
        r, r_s = (np.array([mesh.vector(int(node), name) for node in nodes]) for name in ("r", slope))
        s = np.asarray(length * np.arange(len(nodes)), float)
        axes = matrix_from_vector(np.asarray(self.at.body.rotation)) if isinstance(self.at.body, RigidBody) else np.eye(3)
        frame = self.at.frame(build, axes)
        normal = frame.x * self.normal[0] + frame.y * self.normal[1] + frame.z * self.normal[2]

        def position(state: State) -> Floats:
            return nearest_crossing(s, vectors_of(state.q), r, r_s, frame.origin, normal)

        build.signals.append(Signal(f"{self.name}.position", "m", AXES, position, f"where edge {self.on} passes {self.at}"))


@declaration
class EdgeTension(Declaration):
    """The membrane force along an edge, averaged over it [N/m].

    Args:
        name: unique name; the result holds ``<name>.mean`` [N/m].
        on: the edge of a plate or shell whose plies count from its first parameter.
    """

    name: str
    on: Edge

    def __post_init__(self) -> None:
        body = self.on.body
        if body.ply_direction is not None or body.strain == "rigid":
            given = "strain = 'rigid'" if body.strain == "rigid" else f"ply_direction = {body.ply_direction}"
            raise DeclarationError(
                f"EdgeTension '{self.name}'",
                f"'{body.name}' has {given}",
                "accepted is an elastic body whose axes of stress are along its parameters",
            )

    def contribute(self, build: Build) -> None:
        """Add the signal."""
        mesh, side = self.on.body.compiled(build), self.on.side
        along = 0 if mesh.edge_slope(side)[0] == "r_x" else 1
        places = (np.arange((mesh.nx, mesh.ny)[along])[:, None] + gauss_rule(N_GAUSS)[0]).reshape(-1)
        end = np.array([0.0 if side[1] == "-" else float((mesh.nx, mesh.ny)[1 - along])])
        weights = edge_weights(mesh, side, build.initial).reshape(-1)
        weights /= weights.sum()
        grid = Grid(mesh, *((places, end) if along == 0 else (end, places)))

        def mean(state: State) -> float:
            return float(weights @ grid.sample(state.q).section_forces()[..., along].reshape(-1))

        build.signals.append(Signal(f"{self.name}.mean", "N/m", (), mean, f"membrane force along edge {self.on}, averaged"))


def nearest_crossing(s: Floats, vectors: Floats, r: Ints, r_s: Ints, origin: VectorRows, normal: VectorRows) -> Floats:
    """Point of a curve of cubics in a plane through ``origin``, nearest to it; NaN where there is none.

    Args:
        s: parameter at the nodes.
        vectors: all coordinate vectors, shape (n_vectors, 3).
        r, r_s: numbers of the nodes' positions and slopes.
        origin: a point of the plane.
        normal: the plane's normal.
    """
    c, n = origin.at(vectors), normal.at(vectors)
    points, slopes = vectors[r] - c, vectors[r_s]
    from scipy.interpolate import CubicHermiteSpline  # imported late: some tenths of a second that most models never need

    roots = CubicHermiteSpline(s, points @ n, slopes @ n).roots(extrapolate=False)
    roots = roots[np.isfinite(roots)]  # an element that lies in the plane has no single place
    if not len(roots):
        return np.full(3, np.nan)
    found = CubicHermiteSpline(s, points, slopes)(roots)
    return c + found[np.argmin(np.linalg.norm(found, axis=1))]
