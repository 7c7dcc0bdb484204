"""Joints that fix lengths: the distance of two points, a cable over several."""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated

import numpy as np
from pydantic import Field

from lamella.body.base import Marker
from lamella.declaration import declaration
from lamella.dofs import Build, Signal
from lamella.errors import DeclarationError
from lamella.kinematics import VectorRows, vectors_of
from lamella.math.profile import LengthProfile
from lamella.measure.constraint import MeasureConstraint, MeasureRow
from lamella.measure.measure import length
from lamella.roles import Declaration, Floats
from lamella.state import State
from lamella.units import Thickness


@declaration
class DistanceJoint(Declaration):
    """Keep the distance of two markers, as a massless rod with ball ends does: Phi = |r_b - r_a| - L - p(t) = 0.

    The constraint is nonlinear and takes a Lagrange multiplier, which is the rod's axial force.

    Args:
        name: unique name; the result holds ``<name>.tension`` [N], positive in tension, and ``<name>.force`` [N] on marker b.
        a: first marker (may be on the ground).
        b: second marker.
        length: distance L [m]; the initial distance when left out.
        change: change p of the length as a function of time [m]: a linear actuator.
    """

    name: str
    a: Marker
    b: Marker
    length: Thickness | None = None
    change: LengthProfile | None = None

    def contribute(self, build: Build) -> None:
        """Add one nonlinear constraint and its signals."""
        d = self.b.rows(build).point - self.a.rows(build).point
        distance = _initial_length(build, f"DistanceJoint '{self.name}'", d, f"{self.a} and {self.b}")
        row = MeasureRow(f"the distance '{self.name}'", (length(d),), self.length or distance, self.change)
        block = MeasureConstraint(self.name, [row])
        build.constrain(block)

        def force(state: State) -> Floats:
            between = d.at(vectors_of(state.q))
            return -state.lam[block.first] * between / np.linalg.norm(between)

        build.signals.append(_tension(self.name, block))
        build.signals.append(Signal(f"{self.name}.force", "N", ("x", "y", "z"), force, f"force on {self.b}"))


@declaration
class Cable(Declaration):
    """A massless cable of fixed length that runs freely over several points: Phi = sum_i |r_i+1 - r_i| - L - p(t) = 0.

    Its tension, the Lagrange multiplier, is the same in all spans. It is a constraint both ways: where the tension turns negative
    a real cable would go slack.

    Args:
        name: unique name; the result holds ``<name>.tension`` [N].
        points: markers in the order in which the cable runs over them, at least two.
        closed: whether the cable runs back from the last to the first.
        length: length L [m]; the initial length when left out.
        change: change p of the length as a function of time [m]: a winch.
    """

    name: str
    points: Annotated[tuple[Marker, ...], Field(min_length=2)]
    closed: bool = False
    length: Thickness | None = None
    change: LengthProfile | None = None

    def contribute(self, build: Build) -> None:
        """Add one nonlinear constraint and its tension."""
        markers = [*self.points, self.points[0]] if self.closed else list(self.points)
        rows = [marker.rows(build).point for marker in markers]
        spans = [after - before for before, after in pairwise(rows)]
        item = f"Cable '{self.name}'"
        lengths = [
            _initial_length(build, item, span, f"{a} and {b}") for span, (a, b) in zip(spans, pairwise(markers), strict=True)
        ]
        moving = tuple(length(span) for span in spans if len(span.vectors))
        still = sum(size for size, span in zip(lengths, spans, strict=True) if not len(span.vectors))
        if not moving:
            raise DeclarationError(item, "none of its points can move", "accepted is a cable with a point on a body")
        row = MeasureRow(f"the cable '{self.name}'", moving, (self.length or sum(lengths)) - still, self.change)
        block = MeasureConstraint(self.name, [row])
        build.constrain(block)
        build.signals.append(_tension(self.name, block))


def _tension(name: str, block: MeasureConstraint) -> Signal:
    return Signal(f"{name}.tension", "N", (), lambda state: float(state.lam[block.first]), f"tension in {name}")


def _initial_length(build: Build, item: str, d: VectorRows, points: str) -> float:
    """Length of a vector in the reference configuration [m]; points that coincide have no direction."""
    distance = float(np.linalg.norm(d.at(build.initial)))
    if distance == 0.0:
        raise DeclarationError(item, f"{points} coincide", "accepted are distinct points")
    return distance
