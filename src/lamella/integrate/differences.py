"""Backward differentiation formulas on unequal steps: weights of the past, local errors, and the order to choose."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from lamella.roles import Floats


def polynomial_weights(times: Floats, t: float) -> tuple[Floats, Floats]:
    """Weights of values at ``times`` in the value and in the derivative at ``t`` of the polynomial through them (Lagrange)."""
    m = len(times)
    ahead = t - times
    value, slope = np.empty(m), np.empty(m)
    for i in range(m):
        others = np.delete(ahead, i)
        apart = np.prod(times[i] - np.delete(times, i))
        value[i] = np.prod(others) / apart
        slope[i] = sum(np.prod(np.delete(others, j)) for j in range(m - 1)) / apart
    return value, slope


class Differences:
    """The formula of order k for a step to ``t`` from points at ``times``, the newest first (fixed leading coefficient).

    The predictor P interpolates the last k + 1 points. The new value y follows by

        y' = P'(t) + alpha (y - P(t)),   alpha = (1 + 1/2 + ... + 1/k) / dt

    which for equal steps is the classical formula of order k; alpha depends on order and step alone, so that a factorisation
    serves until one of them changes. Divided differences of order j follow from the predictor of order j - 1, as
    phi_(j+1) = y - P_(j-1)(t), and the local error of a formula of order j is sigma_(j+1) phi_(j+1).

    Sources: K. R. Jackson, R. Sacks-Davis, ACM Trans. Math. Softw. 6 (1980) 295-318; K. E. Brenan, S. L. Campbell,
    L. R. Petzold, Numerical Solution of Initial-Value Problems in Differential-Algebraic Equations (SIAM 1996), section 5.2.

    Args:
        times: of the past points, the newest first [s]; k + 1 of them at least.
        t: time at the end of the step [s].
        order: k.
    """

    def __init__(self, times: Floats, t: float, order: int) -> None:
        self.times, self.t, self.order = times, t, order
        dt = t - times[0]
        self.alpha = sum(1.0 / j for j in range(1, order + 1)) / dt
        self.value, self.slope = polynomial_weights(times[: order + 1], t)
        share = dt / (t - times)  # alpha_1, alpha_2, ... of the source
        self._sigma = np.cumprod(np.concatenate([[1.0], np.arange(1, len(times)) * share[1:]]))
        leading = sum(1.0 / j for j in range(1, order + 1)) - float(np.sum(share[:order]))
        self.error_constant = max(abs(share[order] - leading), float(share[order]))
        """Factor from y - P(t) to the larger of the errors of the formula and of the interpolation within the step."""

    def neighbours(self) -> list[int]:
        """Orders beside k whose local error the past allows to estimate: k - 2, k - 1 and k + 1."""
        return [j for j in (self.order - 2, self.order - 1, self.order + 1) if 1 <= j < len(self.times)]

    def predictor(self, order: int) -> Floats:
        """Weights of the points in the predictor of another order."""
        return polynomial_weights(self.times[: order + 1], self.t)[0]

    def error_of(self, order: int) -> float:
        """Factor from y - P(t), with the predictor of that order, to the local error of its formula: sigma_(order + 1)."""
        return float(self._sigma[order])


def next_order(order: int, errors: Mapping[int, float], highest: int, *, settled: bool, starting: bool) -> int:
    """The order that promises the longest step, by the size of the terms dt^(j+1) y^(j+1) = (j + 1) times the local errors.

    An order is lowered when these terms do not shrink with j, and raised when the next one is smaller still; raised only after
    order + 1 equal steps, and in every step of the start. (Brenan, Campbell and Petzold 1996, section 5.2.)

    Args:
        order: the order of the last step.
        errors: local error by order, for the neighbours that could be estimated.
        highest: largest order allowed.
        settled: whether the last order + 1 steps were equal.
        starting: whether every step so far has raised the order.
    """
    term = {j: (j + 1) * error for j, error in errors.items()}
    below = term.get(order - 1, np.inf)
    if order > 2 and max(below, term.get(order - 2, np.inf)) <= term[order]:
        return order - 1
    if order == 2 and below <= 0.5 * term[order]:
        return order - 1
    if order == highest:
        return order
    if starting:
        return order + 1
    if not settled or order + 1 not in term:
        return order
    above = term[order + 1]
    if order == 1:
        return 2 if above < 0.5 * term[1] else 1
    if below <= min(term[order], above):
        return order - 1
    return order + 1 if above < term[order] else order
