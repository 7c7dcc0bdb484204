"""A surface through a table of points."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Literal

import numpy as np

from lamella.declaration import declaration
from lamella.errors import DeclarationError
from lamella.roles import Floats
from lamella.surface.base import Surface, SurfacePoints
from lamella.units import Length

if TYPE_CHECKING:
    from scipy.interpolate import BSpline

Point = tuple[Length, Length, Length]


@declaration
class PointSurface(Surface):
    """A spline surface through a grid of points; both parameters are mean chord lengths.

    The tensor product of interpolating splines of degree 5, or less where a row has fewer than six points; periodic where closed.

    Args:
        points: rows of points (x, y, z) [m]: each row runs along the first parameter, the rows follow the second one.
        closed: ``x`` for rows that close on themselves, ``y`` for columns, ``xy`` for both; the first point is not repeated.

    Raises:
        DeclarationError: rows of different length, too few points, or neighbours that coincide.
    """

    points: tuple[tuple[Point, ...], ...]
    closed: Literal["", "x", "y", "xy"] = ""
    kind: Literal["points"] = "points"

    def __post_init__(self) -> None:
        """Refuse what makes no grid."""
        counts = sorted({len(row) for row in self.points})
        if len(counts) != 1:
            self._refuse(f"rows of {counts[0]} and of {counts[-1]} points" if counts else "no rows", "rows of one length")
        for axis, count in (("x", counts[0]), ("y", len(self.points))):
            least = 3 if axis in self.closed else 2
            if count < least:
                self._refuse(f"{count} points along {axis}", f"at least {least} there")
        for axis, lengths in (("x", self._chords(1)), ("y", self._chords(0))):
            if not lengths.min() > 1e-9 * lengths.max():
                self._refuse(f"neighbours along {axis} that coincide at point {int(lengths.argmin()) + 1}", "points apart")

    def _refuse(self, problem: str, accepted: str) -> None:
        raise DeclarationError("PointSurface", problem, f"accepted are {accepted}")

    @cached_property
    def _grid(self) -> Floats:
        """The points, closed where they are, shape (ny, nx, 3)."""
        grid = np.array(self.points, float)
        if "x" in self.closed:
            grid = np.concatenate([grid, grid[:, :1]], axis=1)
        return np.concatenate([grid, grid[:1]], axis=0) if "y" in self.closed else grid

    def _chords(self, axis: int) -> Floats:
        """Mean distances of neighbours along an axis of the grid [m]."""
        return np.linalg.norm(np.diff(self._grid, axis=axis), axis=2).mean(axis=1 - axis)

    @cached_property
    def _parameters(self) -> tuple[Floats, Floats]:
        x, y = (np.concatenate([[0.0], np.cumsum(self._chords(axis))]) for axis in (1, 0))
        return x, y

    @property
    def size(self) -> tuple[float, float]:
        x, y = self._parameters
        return float(x[-1]), float(y[-1])

    @property
    def loops(self) -> tuple[bool, bool]:
        return "x" in self.closed, "y" in self.closed

    def at(self, x: Floats, y: Floats) -> SurfacePoints:
        along_x = _spline(self._parameters[0], self._grid, 1, closed="x" in self.closed)
        values = [_spline(self._parameters[1], along_x(x, nu), 0, closed="y" in self.closed) for nu in (0, 1)]
        each = np.arange(len(x))
        r, r_y = (values[0](y, nu)[each, each] for nu in (0, 1))
        r_x, r_xy = (values[1](y, nu)[each, each] for nu in (0, 1))
        return SurfacePoints(r, r_x, r_y, r_xy)


def _spline(at: Floats, values: Floats, axis: int, *, closed: bool) -> BSpline:
    """Interpolating spline of the highest odd degree up to 5 that the points allow."""
    from scipy.interpolate import make_interp_spline  # imported late: some tenths of a second that most models never need

    count = len(at) - 1 if closed else len(at)
    degree = 5 if count > 5 else 3 if count > 3 else min(count - 1, 2)
    return make_interp_spline(at, values, degree, axis=axis, bc_type="periodic" if closed else None)
