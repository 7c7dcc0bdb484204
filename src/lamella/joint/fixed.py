"""The fixed joint: two markers, an edge and a body, or two edges."""

from __future__ import annotations

import numpy as np

from lamella.body.base import Marker
from lamella.body.plate import Edge
from lamella.body.plate_frame import vanishing
from lamella.declaration import declaration
from lamella.dofs import Build
from lamella.errors import DeclarationError
from lamella.joint.base import Joint
from lamella.joint.clamped_edge import Clamping, clamped_rows
from lamella.joint.edge_rows import edge_pair, node_vectors
from lamella.joint.equations import Rows, coincident, same_orientation
from lamella.joint.rows import centre
from lamella.kinematics import Frame


@declaration
class FixedJoint(Joint):
    """Two bodies are fixed to each other.

    Between markers: r_b - r_a = 0 and all axes of both frames stay parallel.

    Between a marker of a rigid body (or of the ground, or a point of another plate) and an edge of a plate: every node vector of
    the edge is fixed in the marker's frame, r = r_a + R s, and r_x, r_y, r_xy turn with R. The rows are linear and eliminated, so
    the edge is an exact part of the body and costs nothing. The kinds ``restrained`` and ``sliding`` leave the plate free to
    strain in its plane at the edge, as those of :class:`Clamp`, in the frame of the marker; what they hold along the frame's axes
    takes multipliers.

    Between two edges: position, slopes and twist of both are the same at every node, which welds two plates that continue each
    other in the reference configuration.

    Args:
        name: unique name.
        a: a marker, or an edge of a plate.
        b: a marker, or an edge of a plate; a joint of a marker and an edge has the edge here.
        kind: ``full``, ``restrained`` or ``sliding``; all but ``full`` are for a marker and an edge.
    """

    name: str
    a: Marker | Edge
    b: Marker | Edge
    kind: Clamping = "full"

    def contribute(self, build: Build) -> None:
        """Add the rows and the reaction on b."""
        if self.kind != "full" and not (isinstance(self.a, Marker) and isinstance(self.b, Edge)):
            raise DeclarationError(
                self.item, f"kind '{self.kind}' of {self.a} and {self.b}", "accepted are a marker and an edge, or the kind 'full'"
            )
        if isinstance(self.a, Marker) and isinstance(self.b, Marker):
            super().contribute(build)
        elif isinstance(self.a, Marker) and isinstance(self.b, Edge):
            if self.a.body.name == self.b.body.name:
                raise DeclarationError(self.item, f"{self.a} and {self.b} are on one body", "accepted are places of two bodies")
            frame = self.a.frame(build, self.axes())
            rows = clamped_rows(self.item, build, self.b, frame, self.kind, f"in the frame of {self.a}")
            build.hold(self.name, rows, centre(build, self.b), self.b.body.name, frame, edge=True)
            if self.kind == "full":
                build.fully_clamped.append((self.name, self.b.body.name))
        elif isinstance(self.a, Edge) and isinstance(self.b, Edge):
            build.hold(self.name, self._weld(build, self.a, self.b), centre(build, self.b), self.b.body.name, edge=True)
        else:
            raise DeclarationError(self.item, f"a is the edge {self.a} and b the marker {self.b}", "accepted is the marker as a")

    def equations(self, a: Frame, b: Frame) -> Rows:
        return [*coincident(self.name, a, b), *same_orientation(self.name, a, b)]

    def _weld(self, build: Build, a: Edge, b: Edge) -> Rows:
        """All vectors of both edges' nodes are the same; the parameters of both plates must run alike."""
        pair = edge_pair(self.item, build, a, b)
        on_a, on_b = node_vectors(pair.mesh_a, a), node_vectors(pair.mesh_b, b)
        initial = build.initial
        alike = len(on_a) == len(on_b) and all(
            np.allclose(u.at(initial), w.at(initial), atol=1e-6) for u, w in zip(on_a.values(), on_b.values(), strict=True)
        )
        if not alike:
            raise DeclarationError(
                self.item,
                f"the nodes of {a} and {b} do not have the same positions and slopes",
                "accepted are plates of one element, with the same mesh along the edge and axes x and y of the same directions",
            )
        return [
            row
            for (node, name), u, w in zip(on_b, on_a.values(), on_b.values(), strict=True)
            for row in vanishing(w - u, f"{name} at node {node} of edge {b} less that of edge {a}")
        ]
