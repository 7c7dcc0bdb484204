"""What every body offers: coordinates at compilation, and markers."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from lamella.dofs import PointRows
from lamella.roles import Declaration

if TYPE_CHECKING:
    from lamella.dofs import Build


class Body(Declaration):
    """A body: it numbers its coordinate vectors and locates its points."""

    order: ClassVar[int] = 0

    @abstractmethod
    def locate(self, build: Build, at: tuple[float, ...]) -> PointRows:
        """Weights of the material point ``at``; its meaning (x, y on a plate; x, y, z in space) is the body's."""


@dataclass(frozen=True)
class Marker:
    """A named point of a body, made by the body's ``marker`` method."""

    body: Body
    name: str
    at: tuple[float, ...]

    def __str__(self) -> str:
        return f"{self.body.name}.{self.name}"

    def rows(self, build: Build) -> PointRows:
        """Weights of the coordinate vectors that make this point."""
        return self.body.locate(build, self.at)
