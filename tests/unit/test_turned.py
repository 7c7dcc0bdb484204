"""A factorisation that turns with the structure: exact for a rotation of the whole, not used where parts turn differently."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from linear_systems import hub

import lamella as lm
from lamella.assembly.equations import Equations
from lamella.assembly.point import Weights
from lamella.math.rotation import matrix_from_vector
from lamella.solve.linear import linear_solver
from lamella.solve.turned import TurnedSolver, Vectors
from lamella.solve.turned_nodes import NodeTurns

SECTION = lm.Laminate(lm.Isotropic(E=2e9, nu=0.3, rho=1200.0), thickness=0.004)
WEIGHTS = Weights(1.0, 20.0, 400.0)


def free_strip():
    """A free strip with damping, somewhat bent and moving."""
    system = lm.System()
    system.add(lm.Plate("strip", (1.0, 0.2), (4, 1), SECTION, damping=1e-3))
    equations = Equations(system.compile())
    point = equations.start()
    rng = np.random.default_rng(3)
    point.u = point.u + 1e-6 * rng.standard_normal(equations.n_u) * equations.magnitude
    point.ud = 1e-3 * rng.standard_normal(equations.n_u)
    return equations, point


def turned(equations, u, vector):
    """Independent coordinates after a rotation of the whole about the origin."""
    vectors, R = u.reshape(-1, 3), matrix_from_vector(np.array(vector))
    return (vectors @ R.T).reshape(-1)


def solver_at(equations, point):
    """A turned solver with the factorisation of the matrix at a point."""
    solver = TurnedSolver(linear_solver(equations.matrix.pattern), Vectors(equations))
    _, _, k, j = equations.linearise(point, WEIGHTS)
    solver.factorise(k, j)
    solver.made_at(point.u)
    return solver


@pytest.mark.parametrize("vector", [(0.0, 0.3, 0.0), (0.2, -0.4, 1.0)], ids=repr)
def test_after_a_rotation_of_the_whole_the_old_factorisation_solves_the_new_system(vector):
    equations, point = free_strip()
    solver = solver_at(equations, point)
    new = replace(point, u=turned(equations, point.u, vector), ud=turned(equations, point.ud, vector))
    exact = solver_at(equations, new)
    r = np.random.default_rng(4).standard_normal(equations.n_u)
    x, _ = exact.solve(r, np.zeros(0))
    stale, _ = solver.solve(r, np.zeros(0))
    assert np.linalg.norm(stale - x) > 0.1 * np.linalg.norm(x)
    solver.turn(new.u)
    found, _ = solver.solve(r, np.zeros(0))
    np.testing.assert_allclose(found, x, atol=1e-11 * np.abs(x).max())


def test_what_turns_apart_is_solved_by_the_factorisation_as_it_is():
    equations, point = free_strip()
    solver = solver_at(equations, point)
    u = point.u.reshape(-1, 3).copy()
    half = np.repeat(u[equations.model.is_position, 0] > 0.5, 4)  # with the slopes of each node
    for side, angle in ((half, 0.1), (~half, -0.1)):
        u[side] = u[side] @ matrix_from_vector(np.array((0.0, angle, 0.0))).T
    r = np.random.default_rng(4).standard_normal(equations.n_u)
    plain, _ = solver.solve(r, np.zeros(0))
    solver.turn(u.reshape(-1))
    found, _ = solver.solve(r, np.zeros(0))
    np.testing.assert_array_equal(found, plain)


@pytest.mark.parametrize("u", ["unchanged", "not finite"])
def test_without_a_change_or_a_number_nothing_is_turned(u):
    equations, point = free_strip()
    solver = solver_at(equations, point)
    r = np.ones(equations.n_u)
    plain, _ = solver.solve(r, np.zeros(0))
    solver.turn(point.u if u == "unchanged" else np.full_like(point.u, np.nan))
    found, _ = solver.solve(r, np.zeros(0))
    np.testing.assert_array_equal(found, plain)


def test_a_new_factorisation_is_not_turned_by_the_rotation_of_the_old():
    equations, point = free_strip()
    solver = solver_at(equations, point)
    new = replace(point, u=turned(equations, point.u, (0, 0.5, 0)), ud=turned(equations, point.ud, (0, 0.5, 0)))
    solver.turn(new.u)
    _, _, k, j = equations.linearise(new, WEIGHTS)
    solver.factorise(k, j)
    solver.made_at(new.u)
    r = np.ones(equations.n_u)
    np.testing.assert_array_equal(solver.solve(r, np.zeros(0))[0], solver_at(equations, new).solve(r, np.zeros(0))[0])


def test_components_that_do_not_move_freely_are_left_out():
    equations = Equations(hub().compile())
    vectors = Vectors(equations)
    assert np.any(vectors.rows < 0)
    assert np.all(vectors.slopes >= 0)
    assert sorted(vectors.rows[vectors.rows >= 0]) == list(range(equations.n_motion))


def test_a_turning_hub_and_blade_keep_their_factorisation(monkeypatch):
    runs = []
    for _ in range(2):
        runs.append(lm.simulate(hub(torque=0.02), 0.5, lm.GeneralizedAlpha(dt=2e-3, rho_inf=0.9)))
        monkeypatch.setattr(TurnedSolver, "turn", lambda solver, u: None)
    with_it, without = (run.statistics for run in runs)
    assert with_it.factorisations < 0.2 * without.factorisations  # 4 and 95
    assert with_it.newton_iterations < 0.8 * without.newton_iterations  # 834 and 1322
    np.testing.assert_allclose(runs[0]["tip.position"].values, runs[1]["tip.position"].values, atol=1e-6)


@pytest.mark.parametrize("heated", [False, True])
def test_vectors_turn_with_their_nodes_and_all_else_stays(heated):
    """Of a plate with an edge that is held across, where components are left out, and with or without its temperatures."""
    ply = lm.Lamina(E1=181e9, E2=10.3e9, G12=7.7e9, nu12=0.28, rho=1560.0, alpha1=0.0, alpha2=3e-5, k1=5.0, k2=0.7, c=900.0)
    system = lm.System()
    plate = system.add(lm.Plate("plate", (1.0, 0.5), (3, 2), lm.Laminate(ply, angles=(0.0, 90.0, 0.0), thickness=4e-3)))
    system.add(lm.EdgeSupport("edge", plate.edge("x-"), "z"))
    if heated:
        system.add(lm.TemperatureField("heat", plate))
    equations = Equations(system.compile())
    nodes = Vectors(equations).nodes
    assert nodes is not None
    rng, start = np.random.default_rng(4), equations.start().u
    there = start + 0.3 * rng.standard_normal(len(start))
    turns = NodeTurns(nodes)
    turns.begin(start)
    turns.turn(there)
    x, expected = rng.standard_normal((2, equations.n_u))
    expected[:] = x
    frames = [[frame(u[i : i + 3], u[j : j + 3]) for i, j in nodes.slopes] for u in (start, there)]
    for place, owner in zip(nodes.places, nodes.owners, strict=True):
        expected[place : place + 3] = frames[1][owner] @ frames[0][owner].T @ x[place : place + 3]
    assert (equations.n_u > equations.n_motion) == heated
    assert len(nodes.others) > 0
    assert nodes.others.max() < equations.n_motion
    for n in (equations.n_motion, equations.n_u):  # staggered steps solve for motion alone
        np.testing.assert_allclose(turns.forth(x[:n].copy()), expected[:n], atol=1e-14)
        np.testing.assert_allclose(turns.back(expected[:n].copy()), x[:n], atol=1e-14)


def frame(a, b):
    """Of a node with the slopes a and b: the bisector of their directions, the normal, and what is normal to both."""
    t, m = a / np.linalg.norm(a) + b / np.linalg.norm(b), np.cross(a, b)
    t, m = t / np.linalg.norm(t), m / np.linalg.norm(m)
    return np.stack([t, np.cross(m, t), m], axis=1)
