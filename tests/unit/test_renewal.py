"""When matrices are renewed, for points whose products follow a law."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from lamella.differentiation.renewal import Renewal

COST = 6.0


def total(products: Callable[[int], float], points: int = 400) -> tuple[float, int]:
    """Products, with those that matrices count as, where the k-th point after a new one takes ``products(k)``; and matrices."""
    renewal, spent, matrices, since = Renewal(COST), 0.0, 0, 0
    new = True
    for _ in range(points):
        since = 0 if new else since + 1
        matrices += new
        spent += products(since) + COST * new
        new = renewal.pays(products(since), new=new)
    return spent, matrices


def least(products: Callable[[int], float], points: int = 400) -> float:
    """The least total of all regular intervals."""
    intervals = range(1, points + 1)
    return min(points / n * (COST + sum(products(k) for k in range(n))) for n in intervals)


@pytest.mark.parametrize("growth", [0.0, 0.05, 0.3, 1.0, 3.0])
@pytest.mark.parametrize("first", [1.0, 3.0, 5.0])
def test_interval_is_near_the_best(first: float, growth: float) -> None:
    """A point that takes more than the average is known as such once it has been taken: one too many in each interval.

    Of those tried that costs most where points take 0, 5, 8: 6.33 each with three in an interval in place of 5.5 with two.
    """

    def products(k: int) -> float:
        return first + growth * (k - 1) if k else 0.0

    assert total(products)[0] <= 1.16 * least(products) + 2 * COST


def test_matrix_that_serves_as_well_as_a_new_one_is_kept() -> None:
    assert total(lambda k: 2.0)[1] == 1


def test_each_point_has_its_own_where_the_first_without_costs_more() -> None:
    spent, matrices = total(lambda k: 10.0 if k else 0.0)
    assert matrices >= 390
    assert spent <= 1.02 * least(lambda k: 10.0 if k else 0.0)


def test_one_that_goes_on_is_tried_again() -> None:
    renewal = Renewal(COST)
    assert not renewal.pays(0.0, new=True)
    assert renewal.pays(20.0, new=False)
    held = [renewal.pays(0.0, new=True) for _ in range(21)]
    assert held == [True] * 20 + [False]  # tried the second time after twice as many
    assert not renewal.pays(1.0, new=False)
    assert not renewal.pays(1.0, new=False)
