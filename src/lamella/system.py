"""The system: what a user declares, compiled to a model."""

from __future__ import annotations

from typing import Literal, TypeVar, get_args

import numpy as np

from lamella.body.base import Body
from lamella.body.shell_body import ShellBody
from lamella.dofs import Build
from lamella.errors import DeclarationError
from lamella.model import Model
from lamella.roles import Declaration, Floats

D = TypeVar("D", bound=Declaration)
RIGID = 1e-9
"""Share of an imperfection's largest change that is rounding on a rigid body."""
Redundant = Literal["raise", "drop"]


class System:
    """An ordered collection of declarations with unique names.

    Args:
        redundant: what to do with joint constraints that repeat others: ``raise`` an error that names them, or ``drop`` them; the
            motion is then that of the mechanism, and the reactions are one of many possible distributions.
    """

    def __init__(self, redundant: Redundant = "raise") -> None:
        if not isinstance(redundant, str) or redundant not in get_args(Redundant):
            raise DeclarationError("System", f"redundant = {redundant!r}", "accepted is 'raise' or 'drop'")
        self.redundant: Redundant = redundant
        self.declarations: list[Declaration] = []

    def add(self, declaration: D) -> D:
        """Add a body, joint or load and return it.

        Raises:
            DeclarationError: not a declaration, or its name is taken.
        """
        if not isinstance(declaration, Declaration):
            raise DeclarationError("System.add", f"{declaration!r} is not a declaration", "accepted is a body, joint or load")
        for other in self.declarations:
            if other.name == declaration.name:
                raise DeclarationError(
                    f"{type(declaration).__name__} '{declaration.name}'",
                    f"the name is taken by a {type(other).__name__}",
                    "every body, joint and load has its own name",
                )
        self.declarations.append(declaration)
        return declaration

    @property
    def bodies(self) -> list[Body]:
        """The bodies, in the order they were added."""
        return [item for item in self.declarations if isinstance(item, Body)]

    def compile(self, imperfection: Floats | None = None) -> Model:
        """Number the coordinates and make blocks, constraints and signals.

        Args:
            imperfection: a small change of all coordinates, added to the stress-free geometry of the elastic plates, such as
                ``modes.imperfection(0, 1e-4)``; the sum of several is one as well. Shape (n_q,).

        Raises:
            ModelError: no body, or names of signals clash.
            DeclarationError: a declaration does not fit the others; it is named. The imperfection does not fit the system.
        """
        build = Build()
        if imperfection is not None:
            build.imperfection = self._checked(imperfection)
        for declaration in sorted(self.declarations, key=lambda item: item.order):
            declaration.contribute(build)
        return Model.from_build(build, self, self.redundant)

    def _checked(self, imperfection: Floats) -> Floats:
        """An imperfection that has a value for each coordinate and leaves rigid bodies in place."""
        perfect, given = self.compile(), np.asarray(imperfection, float)
        if given.shape != perfect.q0.shape or not np.isfinite(given).all():
            accepted = f"accepted are {perfect.n_q} finite numbers, such as modes.imperfection(0, 1e-4) of the same system"
            raise DeclarationError("System.compile", f"an imperfection of shape {given.shape}", accepted)
        moved = np.abs(perfect.vectors(given / perfect.magnitude)).max(axis=1)
        rigid = [body.name for body in self.bodies if not (isinstance(body, ShellBody) and body.strain != "rigid")]
        for owner, size in zip(perfect.owners, moved, strict=True):
            if owner in rigid and size > RIGID * moved.max():
                raise DeclarationError(
                    "System.compile",
                    f"the imperfection moves the rigid body '{owner}'",
                    "accepted is one that moves plates alone",
                )
        return given
