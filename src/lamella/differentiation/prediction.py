"""Prediction of a vector from step to step, by what its last values tell."""

from __future__ import annotations

from math import sqrt

import numpy as np

from lamella._jit import kernel, njit
from lamella.lane import WIDTH, number_at, put_at
from lamella.lane_rows import add_row, dot, set_row
from lamella.roles import Floats

MEMORY = 8
"""Values from which the next one is predicted, beside the last."""
DEPENDENT = 1e-9
"""Share of a value which others leave of it, below which it is not used: it is rounding."""
FAR = 0.03
"""Error of the estimate, as a share of the solution, beyond which nothing is predicted: motion without damping."""
SERVES = 1e-3
"""Error of a guess, as a share of the solution, up to which it is worth a product: from zero the first one leaves as much."""


class Prediction:
    """Guesses x from an estimate at hand and from what it was off by in the last steps, e = x - estimate:

        e_k ~ sum_i a_i e_(k-i),    with the coefficients by least squares from sum_i a_i e_(k-1-i) ~ e_(k-1)

    This is right for sums of few damped oscillations, whatever their frequencies are. A guess is given while the last one, or
    the estimate alone, was good.

    Args:
        magnitude: of each unknown, shape (n,).

    Source: linear prediction, J. Makhoul, Proceedings of the IEEE 63 (1975) 561-580.
    """

    def __init__(self, magnitude: Floats) -> None:
        padded = -(-len(magnitude) // WIDTH) * WIDTH
        self._magnitude, self._per_magnitude = magnitude, 1.0 / magnitude
        self._values, self._q = np.zeros((MEMORY + 1) * padded), np.zeros(MEMORY * padded)
        self._next, self._R, self._a = np.zeros(padded), np.zeros((MEMORY, MEMORY)), np.zeros(MEMORY)
        self.forget()

    def forget(self) -> None:
        """What follows does not go on from the steps before."""
        self._known, self._errors = 0, (np.inf, np.inf)

    @property
    def unsteady(self) -> bool:
        """Whether the last step moved x in a way of its own, as where nothing is damped: then the next will too."""
        return self._known > 0 and self._errors[1] > FAR

    def guess(self, estimate: Floats) -> Floats | None:
        """What x may be near to, shape (n,); None where nothing near enough is known."""
        of_prediction, of_estimate = self._errors
        if min(of_prediction, of_estimate) > SERVES:
            return None
        if of_estimate <= of_prediction:
            return estimate
        return _sum(estimate, self._magnitude, self._next)

    def learn(self, estimate: Floats, x: Floats) -> None:
        """Take note of the solution."""
        self._known += 1
        work = self._values, self._q, self._R, self._a, self._next
        self._errors = _learn(estimate, x, self._per_magnitude, self._known, *work)


@njit
def _sum(estimate: Floats, magnitude: Floats, following: Floats) -> Floats:
    x = np.empty_like(estimate)
    for i in range(len(x)):
        x[i] = estimate[i] + magnitude[i] * following[i]
    return x


@kernel
def _learn(
    estimate: Floats, x: Floats, per_magnitude: Floats, known: int,
    values: Floats, q: Floats, R: Floats, a: Floats, following: Floats,
) -> tuple[float, float]:  # fmt: skip
    """The errors of the last prediction and of the estimate, and the next prediction."""
    n = len(following)
    latest = (known - 1) % (MEMORY + 1)
    at = latest * n
    for i in range(len(x)):
        per, x_i = number_at(per_magnitude, i), number_at(x, i)
        put_at(values, at + i, per * (x_i - number_at(estimate, i)))
        put_at(q, i, per * x_i)
    size = dot(q, 0, q, 0, n)
    of_estimate = sqrt(dot(values, at, values, at, n) / size)
    if of_estimate > FAR:
        set_row(following, 0, 0.0, values, at, n)
        return of_estimate, of_estimate
    add_row(following, 0, -1.0, values, at, n)
    of_prediction = sqrt(dot(following, 0, following, 0, n) / size) if known > 2 else of_estimate
    used = 0
    for k in range(min(known - 1, MEMORY)):  # those before the latest, made orthonormal one after the other: q R
        row = (latest - 1 - k) % (MEMORY + 1) * n
        set_row(q, k * n, 1.0, values, row, n)
        for j in range(k):
            R[j, k] = dot(q, j * n, q, k * n, n)
            add_row(q, k * n, -R[j, k], q, j * n, n)
        R[k, k] = sqrt(dot(q, k * n, q, k * n, n))
        if not R[k, k] > DEPENDENT * sqrt(dot(values, row, values, row, n)):
            break
        set_row(q, k * n, 1.0 / R[k, k], q, k * n, n)
        used = k + 1
    set_row(following, 0, 1.0, values, at, n)
    for k in range(used):
        a[k] = dot(q, k * n, following, 0, n)
        add_row(following, 0, -a[k], q, k * n, n)
    for k in range(used - 1, -1, -1):
        for j in range(k + 1, used):
            a[k] -= R[k, j] * a[j]
        a[k] /= R[k, k]
    set_row(following, 0, 0.0, values, at, n)
    for k in range(used):
        add_row(following, 0, a[k], values, (latest - k) % (MEMORY + 1) * n, n)
    return of_prediction, of_estimate
