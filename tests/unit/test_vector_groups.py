"""Places of contributions found by groups of coordinates are those of the dense matrix."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import sparse

import lamella as lm
from lamella.assembly.equations import Equations
from lamella.assembly.expand import expand_matrix
from lamella.assembly.matrix import MatrixAssembly
from lamella.assembly.point import STATIC, Weights
from lamella.assembly.vector_groups import Followed, Listed, Places, Table, groups_of
from lamella.element.packing import packed, packed_targets
from lamella.lane import WIDTH
from lamella.roles import TangentTables

SECTION = lm.Laminate(lm.Isotropic(E=2e9, nu=0.3, rho=1200.0), thickness=0.02)
N_Q, N = 15, 6
"""Coordinates of five vectors, and those of an element, which has two of them."""
ROWS, COLUMNS = np.triu_indices(N)
VECTORS = np.array([[0, 1], [1, 2], [3, 1], [4, 0], [2, 0], [3, 4], [0, 3], [4, 1], [1, 3], [2, 4]])
"""More elements than there are in a lane, so that the last lane is filled up."""


def table() -> TangentTables:
    coords = (3 * VECTORS[:, :, None] + np.arange(3)).reshape(len(VECTORS), -1)
    scale = np.random.default_rng(0).uniform(0.5, 2.0, coords.shape)
    return TangentTables(packed_targets(coords), packed(scale), ROWS, COLUMNS, N)


def lists(tables: TangentTables) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Row, column and scale of each entry of the buffer."""
    coords, scale = (array.reshape(-1, N, WIDTH) for array in (tables.coords, tables.scale))
    rows, columns = coords[:, ROWS], coords[:, COLUMNS]
    return rows.reshape(-1), columns.reshape(-1), (scale[:, ROWS] * scale[:, COLUMNS]).reshape(-1)


def follows() -> tuple[sparse.csr_array, np.ndarray]:
    """Coordinate 4 is held, and 7 follows 1, which stands in the same elements, by a factor."""
    T = np.eye(N_Q)
    T[7] = -2.0 * T[1]
    T[4] = 0.0
    independent = np.setdiff1d(np.arange(N_Q), [4, 7])
    return sparse.csr_array(T[:, independent]), independent


def test_entries_of_a_table_are_those_of_its_lists():
    tables, (T, independent) = table(), follows()
    followed, buffer = Followed(T), np.random.default_rng(1).standard_normal(len(tables.coords) // N * len(ROWS))
    by_table, listed = Table(tables, followed), Listed(expand_matrix(*lists(tables), "symmetric", True, T))
    assert by_table.suits
    first, group_of = groups_of(independent, by_table.vectors)
    assert len(first) == 6  # five vectors, of which two have two coordinates left
    made = []
    for one in (by_table, listed):
        places = Places([one.pairs(group_of)], first, group_of, symmetric=True)
        found = one.placed(places)
        values = np.bincount(found.slots, found.factors * buffer[found.sources], minlength=len(places.indices))
        made.append(sparse.csr_array((values, places.indices, places.indptr), shape=(len(independent),) * 2).toarray())
    rows, columns, scale = lists(tables)
    used, whole = rows >= 0, np.zeros((N_Q, N_Q))
    np.add.at(whole, (rows[used], columns[used]), (scale * buffer)[used])
    whole += np.triu(whole, 1).T + np.tril(whole, -1).T
    for matrix in made:
        np.testing.assert_allclose(matrix, np.triu(T.T @ whole @ T), rtol=1e-12, atol=1e-12)


def test_a_table_does_not_suit_coordinates_that_follow_several():
    T = np.eye(N_Q)
    T[4, 2] = 0.5
    assert not Table(table(), Followed(sparse.csr_array(T))).suits
    assert not Table(table(), Followed(sparse.csr_array(np.delete(T, 3, axis=1)))).suits  # what is held makes no difference


@pytest.mark.parametrize("symmetric", [True, False])
def test_units_couple_whole_and_places_count_on(symmetric: bool):
    first, group_of = groups_of(np.array([0, 1, 2, 4, 5, 9, 10, 12]), np.array([0, 1]))
    np.testing.assert_array_equal(first, [0, 3, 5, 6, 7, 8])  # two vectors, and the coordinates of two others one by one
    places = Places([(np.array([1, 4, 2]), np.array([0, 1, 2]))], first, group_of, symmetric)
    expected = np.zeros((8, 8), bool)
    for a, b in ((1, 0), (4, 1), *((k, k) for k in range(5))):
        expected[first[a] : first[a + 1], first[b] : first[b + 1]] = True
    if symmetric:
        expected = np.triu(expected | expected.T)
    made = sparse.csr_array((np.ones(len(places.indices)), places.indices, places.indptr), shape=(8, 8))
    np.testing.assert_array_equal(made.toarray() > 0, expected)
    assert made.has_sorted_indices


def test_statics_does_without_the_mass():
    system = lm.System()
    plate = system.add(lm.Plate("plate", (1.0, 0.8), (2, 2), SECTION))
    system.add(lm.Clamp("root", plate.edge("x-")))
    system.add(lm.PointForce("pull", plate.corner("x+y+"), (0.0, 0.0, 1.0)))
    equations = Equations(system.compile())
    lm.equilibrium(equations)
    assert "vector_mass" not in vars(equations.model)
    point = equations.start()
    k, _ = equations.exact_matrix(point, Weights(0.0, 0.0, 1.0))
    M = equations.elimination.T.T @ equations.model.mass @ equations.elimination.T
    np.testing.assert_allclose(equations.matrix.pattern.matrix(k).toarray(), M.toarray(), rtol=1e-12, atol=1e-15)


@pytest.mark.parametrize("symmetric", [True, False])
def test_inertia_has_its_places_where_coordinates_follow_several(symmetric: bool):
    model = tied().compile()
    equations = Equations(model, symmetric=symmetric)
    assert np.any(np.diff(equations.elimination.T.indptr) > 1)
    k, _ = equations.exact_matrix(equations.start(), Weights(0.0, 0.0, 1.0))
    M = equations.elimination.T.T @ model.mass @ equations.elimination.T
    np.testing.assert_allclose(equations.matrix.pattern.matrix(k).toarray(), M.toarray(), rtol=1e-10, atol=1e-13)


def test_a_stiffness_in_all_coordinates_gives_that_in_independent_ones():
    model = tied().compile()
    equations = Equations(model)
    T, point = equations.elimination.T, equations.start()
    point.u += 0.01 * equations.magnitude * np.random.default_rng(2).standard_normal(equations.n_u)
    everything = MatrixAssembly(
        model, equations.constraints, sparse.csr_array(sparse.eye_array(model.n_q)), np.arange(model.n_q), symmetric=False
    )
    q = equations.coordinates(point)
    whole, _ = everything.values(equations.forces, equations.loads, point, q, np.zeros(model.n_q), STATIC, q)
    K = T.T @ everything.pattern.matrix(whole.copy()) @ T
    k, _ = equations.exact_matrix(point, STATIC)
    found = equations.matrix.pattern.matrix(k).toarray()
    np.testing.assert_allclose(found, K.toarray(), rtol=1e-9, atol=1e-9 * np.abs(found).max())


def tied() -> lm.System:
    """A plate that is held at a point within an element, so that one of its coordinates follows others."""
    system = lm.System()
    plate = system.add(lm.Plate("plate", (1.0, 0.8), (3, 2), SECTION))
    system.add(lm.PointSupport("inside", plate.marker("inside", 0.4, 0.3), axes="xyz"))
    system.add(lm.Clamp("root", plate.edge("x-")))
    return system
