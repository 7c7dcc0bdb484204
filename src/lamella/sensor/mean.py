"""The mean position of a shell."""

from __future__ import annotations

import numpy as np
from pydantic import InstanceOf

from lamella.body.quadrature import surface_integrals
from lamella.body.shell_body import ShellBody
from lamella.body.signals import AXES
from lamella.declaration import declaration
from lamella.dofs import Build, Signal
from lamella.kinematics import VectorRows, vectors_of
from lamella.roles import Declaration, Floats
from lamella.state import State


@declaration
class MeanPosition(Declaration):
    """The position of a plate or shell, averaged over the area of its reference surface: <r> = 1/A int r dA.

    Of a belt that runs around its rollers it is what moves when the belt as a whole drifts, while each point of it goes to and
    fro in every turn.

    Args:
        name: unique name; the result holds ``<name>.position`` [m] and ``<name>.velocity`` [m/s].
        on: the plate or shell.
    """

    name: str
    on: InstanceOf[ShellBody]

    def contribute(self, build: Build) -> None:
        """Add the signals."""
        vectors, integrals = surface_integrals(self.on.compiled(build), build.initial)
        own, place = np.unique(vectors, return_inverse=True)
        weights = np.bincount(place.reshape(-1), integrals.reshape(-1))
        positions = np.concatenate(build.is_position)[own]
        mean = VectorRows(own, weights / weights[positions].sum(), np.zeros(3))
        what = f"of {self.on.name}, averaged over its area"

        def position(state: State) -> Floats:
            return mean.at(vectors_of(state.q))

        def moved(_: State, change: State) -> Floats:
            return mean.rate(vectors_of(change.q))

        def velocity(state: State) -> Floats:
            return mean.rate(vectors_of(state.v))

        build.signals += [
            Signal(f"{self.name}.position", "m", AXES, position, f"position {what}", derivative=moved, of_vectors=own),
            Signal(
                f"{self.name}.velocity",
                "m/s",
                AXES,
                velocity,
                f"velocity {what}",
                derivative=lambda _, change: velocity(change),
                of_vectors=own,
            ),
        ]
