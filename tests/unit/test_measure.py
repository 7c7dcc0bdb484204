"""Lengths, angles and slides: values against an oracle, gradients against complex steps, Hessians against their differences."""

from __future__ import annotations

import numpy as np
import pytest
from measure_cases import MEASURES, N, complex_gradient, configuration, derivative, oracle, rows

from lamella.kinematics import VectorRows
from lamella.measure.measure import MeasureSet, angle

everywhere = pytest.mark.parametrize("seed", range(6))
measures = pytest.mark.parametrize("name", MEASURES)


def dense(found: MeasureSet, m: int = 0):
    """Value, gradient and Hessian of one measure by all coordinates."""
    g, h = np.zeros(N), np.zeros((N, N))
    own = found.owner == m
    np.add.at(g, found.coords[own], found.gradients[own])
    pairs = found.owner[found.rows] == m
    np.add.at(h, (found.coords[found.rows[pairs]], found.coords[found.cols[pairs]]), found.hessians[pairs])
    return found.values[m], g, h


@measures
@everywhere
def test_value_and_derivatives_match_the_oracle(name, seed):
    measure, q = MEASURES[name], configuration(seed)
    found = MeasureSet([measure])
    found.evaluate(q, second=True)
    value, gradient, hessian = dense(found)
    exact = complex_gradient(measure, q)
    differences = np.array([derivative(lambda s, d=d: complex_gradient(measure, q + s * d), 2e-4) for d in np.eye(N)])
    assert value == pytest.approx(oracle(measure, q).real, abs=1e-13)
    np.testing.assert_allclose(gradient, exact, atol=1e-12 * np.abs(exact).max())
    # differences of a complex step: rounding 1e-16 / 2e-4 and the fifth derivative times 1e-15, some 1e-10 of the largest entry
    np.testing.assert_allclose(hessian, differences, atol=1e-9 * np.abs(hessian).max())
    np.testing.assert_allclose(hessian, hessian.T, atol=1e-14 * np.abs(hessian).max())


def test_measures_of_one_set_do_not_mix():
    q, names = configuration(3), list(MEASURES)
    together = MeasureSet([MEASURES[name] for name in names])
    together.evaluate(configuration(4), second=True)  # leaves nothing behind
    together.evaluate(q, second=True)
    for m, name in enumerate(names):
        alone = MeasureSet([MEASURES[name]])
        alone.evaluate(q, second=True)
        for mixed, single in zip(dense(together, m), dense(alone), strict=True):
            np.testing.assert_array_equal(mixed, single)


def test_rates_and_products_are_directional_derivatives():
    q, v = configuration(1), configuration(2)
    found = MeasureSet(list(MEASURES.values()))
    found.evaluate(q, second=True)
    rates, products = found.rates(v), found.times(v)
    for m, measure in enumerate(MEASURES.values()):
        _, _, h = dense(found, m)
        assert rates[m] == pytest.approx(complex_gradient(measure, q) @ v, rel=1e-12, abs=1e-12)
        own = found.owner == m
        summed = np.zeros(N)
        np.add.at(summed, found.coords[own], products[own])
        np.testing.assert_allclose(summed, h @ v, atol=1e-12 * np.abs(h).max())


TURNED = rows([0], [1.0])
X, Z = VectorRows.fixed(np.array([1.0, 0.0, 0.0])), VectorRows.fixed(np.array([0.0, 0.0, 1.0]))


@pytest.mark.parametrize("degrees", [-179.999, -120.0, -90.0, 0.0, 1e-6, 90.0, 135.0, 179.999])
@pytest.mark.parametrize("axis_length", [0.01, 1.0, 40.0])
def test_angle_has_the_sense_of_the_axis_and_ignores_lengths(degrees, axis_length):
    phi = np.radians(degrees)
    q = np.array([3.0 * np.cos(phi), 3.0 * np.sin(phi), 0.7])  # the part along the axis does not count
    found = MeasureSet([(angle(X, TURNED, axis_length * Z),), (angle(X, TURNED, -axis_length * Z),)])
    found.evaluate(q, second=True)
    np.testing.assert_allclose(found.values, [phi, -phi], atol=1e-13)
    np.testing.assert_allclose(found.gradients[:3], np.array([-np.sin(phi), np.cos(phi), 0.0]) / 3.0, atol=1e-13)
    across = np.array([[np.sin(2 * phi), -np.cos(2 * phi)], [-np.cos(2 * phi), -np.sin(2 * phi)]]) / 9.0
    np.testing.assert_allclose(found.hessians[:9].reshape(3, 3)[:2, :2], across, atol=1e-13)


@pytest.mark.parametrize("centre", [-40.0, -np.pi, 0.0, 2.0, 3 * np.pi, 100.0])
def test_angle_lies_within_half_a_turn_of_its_centre(centre):
    for phi in np.linspace(-np.pi, np.pi, 12, endpoint=False) + 0.01:
        found = MeasureSet([(angle(X, TURNED, Z, centre=centre),)])
        found.evaluate(np.array([np.cos(phi), np.sin(phi), 0.0]))
        assert abs(found.values[0] - centre) <= np.pi
        turns = (found.values[0] - phi) / (2 * np.pi)
        assert turns == pytest.approx(round(turns), abs=1e-13)
