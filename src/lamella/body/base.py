"""What every body offers: coordinates at compilation, markers, and frames for joints."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from lamella.kinematics import Frame, PointRows
from lamella.roles import Declaration, Floats

if TYPE_CHECKING:
    from lamella.dofs import Build


class Body(Declaration):
    """A body: it numbers its coordinate vectors, locates its points, and carries frames."""

    order: ClassVar[int] = 0
    has_axes: ClassVar[bool] = False
    """Whether its frames are made of vectors it has anyway."""

    @abstractmethod
    def locate(self, build: Build, at: tuple[float, ...]) -> PointRows:
        """Weights of the material point ``at``; its meaning (x, y on a plate; x, y, z in space) is the body's."""

    @abstractmethod
    def frame(self, build: Build, at: tuple[float, ...], axes: Floats) -> Frame:
        """A frame at the material point ``at`` that moves with the body.

        Args:
            build: the build.
            at: the point.
            axes: its axes in the reference configuration as columns, in the inertial frame, shape (3, 3).
        """


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

    def frame(self, build: Build, axes: Floats) -> Frame:
        """The frame at this point with the given axes in the reference configuration, see :meth:`Body.frame`."""
        return self.body.frame(build, self.at, axes)
