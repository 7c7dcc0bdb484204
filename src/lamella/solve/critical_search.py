"""Search for critical points between the points of an equilibrium path."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.sparse import linalg

from lamella.assembly.equations import Equations
from lamella.assembly.point import STATIC, Point
from lamella.critical import CriticalPoint, Kind
from lamella.errors import SingularSystemError
from lamella.result import Statistics
from lamella.roles import Floats
from lamella.solve.base import LinearSolver
from lamella.solve.bordered import Between

WIDE = 1e-2
"""Share of a step: where equilibria between two points are lost in an interval wider than this, they lie on two paths."""
TOLERANCE = 1e-6
"""Share of the step between two points of a path to which a critical point is located."""
ALONG_LOAD = 1e-4
"""Cosine between null vector and load below which the load does no work on it: a bifurcation. Where the path is located to 1e-6
it is some 1e-6 there, and of order 0.01 to 1 at a limit point."""
DENSE, AFTER_ALL = 20, 1000
"""Coordinates up to which eigenvalues are found from the whole inverse, at once and where the iteration does not find them."""


@dataclass(frozen=True)
class _Place:
    """A point at a share of the step, with its count of negative eigenvalues."""

    share: float
    point: Point
    negative: int


class CriticalSearch:
    """Finds where an eigenvalue of the stiffness changes its sign between two equilibria.

    The number of negative eigenvalues (inertia) is that of negative pivots of the factorisation. Where it differs at two points,
    the eigenvalue omega of K phi = omega W phi that has changed its sign, W the squared reciprocal magnitudes, is followed to
    zero along the path by Brent's method. With y = W^(1/2) phi it is an eigenvalue 1 / omega of W^(1/2) K^-1 W^(1/2) y.

    Args:
        equations: gives the stiffness.
        linear: factorises it; what it held is lost.
        statistics: counts the work.
    """

    def __init__(self, equations: Equations, linear: LinearSolver, statistics: Statistics) -> None:
        self.equations, self.linear, self.statistics = equations, linear, statistics
        self._last: tuple[Point, int] | None = None
        self._weights = 1.0 / equations.magnitude
        self.at_point = False
        """Whether the linear solver holds the stiffness at the last point."""
        self.jumped = False
        """Whether no path was found between the last two points, although an eigenvalue has changed its sign between them."""

    def negative_at(self, point: Point) -> int | None:
        """Negative eigenvalues at the last point if it is this one; None where they are not known."""
        return self._last[1] if self._last is not None and self._last[0] is point else None

    def begin(self, point: Point) -> None:
        """Start from an equilibrium."""
        self.jumped = False
        negative = self._negative(point)
        self.at_point = negative is not None
        self._last = None if negative is None else (point, negative)

    def passed(self, point: Point, between: Between, at: Callable[[float, Point], float]) -> list[CriticalPoint]:
        """Critical points between the last point and this one, which becomes the last.

        Args:
            point: the new equilibrium.
            between: finds the equilibria on the way.
            at: place on the result's axis, from a share of the way and the equilibrium there.
        """
        last, negative = self._last, self._negative(point)
        self.at_point = negative is not None and (last is None or last[1] == negative)
        if negative is None:  # not known: at a critical point, or where the solver had to exchange rows
            return []
        self._last = point, negative
        if last is None or last[1] == negative:
            return []
        self.jumped = False
        found = self._located(_Place(0.0, last[0], last[1]), _Place(1.0, point, negative), between)
        return [self._described(place, behind, shape, at) for place, behind, shape in found]

    def _located(self, low: _Place, high: _Place, between: Between) -> list[tuple[_Place, int, Floats]]:
        """Places with the count behind them and the null vector, in order."""
        from scipy.optimize import brentq  # imported late: some tenths of a second that most models never need

        if abs(high.negative - low.negative) > 1 and high.share - low.share > TOLERANCE:
            middle = self._place(0.5 * (low.share + high.share), between)
            if middle is not None:
                halves = [pair for pair in ((low, middle), (middle, high)) if pair[0].negative != pair[1].negative]
                return [item for pair in halves for item in self._located(*pair, between)]
        rises = high.negative > low.negative
        if abs(high.negative - low.negative) > 1:  # several at one place
            shapes = self._nearest(low.point, positive=rises, count=abs(high.negative - low.negative))[1]
            return [(low, high.negative, shape) for shape in shapes.T]
        seen: list[tuple[float, _Place, Floats]] = []

        def eigenvalue(share: float) -> float:
            place = low if share == low.share else high if share == high.share else self._place(share, between)
            if place is None:
                raise _LostError
            positive = (place.negative == low.negative) == rises
            values, shapes = self._nearest(place.point, positive=positive, count=1)
            if not len(values):
                raise _LostError
            seen.append((float(values[0]), place, shapes[:, 0]))
            return float(values[0])

        try:
            brentq(eigenvalue, low.share, high.share, xtol=TOLERANCE)
        except _LostError:
            self.jumped = self.jumped or _bracket(seen) > WIDE
        except (SingularSystemError, ValueError):
            pass  # what was found until then lies nearest
        if not seen:
            return []
        _, nearest, shape = min(seen, key=lambda item: abs(item[0]))
        place = _Place(nearest.share, _between(seen) or nearest.point, low.negative)
        return [(place, high.negative, shape)]

    def _place(self, share: float, between: Between) -> _Place | None:
        point = between(share)
        negative = None if point is None else self._negative(point)
        return None if point is None or negative is None else _Place(share, point, negative)

    def _negative(self, point: Point) -> int | None:
        """Negative eigenvalues of the stiffness on the constraints; None where they are not known."""
        try:
            self._factorise(point)
        except SingularSystemError:
            return None
        return self.linear.negative_pivots

    def _factorise(self, point: Point) -> None:
        k, j = self.equations.exact_matrix(point, STATIC)
        self.statistics.tangents += 1
        self.statistics.factorisations += 1
        self.linear.factorise(k, j)

    def _nearest(self, point: Point, *, positive: bool, count: int) -> tuple[Floats, Floats]:
        """The ``count`` eigenvalues of one sign nearest to zero, or those found, with their shapes as columns (n_u, count)."""
        self._factorise(point)
        n, none, w = self.equations.n_u, np.zeros(self.equations.n_lam), self._weights  # W^(1/2)

        def inverse(x: Floats) -> Floats:
            self.statistics.solves += 1
            return w * self.linear.solve(w * np.ravel(x), none)[0]

        def dense() -> tuple[Floats, Floats]:
            values, vectors = np.linalg.eigh(np.column_stack([inverse(column) for column in np.eye(n)]))
            chosen = np.argsort(-values if positive else values)[:count]
            return values[chosen], vectors[:, chosen]

        def iterated() -> tuple[Floats, Floats]:
            operator: Any = linalg.LinearOperator((n, n), matvec=inverse, dtype=float)  # pyright: ignore[reportCallIssue]
            start = inverse(np.random.default_rng(0).standard_normal(n))
            try:
                found: Any = linalg.eigsh(operator, count, which="LA" if positive else "SA", v0=start)
                return found
            except linalg.ArpackNoConvergence as error:  # far from zero their reciprocals are lost among those of the other sign
                return dense() if n <= AFTER_ALL else (error.eigenvalues, error.eigenvectors)

        values, vectors = dense() if n <= DENSE else iterated()
        return 1.0 / np.asarray(values), np.asarray(vectors) / w[:, None]

    def _described(self, place: _Place, behind: int, shape: Floats, at: Callable[[float, Point], float]) -> CriticalPoint:
        equations, point = self.equations, place.point
        load = equations.load_direction(point)
        length = np.linalg.norm(shape * self._weights) * np.linalg.norm(load / self._weights)
        kind: Kind = "bifurcation" if abs(float(shape @ load)) <= ALONG_LOAD * length else "limit point"
        q_shape = equations.elimination.T @ shape
        q_shape = q_shape / equations.model.largest_displacement(q_shape)
        q_shape *= 1.0 if q_shape[np.argmax(np.abs(q_shape))] > 0 else -1.0
        where, counts = at(place.share, point), (place.negative, behind)
        return CriticalPoint(point.factor, where, kind, counts, q_shape, equations.state(point))


def _bracket(seen: list[tuple[float, _Place, Floats]]) -> float:
    """Share of the step between the nearest places on both sides of the change of sign."""
    above = [place.share for value, place, _ in seen if value >= 0.0]
    below = [place.share for value, place, _ in seen if value < 0.0]
    return min((abs(a - b) for a in above for b in below), default=1.0)


def _between(seen: list[tuple[float, _Place, Floats]]) -> Point | None:
    """The point where the eigenvalue is zero on the line between the two nearest points on either side; None without these.

    Beside a bifurcation the equilibrium along the null vector is determined to rounding over the eigenvalue only, and Newton's
    method may find none; the eigenvalue is a nearly linear function there.
    """
    above = min((item for item in seen if item[0] >= 0.0), key=lambda item: item[0], default=None)
    below = max((item for item in seen if item[0] < 0.0), key=lambda item: item[0], default=None)
    if above is None or below is None:
        return None
    share, first, second = above[0] / (above[0] - below[0]), above[1].point, below[1].point
    point = first.copy()
    point.u, point.lam = first.u + share * (second.u - first.u), first.lam + share * (second.lam - first.lam)
    point.factor, point.t = first.factor + share * (second.factor - first.factor), first.t + share * (second.t - first.t)
    return point


class _LostError(Exception):
    """No equilibrium was found on the way, or no eigenvalue there."""
