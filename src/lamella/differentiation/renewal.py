"""When a matrix of its own pays for a point, where that of an earlier point serves with more products."""

from __future__ import annotations

TRIES = 10
"""Points with new matrices one after another, before one is tried again that goes on with the last; twice as many each time that
this has not paid."""


class Renewal:
    """Decides by the products that points have taken, of which a new matrix costs some too.

    The more points a matrix has served, the more products it takes, and the less its own cost weighs. A new one pays where the
    next point is expected to take more products than points have taken on average since the last one, its cost among them: that
    average is least there. The next point is expected to take as many as this one; the first after a new matrix, as many as the
    first one took before.

    Args:
        cost: of a new matrix, in products.
    """

    def __init__(self, cost: float) -> None:
        self._cost, self._wait = cost, TRIES
        self._total = self._first = 0.0
        self._points = self._tries = 0

    def pays(self, spent: float, *, new: bool) -> bool:
        """Whether the next point should have a matrix of its own.

        Args:
            spent: products that this point has taken.
            new: whether its matrix was its own.
        """
        if new:
            self._total, self._points, self._tries = self._cost + spent, 1, self._tries + 1
            return self._first > self._total and self._tries <= self._wait
        if self._points == 1:
            self._first, self._tries = spent, 0
            self._wait = 2 * self._wait if spent > self._total else TRIES
        self._total, self._points = self._total + spent, self._points + 1
        return spent > self._total / self._points
