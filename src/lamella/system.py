"""The system: what a user declares, compiled to a model."""

from __future__ import annotations

from typing import Literal, TypeVar, get_args

from lamella.body.base import Body
from lamella.dofs import Build
from lamella.errors import DeclarationError
from lamella.model import Model
from lamella.roles import Declaration

D = TypeVar("D", bound=Declaration)
Redundant = Literal["raise", "drop"]


class System:
    """An ordered collection of declarations with unique names.

    Args:
        redundant: what to do with joint constraints that repeat others: ``raise`` an error that names them, or ``drop`` them; the
            motion is then that of the mechanism, and the reactions are one of many possible distributions.
    """

    def __init__(self, redundant: Redundant = "raise") -> None:
        if redundant not in get_args(Redundant):
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

    def compile(self) -> Model:
        """Number the coordinates and make blocks, constraints and signals.

        Raises:
            ModelError: no body, or names of signals clash.
            DeclarationError: a declaration does not fit the others; it is named.
        """
        build = Build()
        for declaration in sorted(self.declarations, key=lambda item: item.order):
            declaration.contribute(build)
        return Model.from_build(build, self, self.redundant)
