"""The assembled matrix is the derivative of the assembled residual, with every kind of block and constraint present."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import sparse

import lamella as lm
from lamella.assembly import product
from lamella.assembly.equations import Equations
from lamella.assembly.expand import expand_matrix
from lamella.assembly.operator import ScatterSum, SumOperator
from lamella.assembly.point import STATIC, Weights
from lamella.load.dead import DeadLoadBlock

SECTION = lm.Laminate(lm.Isotropic(E=2e9, nu=0.3, rho=1200.0), thickness=0.02)
DRIVE = lm.Harmonic(amplitude=0.02, frequency=3.0)
T = 0.11
STEP = {"K": 1e-4, "D": 1.0, "M": 100.0, "all": 1e-4}  # the residual is linear in v and a: a long step has less rounding
PARTS = {"K": Weights(1.0, 0.0, 0.0), "D": Weights(0.0, 1.0, 0.0), "M": Weights(0.0, 0.0, 1.0), "all": Weights(1.0, 40.0, 2000.0)}


def everything():
    """Two plates with damping, every load with a tangent, moving and weighted supports, and multipliers between the plates."""
    system = lm.System()
    a = lm.Plate("a", (1.0, 0.8), (2, 2), SECTION, rotation=(0.2, 0.1, -0.4), damping=3e-3, mass_damping=0.7)
    b = lm.Plate("b", (0.7, 0.5), (2, 1), SECTION, position=(0.3, 0.2, 0.6), rotation=(0.0, -0.3, 0.2))
    system.add(a)
    system.add(b)
    system.add(lm.Clamp("root", a.edge("x-"), motion={"z": DRIVE}))
    system.add(lm.PointSupport("inside", a.marker("inside", 0.77, 0.31), axes="xz"))
    system.add(lm.PrescribedMotion("drive", b.corner("x-y-"), "y", DRIVE))
    system.add(lm.DistanceJoint("rod", a.marker("hook", 0.9, 0.7), b.marker("eye", 0.2, 0.1)))
    system.add(lm.DistanceJoint("stay", lm.Ground(markers={"peg": (0, 0, 2.0)}).marker("peg", 0, 0, 2.0), b.corner("x+y+")))
    system.add(lm.Ground())
    system.add(lm.Gravity("weight"))
    system.add(lm.Pressure("wind", a, 300.0, DRIVE))
    system.add(lm.PointMoment("twist", b.marker("m", 0.5, 0.3), (3.0, -4.0, 5.0), follower=True))
    system.add(lm.EdgeMoment("bend", a.edge("x+"), (2.0, 3.0, -1.0)))
    system.add(lm.PointForce("pull", b.corner("x+y-"), (5.0, 6.0, -9.0)))
    return system.compile()


@pytest.fixture(scope="module")
def model():
    return everything()


@pytest.fixture(scope="module")
def equations(model):
    return Equations(model, symmetric=False)


def deformed(equations, seed=3):
    rng = np.random.default_rng(seed)
    point = equations.start(T)
    size = equations.magnitude
    point.u += 0.05 * size * rng.uniform(-1, 1, equations.n_u)
    point.ud += 2.0 * size * rng.uniform(-1, 1, equations.n_u)
    point.udd += 50.0 * size * rng.uniform(-1, 1, equations.n_u)
    point.lam += rng.uniform(-200, 200, equations.n_lam)
    return point


def dense(equations, point, weights):
    _, _, k, j = equations.linearise(point, weights)
    pattern = equations.matrix.pattern
    return pattern.matrix(k.copy()).toarray(), pattern.jacobian(j.copy()).toarray()


def moved(point, weights, du):
    new = point.copy()
    new.u += weights.alpha_q * du
    new.ud += weights.alpha_v * du
    new.udd += weights.alpha_a * du
    return new


def difference(equations, point, weights, du, h):
    """Derivative of (r, Phi) along du: central differences extrapolated to fourth order."""

    def central(step):
        ahead, behind = (equations.residual(moved(point, weights, s * du)) for s in (step, -step))
        ahead, behind = ([x.copy() for x in pair] for pair in (ahead, behind))
        return [(x - y) / (2 * step) for x, y in zip(ahead, behind, strict=True)]

    return [(4 * fine - coarse) / 3 for coarse, fine in zip(central(2 * h), central(h), strict=True)]


@pytest.mark.parametrize("part", PARTS)
def test_matrix_is_the_derivative_of_the_residual(equations, part):
    weights, point, rng = PARTS[part], deformed(equations), np.random.default_rng(8)
    K, J = dense(equations, point, weights)
    size = equations.magnitude
    scaled = size[:, None] * K * size[None, :]
    for _ in range(5):
        x = rng.uniform(-1, 1, equations.n_u)
        r_du, phi_du = difference(equations, point, weights, size * x, STEP[part])
        # K: error of fourth order, (1e-4 of a body's size)^4, and rounding 1e-16 / 1e-4
        assert np.abs(scaled @ x - size * r_du).max() < 1e-9 * np.abs(scaled @ x).max()
        if weights.alpha_q:
            np.testing.assert_allclose(J @ (size * x), phi_du, rtol=1e-8, atol=1e-9)


def test_one_matrix_is_the_sum_of_its_parts(equations):
    point = deformed(equations)
    K, D, M = (dense(equations, point, PARTS[part])[0] for part in "KDM")
    weights = PARTS["all"]
    whole = dense(equations, point, weights)[0]
    expected = weights.alpha_q * K + weights.alpha_v * D + weights.alpha_a * M
    np.testing.assert_allclose(whole, expected, atol=1e-12 * np.abs(whole).max())


def test_multipliers_enter_with_the_transposed_jacobian(equations):
    point = deformed(equations)
    _, J = dense(equations, point, STATIC)
    assert J.shape == (2, equations.n_u)
    before = equations.residual(point)[0].copy()
    dlam = np.array([3.0, -5.0])
    point.lam += dlam
    change = equations.residual(point)[0] - before
    # the residual holds membrane forces of some 1e7 N, so its change has 1e-9 N of rounding
    np.testing.assert_allclose(change, J.T @ dlam, atol=1e-14 * np.abs(before).max())


def test_symmetric_assembly_gives_the_symmetric_part(model, equations, monkeypatch):
    monkeypatch.setattr(product, "LISTED", 0)  # no tangent is multiplied entry by entry, so that no block takes another form
    monkeypatch.setattr(product, "FOR_EACH", 0)
    half = Equations(model, symmetric=True)
    for weights in PARTS.values():
        K, J = dense(equations, deformed(equations), weights)
        S, J_half = dense(half, deformed(half), weights)
        np.testing.assert_allclose(S, 0.5 * (K + K.T), atol=1e-13 * np.abs(K).max())
        np.testing.assert_array_equal(J_half, J)


def test_choice_of_symmetry_follows_the_blocks(model):
    assert not Equations(model).symmetric  # pressure on free edges
    system, plate = lm.System(), lm.Plate("a", (1.0, 0.8), (1, 1), SECTION, damping=1e-3)
    system.add(plate)
    assert Equations(system.compile()).symmetric


def test_elimination_is_a_congruence_of_the_free_matrix(model, equations):
    """K_u = T^T K T with K assembled from the same blocks without any support."""
    free = Equations(_without_supports(model), symmetric=False)
    point = deformed(equations)
    loose = free.start(T)
    loose.u, loose.ud, loose.udd = equations.coordinates(point), equations.velocities(point), equations.accelerations(point)
    loose.lam = point.lam.copy()
    T_dense = equations.elimination.T.toarray()
    for weights in PARTS.values():
        whole, J_whole = dense(free, loose, weights)
        K, J = dense(equations, point, weights)
        np.testing.assert_allclose(K, T_dense.T @ whole @ T_dense, atol=1e-13 * np.abs(whole).max())
        np.testing.assert_allclose(J, J_whole @ T_dense, atol=1e-14)
    r = equations.residual(point)[0].copy()
    np.testing.assert_allclose(r, T_dense.T @ free.residual(loose)[0], atol=1e-13 * np.abs(r).max())


def _without_supports(model):
    from dataclasses import replace

    return replace(model, rows=(), supports=())


def test_moving_supports_give_positions_velocities_and_accelerations(model, equations):
    q, v, a = [], [], []
    h = 1e-4
    for t in (T - h, T, T + h):
        point = equations.start(t)
        point.ud[:] = point.udd[:] = 0.0
        q.append(equations.coordinates(point).copy())
        v.append(equations.velocities(point).copy())
        a.append(equations.accelerations(point).copy())
    omega = 2 * np.pi * 3.0
    np.testing.assert_allclose(v[1], (q[2] - q[0]) / (2 * h), atol=0.02 * omega**3 * h**2)
    np.testing.assert_allclose(a[1], (q[2] - 2 * q[1] + q[0]) / h**2, atol=0.02 * omega**4 * h**2)
    assert np.abs(v[1]).max() > 0.1


def test_point_at_rest_has_no_velocity_of_supports(equations):
    point = equations.start(T, at_rest=True)
    assert np.abs(equations.velocities(point)).max() == 0.0
    assert np.abs(equations.accelerations(point)).max() == 0.0


def test_load_factor_scales_loads_and_motions(equations):
    point = deformed(equations)
    point.at_rest, rs = True, []
    direction = equations.load_direction(point)
    for factor in (1.0 - 1e-3, 1.0 + 1e-3):
        point.factor = factor
        rs.append(equations.residual(point)[0].copy())
    expected = (rs[1] - rs[0]) / 2e-3
    # the direction comes from a forward difference of 1e-7 because supports move
    np.testing.assert_allclose(direction, expected, atol=1e-5 * np.abs(expected).max())


def test_gamma_and_moving_supports_give_the_second_derivative_of_phi(equations):
    """Along u + ud s + udd s^2/2 the constraints' second derivative is J udd + rest."""
    point = deformed(equations)
    _, J = dense(equations, point, STATIC)
    rest = equations.acceleration_rest(point)
    violation = equations.velocity_violation(point).copy()
    h = 2e-4

    def phi(s):
        new = point.copy()
        new.t = T + s
        new.u = point.u + s * point.ud + 0.5 * s**2 * point.udd
        return equations.residual(new)[1].copy()

    second = (-phi(2 * h) + 16 * phi(h) - 30 * phi(0.0) + 16 * phi(-h) - phi(-2 * h)) / (12 * h**2)
    first = (-phi(2 * h) + 8 * phi(h) - 8 * phi(-h) + phi(-2 * h)) / (12 * h)
    np.testing.assert_allclose(violation, first, rtol=1e-7, atol=1e-9)
    np.testing.assert_allclose(J @ point.udd + rest, second, rtol=1e-5, atol=1e-6)


def test_state_and_point_go_back_and_forth(equations):
    point = deformed(equations)
    again = equations.point_of(equations.state(point), T)
    for name in ("u", "ud", "udd", "lam"):
        np.testing.assert_array_equal(getattr(again, name), getattr(point, name))


def test_a_model_without_loads_or_supports_assembles():
    system = lm.System()
    system.add(lm.Plate("a", (1.0, 0.8), (1, 1), SECTION))
    equations = Equations(system.compile())
    assert equations.n_u == 48
    r, _ = equations.residual(equations.start())
    assert np.abs(r).max() < 1e-6  # stress-free: rounding of a membrane stiffness of 4e7


def test_dead_loads_have_no_tangent(model):
    dead = [block for block in model.loads if isinstance(block, DeadLoadBlock)]
    assert dead
    assert all(len(block.k_rows) == 0 for block in dead)


def test_scatter_sum_looks_at_the_parts_in_use_alone():
    """Three parts of which one is not a number: y += E x for the others, with repeated targets and a gap of padding."""
    targets, sources = np.array([2, 0, 1, 0, 2, 1]), np.array([5, 0, 1, 3, 4, 2])
    factors = np.array([2.0, 1.0, -1.0, 0.5, 3.0, 4.0])
    operator = ScatterSum(targets, sources, factors, np.array([0, 2, 4, 6]))
    x, y = np.array([1.0, 2.0, np.nan, np.nan, 5.0, 6.0]), np.ones(3)
    operator.add(x, np.array([True, False, True]), y)
    np.testing.assert_array_equal(y, [2.0, -1.0, 1.0 + 12.0 + 15.0])


def test_sums_of_any_length_are_those_of_the_matrix():
    """Rows of no, one, two, three and four entries, one of them listed twice, as a list and as a matrix."""
    targets, sources = np.array([4, 1, 2, 2, 4, 3, 3, 3, 4, 4, 4]), np.array([0, 2, 1, 1, 3, 0, 1, 2, 2, 1, 5])
    factors = np.arange(1.0, 12.0)
    E, x = np.zeros((5, 6)), np.random.default_rng(0).standard_normal(6)
    np.add.at(E, (targets, sources), factors)
    for operator in (SumOperator(targets, sources, factors, 5), SumOperator.of(sparse.csr_array(E))):
        np.testing.assert_allclose(operator(x), E @ x, rtol=1e-14)  # sums in another order
        np.testing.assert_allclose(operator.transposed(6)(x[:5]), E.T @ x[:5], rtol=1e-14)


@pytest.mark.parametrize("upper", [True, False])
def test_entries_go_through_held_shared_and_mixed_coordinates(upper):
    T = np.array([[1, 0, 0], [0, 2, 0], [0, -3, 0], [0, 0, 0], [0.5, 0, 4]])  # two follow one, one is held, one follows two
    rows, cols = np.triu_indices(5)
    padded_rows, padded_cols = np.append(rows, -1), np.append(cols, 2)
    buffer = np.append(np.random.default_rng(0).standard_normal(15), 7.0)
    scale = np.linspace(1.0, 2.0, 16)
    k = np.zeros((5, 5))
    k[rows, cols] = k[cols, rows] = (buffer * scale)[:15]
    found = expand_matrix(padded_rows, padded_cols, scale, "symmetric", upper, sparse.csr_array(T))
    made = np.zeros((3, 3))
    np.add.at(made, (found.rows, found.cols), found.factors * buffer[found.sources])
    whole = T.T @ k @ T
    np.testing.assert_allclose(made, np.triu(whole) if upper else whole, rtol=1e-13, atol=1e-13)
