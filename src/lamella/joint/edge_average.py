"""Edges that are held, moved or carried in the mean and free to deform otherwise."""

from __future__ import annotations

import numpy as np
from pydantic import Field

from lamella.body.base import Marker
from lamella.body.mesh import PlateMesh
from lamella.body.plate import Edge
from lamella.body.plate_frame import vanishing
from lamella.body.quadrature import edge_quadrature
from lamella.declaration import declaration
from lamella.dofs import Build, DotRow
from lamella.errors import DeclarationError
from lamella.joint.clamp import check_axes
from lamella.joint.edge_rows import ROUNDING, edge_mean
from lamella.joint.equations import Rows
from lamella.joint.rows import AXES, carried
from lamella.kinematics import Frame, VectorRows
from lamella.math.profile import LengthProfile
from lamella.roles import Declaration, Floats


@declaration
class EdgeAverage(Declaration):
    """The mean position and rotation of an edge are held, moved, or carried by another body; it is free to deform otherwise.

    In the axes d_1, d_2, d_3 and about the origin o of a frame, with means < > over the reference length of the edge, y_k =
    d_k.(r - o) and their reference values Y_k:

        axes:       <y_k> - <Y_k> = p_k(t)
        rotations:  <Y_i' y_j - Y_j' y_i> = 0 about d_k, (i, j, k) cyclic,      Y' = Y - <Y>

    so a mean rotation is that of least squares, the polar decomposition's, for which the moments of the displacements seen in the
    frame about its axes vanish; it is exact for large rotations. The frame is the inertial one, or with ``to`` one that moves
    with a marker and has the inertial axes in the reference configuration. Forces on the edge are spread over its length as a
    dead load is. Rotations, and single axes, of a frame that moves take multipliers.

    Args:
        name: unique name; the result holds ``<name>.force`` [N] and ``<name>.torque`` [N m] on the plate about the edge's mean
            position.
        on: the edge.
        axes: letters of the components of the mean position held; may be empty beside ``rotations``.
        rotations: letters of the axes about which the mean rotation is held.
        motion: displacement p [m] along axes that are held, each a function of time; without ``to``.
        to: a marker of another body that carries the edge.
    """

    name: str
    on: Edge
    axes: str = "xyz"
    rotations: str = ""
    motion: dict[str, LengthProfile] = Field(default_factory=dict)
    to: Marker | None = None

    def __post_init__(self) -> None:
        if self.axes or not self.rotations:
            check_axes(self, self.axes)
        if self.rotations:
            check_axes(self, self.rotations)
        if not set(self.motion) <= set(self.axes) or (self.motion and self.to is not None):
            carried = f" with '{self.to}'" if self.to is not None else ""
            raise DeclarationError(
                self.item,
                f"a motion along {', '.join(sorted(self.motion))} of a mean held along '{self.axes}'{carried}",
                "accepted are motions along axes that are held, in space",
            )

    @property
    def item(self) -> str:
        """The average in messages."""
        return f"EdgeAverage '{self.name}'"

    def contribute(self, build: Build) -> None:
        """Add a row for each component and each rotation."""
        mesh = self.on.body.compiled(build)
        if self.to is not None and self.to.body.name == mesh.name:
            raise DeclarationError(self.item, f"{self.to} and {self.on} are on one body", "accepted are places of two bodies")
        x, y, z = (VectorRows.fixed(axis) for axis in np.eye(3))
        frame = Frame(VectorRows.fixed(np.zeros(3)), (x, y, z))
        if self.to is not None:
            frame = self.to.frame(build, np.eye(3))
        initial = build.initial
        mean = edge_mean(mesh, self.on, initial)
        offset, label = mean - frame.origin, f"the mean position of edge {self.on}"
        rows: Rows = []
        if self.to is not None and set(self.axes) == set(AXES):
            rows += vanishing(offset - carried(initial, offset.at(initial), frame), label)
        else:
            for axis in self.axes:
                direction = frame.axes[AXES.index(axis)]
                value = float(offset.at(initial) @ direction.at(initial))
                rows.append(DotRow(f"{axis} of {label}", ((1.0, offset, direction),), value, self.motion.get(axis)))
        rows += [self._turn(axis, mesh, initial, frame) for axis in self.rotations]
        side = mesh.name if self.to is not None else None
        build.hold(self.name, rows, mean, side, frame if self.to is not None else None)

    def _turn(self, axis: str, mesh: PlateMesh, initial: Floats, frame: Frame) -> DotRow:
        """The row <Y_i' y_j - Y_j' y_i> = 0; as <Y'> = 0, y may be taken about the edge's mean or any other point."""
        k = AXES.index(axis)
        i, j = (k + 1) % 3, (k + 2) % 3
        points, weights = edge_quadrature(mesh, self.on.side, initial)
        shares = weights.reshape(-1) / weights.sum()
        Y = np.array([rows.at(initial) for rows in points]) @ frame.rotation(initial)
        Y -= shares @ Y
        spread = float(np.sqrt(shares @ np.sum(Y**2, axis=1)))
        if np.sqrt(shares @ (Y[:, i] ** 2 + Y[:, j] ** 2)) < ROUNDING * spread:
            raise DeclarationError(
                self.item,
                f"the mean rotation of edge {self.on} about {axis}, on which it lies",
                "accepted are rotations about axes that are not along a straight edge",
            )

        def moment(component: int) -> VectorRows:
            weighed = zip(shares * Y[:, component] / spread, points, strict=True)
            return sum((float(share) * rows.point for share, rows in weighed), VectorRows.fixed(np.zeros(3)))

        terms = ((1.0, moment(i), frame.axes[j]), (-1.0, moment(j), frame.axes[i]))
        return DotRow(f"mean rotation of edge {self.on} about {axis}", terms)
