"""Vectors as linear functions of coordinate vectors, one by one and several at once."""

from __future__ import annotations

import numpy as np

from lamella.kinematics import Frame, StackedRows, VectorRows

X = np.random.default_rng(5).uniform(-1.0, 1.0, (6, 3))


def test_rows_that_are_stacked_have_the_values_of_each():
    a = VectorRows(np.array([4, 1]), np.array([0.5, -2.0]), np.array([0.1, 0.2, 0.3]))
    b, c = VectorRows.single(3), VectorRows.fixed(np.array([0.0, -1.0, 2.0]))
    rows = (a, b, c, a - b)
    np.testing.assert_allclose(StackedRows(rows).at(X), [row.at(X) for row in rows], atol=1e-15)
    np.testing.assert_allclose(a.at(X), 0.5 * X[4] - 2.0 * X[1] + a.constant, atol=1e-15)
    np.testing.assert_allclose(a.rate(X), 0.5 * X[4] - 2.0 * X[1], atol=1e-15)


def test_axes_that_are_stacked_are_the_rows_of_the_inverse_rotation():
    turned = Frame(VectorRows.single(0), (VectorRows.single(1), VectorRows.single(2), VectorRows.single(3)))
    fixed = Frame(VectorRows.single(0), tuple(VectorRows.fixed(axis) for axis in np.eye(3)))
    for frame in (turned, fixed):
        np.testing.assert_allclose(StackedRows(frame.axes).at(X), frame.rotation(X).T, atol=1e-15)
