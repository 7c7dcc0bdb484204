"""Forces written in Python."""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, ClassVar

import numpy as np
from pydantic import Field

from lamella.body.base import Marker
from lamella.declaration import declaration
from lamella.dofs import Build, Signal
from lamella.errors import DeclarationError
from lamella.load.user_block import UserForceBlock
from lamella.roles import Declaration, Floats
from lamella.state import State


@declaration
class UserForce(Declaration):
    """Forces on markers that a Python function gives: Q = sum_i S_i^T F_i(t, r, v).

    It is an external load: statics scales it with the load factor, and its work is part of ``work.loads``. A model file cannot
    hold it, because nothing in a model file is executed.

    Args:
        name: unique name; the result holds the sum of its forces ``<name>.force`` [N].
        on: the markers on which it acts, n of them.
        function: F(t, r, v), forces [N] in the inertial frame, shape (n, 3), from the time [s] and the markers' positions r [m]
            and velocities v [m/s], both (n, 3).
        tangent: gives dF/dr [N/m] and dF/dv [N s/m] from the same arguments, each (3 n, 3 n), with component c of marker i in row
            or column 3 i + c. It is compared with differences once in a run, and refused if it is another. Central differences
            take its place when it is left out, at 12 n evaluations for each tangent.
        potential: whether the forces are the derivative of a potential, -dV/dr, and do not depend on v; the equations then stay
            symmetric.
    """

    python_only: ClassVar[bool] = True
    name: str
    on: Annotated[tuple[Marker, ...], Field(min_length=1)]
    function: Callable[[float, Floats, Floats], Floats]
    tangent: Callable[[float, Floats, Floats], tuple[Floats, Floats]] | None = None
    potential: bool = False

    def contribute(self, build: Build) -> None:
        """Add the force and the signal of its sum."""
        points = [marker.rows(build).point for marker in self.on]
        if not any(len(point.vectors) for point in points):
            places = " and ".join(map(str, self.on))
            raise DeclarationError(f"UserForce '{self.name}'", f"{places} cannot move", "accepted is a marker of a body")
        moved = np.unique(np.concatenate([point.vectors for point in points]))
        size = float(np.concatenate(build.magnitude)[moved].max())
        labels = [str(marker) for marker in self.on]
        block = UserForceBlock(self.name, points, labels, size, self.function, self.tangent, potential=self.potential)
        build.loads.append(block)

        def total(state: State) -> Floats:
            return state.factor * block.forces(state.t, state.q, state.v).sum(axis=0)

        build.signals.append(Signal(f"{self.name}.force", "N", ("x", "y", "z"), total, f"sum of the forces of {self.name}"))
