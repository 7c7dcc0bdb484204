"""A function of time given by points."""

from __future__ import annotations

from bisect import bisect_right
from functools import cached_property
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Literal

import numpy as np

from lamella.arguments import PATH, accepts
from lamella.declaration import declaration
from lamella.errors import DeclarationError
from lamella.math.time_function import Integrable
from lamella.units import Number, OfProfile, Time

Interpolation = Literal["linear", "pchip", "cubic"]


@declaration
class Table(Integrable):
    """Points joined by lines or curves; before the first and after the last the value stays constant.

    Args:
        times: strictly increasing [s], at least two.
        values: one for each time [-].
        interpolation: ``linear`` (continuous); ``pchip`` (continuous rate, never overshoots the points; Fritsch and Butland,
            1984); ``cubic`` (spline with continuous acceleration between the ends, may overshoot).

    Raises:
        DeclarationError: fewer than two points, counts that differ, times that do not increase.
    """

    times: tuple[Time, ...]
    values: Annotated[tuple[Number, ...], OfProfile()]
    interpolation: Interpolation = "linear"
    kind: Literal["table"] = "table"

    def __post_init__(self) -> None:
        """Refuse points that are no function of time."""
        if len(self.times) != len(self.values):
            raise ValueError(f"{len(self.times)} times and {len(self.values)} values; accepted is one value for each time")
        if len(self.times) < 2:
            raise ValueError(f"{len(self.times)} points; accepted are at least two")
        for k, (t, t_next) in enumerate(pairwise(self.times), start=1):
            if t_next <= t:
                raise ValueError(f"times {k} and {k + 1} are {t:g} and {t_next:g}; accepted are strictly increasing times")

    @classmethod
    @accepts(path=PATH)
    def from_csv(cls, path: str | Path, interpolation: Interpolation = "linear") -> Table:
        """Read a table from a text file with two columns, time [s] and value, separated by a comma.

        A first line of words is taken as heading; ``#`` starts a comment.

        Args:
            path: file to read.
            interpolation: as for the class.

        Raises:
            DeclarationError: the file is missing or unreadable, has other columns, holds something that is not a finite number,
                or its times do not increase.
        """
        item, accepted = (
            f"Table '{path}'",
            "accepted is a text file with two columns of numbers, time and value, separated by a comma",
        )
        try:
            lines = Path(path).read_text(encoding="utf-8-sig").splitlines()  # utf-8-sig: spreadsheets write a byte-order mark
        except (OSError, ValueError) as error:
            reason = getattr(error, "strerror", None) or "it is not text"
            raise DeclarationError(item, f"the file cannot be read: {reason}", accepted) from error
        points = _points(lines, item, accepted)
        try:
            return cls(tuple(t for t, _ in points), tuple(value for _, value in points), interpolation)
        except DeclarationError as error:
            raise DeclarationError(item, error.problem, error.accepted) from error

    def value(self, t: float) -> float:
        """Value at the time t [s]."""
        if t < self.times[0]:
            return self.values[0]
        if t >= self.times[-1]:
            return self.values[-1]
        s, (c3, c2, c1, c0) = self._at(t)
        return ((c3 * s + c2) * s + c1) * s + c0

    def rate(self, t: float) -> float:
        """First derivative by time [1/s]."""
        if not self.times[0] <= t < self.times[-1]:
            return 0.0
        s, (c3, c2, c1, _) = self._at(t)
        return (3.0 * c3 * s + 2.0 * c2) * s + c1

    def acceleration(self, t: float) -> float:
        """Second derivative by time [1/s^2]."""
        if not self.times[0] <= t < self.times[-1]:
            return 0.0
        s, (c3, c2, _, _) = self._at(t)
        return 6.0 * c3 * s + 2.0 * c2

    def integral(self, t: float) -> float:
        """Integral from 0 to t [s]."""
        return self._since_start(t) - self._since_start(0.0)

    def _since_start(self, t: float) -> float:
        """Integral from the first time to t."""
        if t < self.times[0]:
            return self.values[0] * (t - self.times[0])
        if t >= self.times[-1]:
            return self._areas[-1] + self.values[-1] * (t - self.times[-1])
        s, (c3, c2, c1, c0) = self._at(t)
        return self._areas[bisect_right(self.times, t) - 1] + s * (c0 + s * (c1 / 2.0 + s * (c2 / 3.0 + s * c3 / 4.0)))

    @cached_property
    def _areas(self) -> list[float]:
        """Integral from the first time to each of the others."""
        areas = [0.0]
        for (t, t_next), (c3, c2, c1, c0) in zip(pairwise(self.times), self._pieces, strict=True):
            s = t_next - t
            areas.append(areas[-1] + s * (c0 + s * (c1 / 2.0 + s * (c2 / 3.0 + s * c3 / 4.0))))
        return areas

    @property
    def breakpoints(self) -> tuple[float, ...]:
        """All points, or the two ends when the acceleration is continuous between them [s]."""
        return (self.times[0], self.times[-1]) if self.interpolation == "cubic" else self.times

    def _at(self, t: float) -> tuple[float, list[float]]:
        """Time since the last point and the coefficients of the piece that begins there."""
        k = bisect_right(self.times, t) - 1
        return t - self.times[k], self._pieces[k]

    @cached_property
    def _pieces(self) -> list[list[float]]:
        """Coefficients of the cubic in each interval, highest power first, as plain numbers (fast to evaluate one by one)."""
        times, values = np.array(self.times), np.array(self.values)
        if self.interpolation == "linear":
            zero = np.zeros(len(times) - 1)
            return np.array([zero, zero, np.diff(values) / np.diff(times), values[:-1]]).T.tolist()
        from scipy.interpolate import CubicSpline, PchipInterpolator  # imported late: 1 s that most models never need

        with np.errstate(over="ignore"):  # a mean slope of 0 is what SciPy makes of slopes below 1e-308
            return (CubicSpline if self.interpolation == "cubic" else PchipInterpolator)(times, values).c.T.tolist()


def _points(lines: list[str], item: str, accepted: str) -> list[tuple[float, float]]:
    points: list[tuple[float, float]] = []
    heading_allowed = True
    for number, line in enumerate(lines, start=1):
        text = line.split("#", 1)[0].strip()
        if not text:
            continue
        cells = [cell.strip() for cell in text.split(",")]
        if len(cells) != 2:
            raise DeclarationError(item, f"line {number} has {len(cells)} columns", accepted)
        try:
            points.append((float(cells[0]), float(cells[1])))
        except ValueError as error:
            if not heading_allowed:
                raise DeclarationError(item, f"line {number} holds '{text}'", accepted) from error
        heading_allowed = False
        if points and not all(map(np.isfinite, points[-1])):
            raise DeclarationError(item, f"line {number} holds '{text}', which is not finite", accepted)
    return points
