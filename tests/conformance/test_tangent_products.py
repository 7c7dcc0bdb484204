"""Products with tangents that are not listed, the symmetric form of damping, and factorisations that turn with the nodes."""

from __future__ import annotations

import numpy as np
import pytest
from shell_patch import SURFACES, dense, gathered_force, patch, random_rotation

import lamella as lm
from lamella.assembly.equations import Equations
from lamella.assembly.point import STATIC
from lamella.element.plate48.block import SHELL
from lamella.element.plate48.section import Section
from lamella.element.plate48.shape import PLATE48
from lamella.lane import aligned
from lamella.solve import newton
from lamella.solve.linear import linear_solver
from lamella.solve.turned import TurnedSolver, Vectors
from lamella.solve.turned_nodes import NodeTurnedSolver, turned_solver

OPTIONS = {"unit": {}, "cubed": {"curvature": "cubed_normal"}, "fewer points": {"membrane_gauss": 3}}
BLOCKS = {"elastic": SHELL.strain_models["exact"], "viscous": SHELL.viscous, "both": SHELL.damped}


@pytest.fixture
def rng():
    return np.random.default_rng(5)


@pytest.fixture(params=list(SURFACES))
def mesh(request):
    return patch(PLATE48, (0.0, 0.5, 0.9), (0.0, 0.4), SURFACES[request.param])


def made(kind, mesh, rng, option):
    A = rng.standard_normal((6, 6))
    time = () if kind == "elastic" else (0.3,)
    return BLOCKS[kind]("plate", *mesh.tables, Section(A @ A.T + np.eye(6), **OPTIONS[option]), *time)


def product(block, q, v, alpha_q, alpha_v, x):
    f = aligned(len(block.f_coords))
    tangent = block.tangent()
    tangent.look(0.0, q, v, alpha_q, alpha_v)
    tangent.multiply(x, f)
    y, used = np.zeros(len(q)), block.f_coords >= 0
    np.add.at(y, block.f_coords[used], (f * block.f_scale)[used])
    return y


@pytest.mark.parametrize("option", OPTIONS)
@pytest.mark.parametrize("kind", BLOCKS)
def test_product_is_that_with_the_tangent(mesh, rng, kind, option):
    block = made(kind, mesh, rng, option)
    q = mesh.rest + 0.05 * rng.standard_normal(mesh.rest.shape)
    v, x = rng.standard_normal((2, len(q)))
    for alpha_q, alpha_v in ((1.3, 0.7), (1.0, 0.0), (0.0, 1.0)):
        expected = dense(block, q, v, alpha_q, alpha_v)[1] @ x
        size = np.abs(expected).max()
        np.testing.assert_allclose(product(block, q, v, alpha_q, alpha_v, x), expected, atol=1e-12 * size)
        if block.symmetric_form is not None:
            np.testing.assert_allclose(product(block.symmetric_form, q, v, alpha_q, alpha_v, x), expected, atol=1e-12 * size)


@pytest.mark.parametrize("option", OPTIONS)
@pytest.mark.parametrize("kind", ["viscous", "both"])
def test_symmetric_form_of_damping_leaves_out_what_turns_with_the_motion(mesh, rng, kind, option):
    block = made(kind, mesh, rng, option)
    form = block.symmetric_form
    assert form is not None
    q = mesh.rest + 0.05 * rng.standard_normal(mesh.rest.shape)
    v, earlier = rng.standard_normal(q.shape), q + 0.01 * rng.standard_normal(q.shape)
    assert form.symmetry == "symmetric"
    for previous in (q, earlier):
        (f, K), (own_f, S) = (dense(each, q, v, 1.3, 0.7, previous) for each in (block, form))
        np.testing.assert_allclose(own_f, f, atol=1e-13 * np.abs(f).max())
        np.testing.assert_allclose(gathered_force(form, q, v), f, atol=1e-13 * np.abs(f).max())
        # K - S = R is linear in the velocity and in alpha_q: half of both is a quarter, the velocity of S aside
        (_, half), (_, own_half) = (dense(each, q, 0.5 * v, 0.65, 0.35, previous) for each in (block, form))
        np.testing.assert_allclose(half - own_half, 0.25 * (K - S), atol=1e-11 * np.abs(K).max())
        assert np.abs(K - S).max() > 1e-3 * np.abs(K).max()
    still = 0.0 * v
    K, S = (dense(each, q, still, 1.3, 0.7)[1] for each in (block, form))
    np.testing.assert_allclose(S, K, atol=1e-12 * np.abs(K).max())


def cantilever():
    """A damped plate that is pushed at its end."""
    layup = lm.Laminate(lm.Isotropic(7e10, 0.3, 2700.0), thickness=4e-3)
    system = lm.System()
    plate = system.add(lm.Plate("plate", (1.5, 2.0), (3, 3), layup, damping=1e-3))
    system.add(lm.Clamp("root", plate.edge("x-")))
    system.add(lm.PointForce("push", plate.marker("tip", 1.5, 1.0), (0.0, 0.0, -10.0)))
    return system


def test_turned_factorisation_is_that_of_the_turned_plate(rng):
    layup = lm.Laminate(lm.Isotropic(7e10, 0.3, 2700.0), thickness=2e-3)
    system = lm.System()
    system.add(lm.Plate("plate", (1.0, 0.4), (2, 1), layup))
    equations = Equations(system.compile())
    start, weights = equations.start(at_rest=True), STATIC._replace(alpha_a=1e4)
    start.u += 1e-3 * np.sin(np.arange(len(start.u)))
    R = random_rotation(rng)
    after = start.moved_to((start.u.reshape(-1, 3) @ R.T).reshape(-1))
    solver = turned_solver(linear_solver(equations.matrix.pattern), Vectors(equations))
    assert isinstance(solver, NodeTurnedSolver)
    solver.factorise(*equations.exact_matrix(start, weights))
    solver.made_at(start.u)
    r, none = np.cos(np.arange(equations.n_u)), np.zeros(0)
    first = solver.solve(r, none)[0]
    solver.turn(after.u)
    found = solver.solve(r, none)[0]
    solver.factorise(*equations.exact_matrix(after, weights))
    expected = solver.solve(r, none)[0]
    assert np.abs(first - expected).max() > 0.1 * np.abs(expected).max()
    np.testing.assert_allclose(found, expected, atol=1e-7 * np.abs(expected).max())  # rounding times the condition


def test_factorisations_that_turn_with_each_node_serve_longer_than_those_that_turn_as_a_whole(monkeypatch):
    method, runs = lm.GeneralizedAlpha(dt=1e-3, rho_inf=0.9), []
    for made in (turned_solver, TurnedSolver, lambda linear, vectors: None):
        monkeypatch.setattr(newton, "turned_solver", made)
        runs.append(lm.simulate(cantilever(), 0.3, method))
    by_nodes, whole, not_at_all = (run.statistics for run in runs)
    assert by_nodes.factorisations <= 0.7 * min(whole.factorisations, not_at_all.factorisations)
    assert by_nodes.newton_iterations <= 1.05 * min(whole.newton_iterations, not_at_all.newton_iterations)
    for run in runs[1:]:
        np.testing.assert_allclose(runs[0]["tip.position"].values, run["tip.position"].values, atol=1e-4)  # 1 m long
