"""Sums by sparse maps: the same numbers as SciPy's products, whatever the shape of the map."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import sparse

import lamella as lm
from lamella.assembly.equations import Equations
from lamella.assembly.mass import in_independent, of_vectors, reduced
from lamella.assembly.operator import SumOperator, VectorOperator
from lamella.inertia import differenced, vector_mass, whole_mass

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


@pytest.mark.parametrize("whole", [True, False])
def test_diagonal_of_the_mass_is_that_of_its_products(whole):
    """Of a heated plate, whose fields have no mass, by vectors and where a support holds single components."""
    ply = lm.Lamina(E1=181e9, E2=10.3e9, G12=7.7e9, nu12=0.28, rho=1560.0, alpha1=0.0, alpha2=3e-5, k1=5.0, k2=0.7, c=900.0)
    system = lm.System()
    plate = system.add(lm.Plate("plate", (1.0, 0.5), (3, 2), lm.Laminate(ply, angles=(0.0, 90.0, 0.0), thickness=4e-3)))
    edge = plate.edge("x-")
    system.add(lm.Clamp("root", edge) if whole else lm.EdgeSupport("root", edge, "z"))
    system.add(lm.TemperatureField("heat", plate))
    equations = Equations(system.compile())
    assert (reduced(equations.model.vector_mass, equations.elimination.T) is not None) == whole
    expected = [equations.inertia_force(unit)[i] for i, unit in enumerate(np.eye(equations.n_u))]
    assert equations.n_u > equations.n_motion
    np.testing.assert_allclose(equations.mass.diagonal, expected, rtol=1e-12, atol=1e-15)


def test_mass_that_treats_components_differently_does_not_go_by_vectors():
    assert VectorOperator.within(sparse.csr_array(sparse.diags_array(np.arange(1.0, 7.0)))) is None


def test_nothing_has_mass():
    assert VectorOperator.within(sparse.csr_array((4, 4))) is None
    assert np.array_equal(VectorOperator(vector_mass([], 4))(np.ones(14)), np.zeros(14))


@pytest.mark.parametrize("fields", [0, 2])
@pytest.mark.parametrize("kind", ["vectors", "one component held", "turned axes"])
def test_mass_in_independent_coordinates(kind, fields):
    """The map of vectors serves where there is one; else the components are not alike."""
    m = sparse.csr_array(scattered((5, 5), 0.6) + sparse.eye_array(5))
    m = sparse.csr_array(m + m.T)
    t = sparse.csr_array(np.array([[1, 0, 0], [0, 1, 0], [0, 0, 0], [0, 0, 1], [0.5, 0.5, 0]], float))
    T = sparse.kron(t, sparse.eye_array(3)).toarray()
    if kind == "one component held":
        T = np.delete(T, 4, axis=1)
    elif kind == "turned axes":
        T[3:6, 3:6] = [[0, -1, 0], [1, 0, 0], [0, 0, 1]]
    T = sparse.csr_array(sparse.block_diag([T, np.eye(fields)]) if fields else T)
    T.eliminate_zeros()
    assert (of_vectors(T, 5) is None) == (kind != "vectors")
    expected = (T.T @ whole_mass(m, 15 + fields) @ T).toarray()
    found = in_independent(m, T)
    if kind != "vectors":
        assert found is None
        return
    x = numbers(T.shape[1])
    assert found is not None
    assert np.allclose(found(x), expected @ x, rtol=0.0, atol=10 * ROUNDING)


class Inertia:
    def __init__(self, i, j, m):
        self.entries = np.array(i), np.array(j), np.array(m, float)

    def mass(self):
        return self.entries


@pytest.mark.parametrize("columns", [[0, 1, 1], [0, 2, 1]])
def test_differences_of_masses(columns):
    """Where their entries stand at the same places, and where they do not."""
    models = [[Inertia([0, 1, 2], [0, 1, 1], [1.0, 2.0, 3.0])], [Inertia([0, 1, 2], columns, [1.5, 2.5, 2.0])]]
    expected = sum(w * vector_mass(blocks, 3).toarray() for w, blocks in zip((0.5, -0.25), models, strict=True))
    assert np.allclose(differenced(models, (0.5, -0.25), 3).toarray(), expected, rtol=0.0, atol=ROUNDING)
