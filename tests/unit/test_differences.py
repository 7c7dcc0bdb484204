"""Backward differentiation formulas: weights, leading coefficients, local errors, and the choice of the order."""

from __future__ import annotations

import numpy as np
import pytest

from lamella.integrate.differences import Differences, next_order, polynomial_weights

ORDERS = [1, 2, 3, 4, 5]
each = pytest.mark.parametrize("order", ORDERS)


@pytest.mark.parametrize("count", [1, 2, 4, 7])
def test_weights_reproduce_polynomials_and_their_derivatives(count):
    times = np.array([0.3, 0.1, -0.05, -0.4, -0.5, -0.8, -1.0])[:count]
    value, slope = polynomial_weights(times, 0.5)
    for power in range(count):
        assert value @ times**power == pytest.approx(0.5**power, abs=1e-11)  # weights of some 1e3, rounding 1e-16
        assert slope @ times**power == pytest.approx(power * 0.5 ** max(power - 1, 0), abs=1e-10)


@each
def test_equal_steps_give_the_classical_formula(order):
    """Sum over j of (1/j) nabla^j y = dt y' (Hairer, Norsett and Wanner 1993, equation III.1.22)."""
    dt, rng = 0.1, np.random.default_rng(order)
    times = -dt * np.arange(order + 1)
    past, new = rng.standard_normal(order + 1), 0.7
    formula = Differences(times, dt, order)
    derivative = formula.slope @ past + formula.alpha * (new - formula.value @ past)
    values, nabla = np.concatenate([[new], past]), 0.0
    for j in range(1, order + 1):
        nabla += np.diff(values, j)[0] * (-1) ** j / j
    assert derivative == pytest.approx(nabla / dt, rel=1e-11)


@each
def test_unequal_steps_are_exact_for_polynomials_of_the_order(order):
    times = np.array([0.0, -0.1, -0.25, -0.3, -0.5, -0.75])[: order + 1]
    formula = Differences(times, 0.07, order)
    for power in range(order + 1):
        predicted = formula.value @ times**power
        assert predicted == pytest.approx(0.07**power, abs=1e-12)
        assert formula.slope @ times**power == pytest.approx(power * 0.07 ** max(power - 1, 0), abs=1e-11)


@each
def test_local_error_of_equal_steps_is_that_of_the_formula(order):
    """y = t^(k+1): the difference to the prediction is (k+1)! dt^(k+1), the local error dt^(k+1) y^(k+1) / (k+1)."""
    dt = 0.1
    times = -dt * np.arange(order + 2)
    formula = Differences(times, dt, order)
    difference = dt ** (order + 1) - formula.value @ times[: order + 1] ** (order + 1)
    factorial = float(np.prod(np.arange(1, order + 2)))
    assert difference == pytest.approx(factorial * dt ** (order + 1), rel=1e-9)
    assert formula.error_of(order) == pytest.approx(1.0 / (order + 1), rel=1e-12)
    assert formula.error_constant == pytest.approx(1.0 / (order + 1), rel=1e-12)


def chosen(order, terms, *, highest=5, settled=True, starting=False):
    errors = {j: term / (j + 1) for j, term in terms.items()}
    return next_order(order, errors, highest, settled=settled, starting=starting)


def test_order_rises_where_terms_shrink_and_falls_where_they_grow():
    assert chosen(3, {1: 1.0, 2: 0.5, 3: 0.2, 4: 0.1}) == 4
    assert chosen(3, {1: 0.1, 2: 0.15, 3: 0.2, 4: 0.3}) == 2
    assert chosen(3, {1: 1.0, 2: 0.5, 3: 0.2, 4: 0.3}) == 3
    assert chosen(2, {1: 0.4, 2: 1.0, 3: 2.0}) == 1
    assert chosen(1, {1: 1.0, 2: 0.6}) == 1
    assert chosen(1, {1: 1.0, 2: 0.4}) == 2


def test_order_rises_only_after_equal_steps_or_at_the_start_and_not_beyond_the_highest():
    falling = {1: 1.0, 2: 0.5, 3: 0.2, 4: 0.1}
    assert chosen(3, falling, settled=False) == 3
    assert chosen(3, falling, settled=False, starting=True) == 4
    assert chosen(3, falling, highest=3, starting=True) == 3
