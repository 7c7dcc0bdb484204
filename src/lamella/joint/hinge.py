"""The hinge between two edges of plates."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from lamella import units
from lamella.body.plate import Edge
from lamella.body.plate_frame import vanishing
from lamella.declaration import declaration
from lamella.dofs import Build
from lamella.errors import DeclarationError
from lamella.joint.edge_rows import EdgePair, along_and_outward, edge_pair
from lamella.joint.equations import Rows
from lamella.joint.motion_signals import angle_signals
from lamella.math.gauss import gauss_rule
from lamella.measure.measure import Term, angle
from lamella.roles import Declaration


@declaration
class EdgeHinge(Declaration):
    """Two plates share an edge and turn about it freely (a piano hinge), or are joined at single points of it.

    Along the whole edge position and tangent of both edges are the same at every node, so the cubic edges are one curve; the
    slopes across and the twists r_xy stay free on each side. At points only the positions are the same. All rows are linear and
    eliminated.

    The result holds the force ``<name>.force`` [N] and the torque ``<name>.torque`` [N m] about the middle of the edge that the
    hinge exerts on b's plate, ``<name>.angle`` [rad] at the middle of the edge, zero where the plates continue each other, and
    its rate. The angle is positive when b has turned right-handed about the direction in which the parameter along a's edge
    grows.

    Args:
        name: unique name.
        a: edge of a plate.
        b: edge of another plate that coincides with a in the reference configuration.
        points: parameters (lengths on a flat plate) along a's edge at which the plates are joined [m]; the whole edge when left
            out.
    """

    name: str
    a: Edge
    b: Edge
    points: tuple[units.Length, ...] | None = None

    @property
    def item(self) -> str:
        """The hinge in messages."""
        return f"EdgeHinge '{self.name}'"

    def contribute(self, build: Build) -> None:
        """Add rows, reaction and the hinge's angle."""
        pair = edge_pair(self.item, build, self.a, self.b)
        middle = pair.on_a(0.5 * pair.length)
        build.hold(self.name, self._rows(pair), middle.point, self.b.body.name, edge=self.points is None)
        build.signals.extend(angle_signals(self.name, self.turns_at(pair, (0.5,))[0]))

    def turns_of(self, build: Build) -> list[Term]:
        """The hinge's angle as terms whose factors sum to 1: at its points, or at Gauss points weighed by reference length."""
        pair = edge_pair(self.item, build, self.a, self.b)
        if self.points is not None:
            return self.turns_at(pair, tuple(s / pair.length for s in self.points))
        places, weights = gauss_rule(2)
        spans = list(zip(pair.nodes[:-1] / pair.length, pair.nodes[1:] / pair.length, strict=True))
        turns = self.turns_at(pair, tuple(lo + (hi - lo) * place for lo, hi in spans for place in places))
        parameters = [weight * (hi - lo) for lo, hi in spans for weight in weights]
        initial = build.initial
        lengths = [ds * np.linalg.norm(turn.vectors[2].at(initial)) for ds, turn in zip(parameters, turns, strict=True)]
        return [replace(turn, factor=float(ds / sum(lengths))) for ds, turn in zip(lengths, turns, strict=True)]

    def turns_at(self, pair: EdgePair, places: tuple[float, ...]) -> list[Term]:
        """What turns at relative places in [0, 1] along a's edge: outward of a into inward of b, about the edge."""
        found = []
        for place in places:
            along, out_of_a = along_and_outward(self.a, pair.on_a(place * pair.length))
            _, out_of_b = along_and_outward(self.b, pair.on_b(place * pair.length))
            found.append(angle(out_of_a, -out_of_b, along, 1.0 / len(places)))
        return found

    def _rows(self, pair: EdgePair) -> Rows:
        if self.points is None:
            if not pair.nested:
                raise DeclarationError(
                    self.item,
                    f"the meshes of {self.a} and {self.b} do not fit each other",
                    "accepted are edges with the same number of elements, or one a multiple of the other",
                )
            rows: Rows = []
            for s in pair.nodes.tolist():
                label = f"{self.a} and {self.b} at {s:g} m"
                rows += vanishing(pair.gap(s), f"the distance of {label}")
                rows += vanishing(pair.tangent_gap(s), f"the tangents of {label}")
            return rows
        if not self.points or not all(0.0 <= s <= pair.length for s in self.points) or len(set(self.points)) < len(self.points):
            raise DeclarationError(
                self.item, f"points = {list(self.points)}", f"accepted are distinct lengths from 0 to {pair.length:g} m"
            )
        return [row for s in self.points for row in vanishing(pair.gap(s), f"the distance of {self.a} and {self.b} at {s:g} m")]
