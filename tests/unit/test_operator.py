"""Sums by sparse maps: the same numbers as SciPy's products, whatever the shape of the map."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import sparse

from lamella.assembly.operator import SumOperator, VectorOperator
from lamella.inertia import vector_mass

ROUNDING = 1e-14  # of some tens of summands of size 1


def scattered(shape, density=0.3, seed=1):
    return sparse.csr_array(sparse.random_array(shape, density=density, rng=np.random.default_rng(seed)))


def numbers(n, seed=2):
    return np.random.default_rng(seed).uniform(-1.0, 1.0, n)


def test_sums_of_rows_of_any_length():
    E = scattered((60, 12), density=0.2)
    lengths = set(np.diff(E.indptr).tolist())
    assert {0, 1, 2, 4} < lengths  # each has a loop of its own, and the others share one
    x, given = numbers(12), numbers(60)
    operator = SumOperator.of(E)
    assert np.allclose(operator(x), E @ x, rtol=0.0, atol=ROUNDING)
    assert np.allclose(operator.onto(x, given.copy()), given + E @ x, rtol=0.0, atol=ROUNDING)


@pytest.mark.parametrize("n", range(1, 10))
def test_vectors_are_summed_whatever_their_number(n):
    scalar = scattered((n, n), density=0.5, seed=n)
    M = sparse.csr_array(sparse.kron(scalar + sparse.eye_array(n), sparse.eye_array(3)))
    operator = VectorOperator.within(M)
    assert operator is not None
    x, given = numbers(3 * n), numbers(3 * n)
    assert np.allclose(operator(x), M @ x, rtol=0.0, atol=ROUNDING)
    assert np.allclose(operator.onto(x, given.copy()), given + M @ x, rtol=0.0, atol=ROUNDING)


@pytest.mark.parametrize("fields", [1, 2, 7])
def test_fields_without_mass_lie_behind_the_vectors(fields):
    of_vectors = sparse.kron(scattered((6, 6), 0.9), sparse.eye_array(3))
    M = sparse.csr_array(sparse.block_diag([of_vectors, sparse.coo_array((fields, fields))]))
    operator = VectorOperator.within(M)
    assert operator is not None
    x, given = numbers(18 + fields), numbers(18 + fields)
    assert np.allclose(operator(x), M @ x, rtol=0.0, atol=ROUNDING)
    assert np.allclose(operator.onto(x, given.copy()), given + M @ x, rtol=0.0, atol=ROUNDING)


def test_mass_that_treats_components_differently_does_not_go_by_vectors():
    assert VectorOperator.within(sparse.csr_array(sparse.diags_array(np.arange(1.0, 7.0)))) is None


def test_nothing_has_mass():
    assert VectorOperator.within(sparse.csr_array((4, 4))) is None
    assert np.array_equal(VectorOperator(vector_mass([], 4))(np.ones(14)), np.zeros(14))
