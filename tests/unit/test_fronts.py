"""The symbolic factorisation, against elimination of one node after another with sets."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import sparse
from test_linear import pattern_of

from lamella.solve.fronts import _candidates, _Tree, fronts_of, nodes_of
from lamella.solve.layout import FrontLayout
from lamella.solve.lists import Lists
from lamella.solve.symbolic_kernels import time_of

WEIGHTS = np.random.default_rng(1).integers(1, 13, 400).astype(float)


def blocks(n: int = 40, size: int = 3, density: float = 0.06) -> sparse.csr_array:
    """A symmetric matrix of full blocks, with the diagonal; some of the blocks hang together with none."""
    A = sparse.random_array((n, n), density=density, rng=np.random.default_rng(n))
    return sparse.csr_array(sparse.kron(A + A.T + sparse.eye_array(n), np.ones((size, size))))


def grid(n: int) -> sparse.csr_array:
    """The nodes of n by n elements, each connected to those around it."""
    line = np.abs(np.subtract.outer(np.arange(n + 1), np.arange(n + 1))) <= 1
    return sparse.csr_array(sparse.kron(line, line))


def graph_of(A: sparse.csr_array) -> Lists:
    A.sort_indices()
    return Lists(A.indices.astype(np.int64), A.indptr.astype(np.int64))


def lists(found: Lists) -> list[list[int]]:
    return [found.numbers[first:end].tolist() for first, end in zip(found.starts[:-1], found.starts[1:], strict=True)]


def left_beside(A: sparse.csr_array, pivots: list[list[int]]) -> list[set[int]]:
    """What each front is connected to when its nodes are eliminated, front after front."""
    near = [set(nodes) - {i} for i, nodes in enumerate(lists(graph_of(A)))]
    found = []
    for front in pivots:
        for node in front:
            for other in near[node]:
                near[other] = (near[other] | near[node]) - {node, other}
        found.append(near[front[-1]])
    return found


def test_lists_are_taken_and_joined():
    some = Lists(np.array([5, 6, 7, 8, 9]), np.array([0, 2, 2, 5]))
    assert lists(some.take(np.array([2, 1, 0, 2]))) == [[7, 8, 9], [], [5, 6], [7, 8, 9]]
    groups = Lists(np.array([2, 0, 1]), np.array([0, 2, 2, 3]))
    assert lists(some.joined(groups)) == [[7, 8, 9, 5, 6], [], []]


@pytest.mark.parametrize("symmetric", [True, False])
def test_coordinates_with_the_same_neighbours_form_nodes(symmetric: bool):
    A = blocks()
    if not symmetric:
        A = sparse.csr_array(sparse.triu(A, -3))
    pattern = pattern_of(A.toarray(), symmetric=symmetric)[0]
    nodes, graph = nodes_of(pattern)
    full = A.toarray() != 0
    same = {(*full[i], *full[:, i]): None for i in range(len(full))}
    assert [set(node) for node in lists(nodes)] == [
        {i for i in range(len(full)) if (*full[i], *full[:, i]) == one} for one in same
    ]
    heads = [node[0] for node in lists(nodes)]
    reduced = (full | full.T)[np.ix_(heads, heads)]
    assert lists(graph) == [np.flatnonzero(row).tolist() for row in reduced]


@pytest.mark.parametrize("A", [grid(7), blocks(40, 1), sparse.eye_array(1, format="csr")])
def test_fronts_hold_every_node_and_are_left_beside_what_elimination_leaves(A: sparse.csr_array):
    graph = graph_of(sparse.csr_array(A))
    found = fronts_of(graph, WEIGHTS[: len(graph.starts) - 1])
    pivots, rest = lists(found.pivots), lists(found.rest)
    assert sorted(node for front in pivots for node in front) == list(range(len(graph.starts) - 1))
    assert [set(one) for one in rest] == left_beside(sparse.csr_array(A), pivots)
    assert [len(set(one)) for one in rest] == [len(one) for one in rest]


def test_fronts_are_merged_where_that_saves_time():
    A = grid(9)
    graph = graph_of(A)
    for order in _candidates(graph):
        own = left_beside(A, [[node] for node in order.tolist()])
        alone = sum(time_of(WEIGHTS[node], WEIGHTS[list(rest)].sum()) for node, rest in zip(order, own, strict=True))
        tree = _Tree(graph, WEIGHTS[: len(order)], order)
        merged, found = tree.merge(), tree.fronts()
        assert merged < alone
        sizes = [(WEIGHTS[p].sum(), WEIGHTS[u].sum()) for p, u in zip(lists(found.pivots), lists(found.rest), strict=True)]
        assert merged == pytest.approx(sum(time_of(*size) for size in sizes), rel=1e-12)  # sums in another order
        parent = {node: f for f, front in enumerate(lists(found.pivots)) for node in front}
        for f, (p, u) in enumerate(sizes):  # no child that is left would have saved time alone
            rest = lists(found.rest)[f]
            if rest:
                above = min(parent[node] for node in rest)
                assert above > f
                assert time_of(p + sizes[above][0], sizes[above][1]) > time_of(p, u)


@pytest.mark.parametrize("symmetric", [True, False])
def test_entries_stand_in_the_panel_of_the_front_that_eliminates_them(symmetric: bool):
    pattern = pattern_of(blocks(30, 5, 0.1).toarray(), symmetric=symmetric)[0]
    layout = FrontLayout(pattern)
    p, q = layout.position[pattern.rows], layout.position[pattern.indices]
    owner, place, above = layout.by_entry(pattern)
    np.testing.assert_array_equal(above, p < q)
    np.testing.assert_array_equal(pattern.indices[layout.diagonal], pattern.rows[layout.diagonal])
    np.testing.assert_array_equal(layout.diagonal_position, layout.position[pattern.rows[layout.diagonal]])
    for f, (first, n, a_len, a0, u, *_, more, _, _, _) in enumerate(layout.fronts[:-1].tolist()):
        rows = [*range(first, first + n), *layout.rows[more : more + u].tolist()]
        own = np.flatnonzero(owner == f)
        column, row = np.minimum(p, q)[own], np.maximum(p, q)[own]
        assert np.all((column >= first) & (column < first + n))
        np.testing.assert_array_equal(place[own], a0 + (column - first) * a_len + [rows.index(i) for i in row])
        np.testing.assert_array_equal(layout.pivots[first : first + n], a0 + np.arange(n) * (a_len + 1))
    numbers, slots, starts = layout.entries
    assert sorted(numbers[numbers >= 0]) == list(range(len(p)))
    np.testing.assert_array_equal(slots[numbers >= 0], place[numbers[numbers >= 0]])
    assert sorted(slots[numbers < 0]) == sorted(layout.pivots[layout.padded])
    of = np.repeat(np.arange(len(starts) - 1), np.diff(starts))
    np.testing.assert_array_equal(of[numbers >= 0], owner[numbers[numbers >= 0]])
