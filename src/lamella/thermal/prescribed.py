"""Temperatures that are given."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from lamella import units
from lamella.body.plate import Edge, Plate
from lamella.declaration import declaration
from lamella.dofs import Build, LinearRow, Motion
from lamella.kinematics import VectorRows
from lamella.math.profile import Constant, Profile
from lamella.roles import Declaration
from lamella.thermal.mesh import NAMES, field_of


@dataclass(frozen=True)
class Scaled:
    """A factor times a function of time."""

    factor: float
    profile: Motion

    def value(self, t: float) -> float:
        """Value at the time t [s]."""
        return self.factor * self.profile.value(t)

    def rate(self, t: float) -> float:
        """First derivative by time."""
        return self.factor * self.profile.rate(t)

    def acceleration(self, t: float) -> float:
        """Second derivative by time."""
        return self.factor * self.profile.acceleration(t)

    @property
    def breakpoints(self) -> tuple[float, ...]:
        """Times [s] at which it jumps."""
        return self.profile.breakpoints


@declaration
class PrescribedTemperature(Declaration):
    """Hold the temperature along an edge, or of a whole plate, at T_0 + (temperature - T_0) p(t), and its gradient.

    Args:
        name: unique name; the result holds ``<name>.heat`` [W], the heat that must be supplied.
        on: the edge or plate.
        temperature: temperature of the reference surface [K].
        gradient: gradient T_M through the thickness [K/m], times p(t) as well; None leaves it free.
        profile: p(t).
    """

    order: ClassVar[int] = 5
    name: str
    on: Edge | Plate
    temperature: units.Temperature
    gradient: units.TemperatureGradient | None = 0.0
    profile: Profile = Constant(1.0)

    def contribute(self, build: Build) -> None:
        """Hold the values at the nodes."""
        body = self.on.body if isinstance(self.on, Edge) else self.on
        plate = body.compiled(build)
        mesh = field_of(build, plate, f"PrescribedTemperature '{self.name}'")
        nodes = plate.edge_nodes(self.on.side) if isinstance(self.on, Edge) else np.arange(plate.n_nodes)

        def rows(which: int, level: float) -> list[LinearRow]:
            motion = Scaled(level, self.profile) if level else None
            return [
                LinearRow(
                    f"{NAMES[which]} of '{self.name}' at node {node} of '{plate.name}'",
                    np.array([mesh.first + 2 * node + which]),
                    np.ones(1),
                    0.0,
                    motion,
                )
                for node in nodes.tolist()
            ]

        somewhere = VectorRows.fixed(np.zeros(3))
        of_edge = isinstance(self.on, Edge)
        held = rows(0, self.temperature - mesh.reference)
        build.hold(self.name, held, somewhere, single=True, edge=of_edge, quantity=("heat", "W"))
        if self.gradient is not None:
            build.tie(rows(1, self.gradient))
