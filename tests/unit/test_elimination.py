"""Constant linear constraints become q = T u + G c, and their reactions are those of statics."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import lamella as lm
from lamella.assembly.elimination import eliminate
from lamella.assembly.equations import Equations
from lamella.dofs import LinearRow
from lamella.errors import ConstraintError
from lamella.math.rotation import matrix_from_vector

SECTION = lm.Laminate(lm.Isotropic(E=2e9, nu=0.3, rho=1200.0), thickness=0.02)


def row(coords, coefs, constant, motion=None, label="row"):
    return LinearRow(label, np.asarray(coords), np.asarray(coefs, float), constant, motion)


def dense_rows(rows, n_q):
    C = np.zeros((len(rows), n_q))
    for k, one in enumerate(rows):
        np.add.at(C[k], one.coords, one.coefs)
    return C


@given(seed=st.integers(0, 10_000), n_rows=st.integers(0, 9), width=st.integers(1, 5))
def test_random_rows_are_satisfied_and_leave_the_rest_free(seed, n_rows, width):
    rng, n_q = np.random.default_rng(seed), 12
    truth = rng.standard_normal(n_q)
    rows = []
    for k in range(n_rows):
        coords = rng.choice(n_q, width, replace=False)
        coefs = rng.uniform(0.5, 2.0, width) * rng.choice([-1, 1], width)
        rows.append(row(coords, coefs, float(coefs @ truth[coords]), label=f"row {k}"))
    found = eliminate(rows, n_q)
    C, c = dense_rows(rows, n_q), np.array([one.constant for one in rows])
    rank = np.linalg.matrix_rank(C) if n_rows else 0
    assert found.T.shape == (n_q, n_q - rank)
    assert len(found.kept) == rank
    u = rng.standard_normal(n_q - rank)
    q = found.T @ u + found.particular(found.right_hand_side(0.0))
    # a few substitutions, each of which may enlarge rounding by a ratio of coefficients
    np.testing.assert_allclose(C @ q, c, atol=1e-9 * (1 + np.abs(q).max()))
    np.testing.assert_array_equal(q[found.independent], u)


def test_weighted_and_repeated_rows():
    rows = [row([0, 1], [1, 2], 3.0), row([1, 2], [1, -1], 0.5), row([0, 2], [2, 4], 4.0)]  # the last is 2 (first) - 4 (second)
    found = eliminate(rows, 4)
    assert found.kept == (0, 1)
    assert found.T.shape == (4, 2)
    assert found.relations == ({2: 1.0, 0: -2.0, 1: 4.0},)


def test_contradiction_names_both_sides():
    rows = [row([0], [1.0], 1.0, label="x of the hook"), row([1], [1.0], 0.0), row([0], [2.0], 2.5, label="x of the eye")]
    with pytest.raises(ConstraintError, match=r"x of the eye contradicts x of the hook"):
        eliminate(rows, 3)


def test_same_motion_twice_is_redundant_and_another_motion_contradicts():
    drive, other = lm.Ramp(t_end=1.0), lm.Ramp(t_end=2.0)
    assert eliminate([row([0], [1], 0.0, drive), row([0], [1], 0.0, drive)], 2).kept == (0,)
    with pytest.raises(ConstraintError, match="contradicts"):
        eliminate([row([0], [1], 0.0, drive), row([0], [1], 0.0, other)], 2)
    with pytest.raises(ConstraintError, match="contradicts"):
        eliminate([row([0], [1], 0.0), row([0], [1], 0.0, drive)], 2)


def test_moving_right_hand_side_and_its_rates():
    drive = lm.Harmonic(amplitude=0.3, frequency=2.0)
    found = eliminate([row([0, 1], [1, 1], 0.7, drive)], 3)
    assert found.moves
    t = 0.137
    assert found.right_hand_side(t) == pytest.approx([0.7 + drive.value(t)])
    assert found.right_hand_side(t, 0.5) == pytest.approx([0.7 + 0.5 * drive.value(t)])
    assert found.rates(t) == pytest.approx([drive.rate(t)])
    assert found.accelerations(t) == pytest.approx([drive.acceleration(t)])


def test_rows_of_one_coordinate_each_need_no_factorisation():
    rows = [row([3], [2.0], 4.0), row([1], [-0.5], 1.0), row([3], [1.0], 2.0), row([0], [1.0], 0.0)]
    found = eliminate(rows, 5)
    assert found.kept == (0, 1, 3)
    np.testing.assert_array_equal(found.independent, [2, 4])
    np.testing.assert_array_equal(found.T.toarray(), np.eye(5)[:, [2, 4]])
    np.testing.assert_allclose(found.particular(found.right_hand_side(0.0)), [0.0, -2.0, 0.0, 2.0, 0.0])
    np.testing.assert_allclose(found.particular(np.eye(3)), np.linalg.pinv(found.C.toarray()))
    mu = np.array([3.0, -2.0, 0.5])
    np.testing.assert_allclose(found.row_forces(found.C.T @ mu), mu)
    np.testing.assert_allclose(found.forces_of(np.array([2, 0]))(found.C.T @ mu), mu[[2, 0]])
    of, coords, coefs = found.entries_of(np.array([1, 0]))
    assert (of.tolist(), coords.tolist(), coefs.tolist()) == ([0, 1], [1, 3], [-0.5, 2.0])


def test_a_coefficient_of_zero_holds_nothing():
    assert eliminate([row([1], [0.0], 0.0)], 2).kept == ()


def test_row_forces_recover_the_multipliers():
    rng = np.random.default_rng(5)
    rows = [row([0, 1, 2], rng.standard_normal(3), 0.0), row([2, 3], [1, 1], 0.0), row([5], [1], 0.0)]
    found = eliminate(rows, 6)
    mu = rng.standard_normal(3)
    np.testing.assert_allclose(found.row_forces(found.C.T @ mu), mu, atol=1e-13)
    np.testing.assert_allclose(found.forces_of(np.array([2, 0]))(found.C.T @ mu), mu[[2, 0]], atol=1e-13)


def plate(rotation=(0.1, -0.3, 0.7), **changes):
    given = {"size": (1.2, 0.9), "mesh": (2, 2), "laminate": SECTION, "position": (0.4, -0.2, 0.3), "rotation": rotation}
    return lm.Plate("plate", **(given | changes))


def balance(result, supports, load_point, load):
    """Sum of forces, and of torques about the origin, of supports and one point force."""
    force, torque = np.array(load, float), np.cross(result[f"{load_point}.position"].values[...], load)
    for name, centre in supports.items():
        part = result[f"{name}.force"].values
        force = force + part
        torque = torque + result[f"{name}.torque"].values + np.cross(centre(result), part)
    return force, torque


def test_reactions_balance_a_load_in_statics():
    system, body = lm.System(), plate()
    system.add(body)
    body.marker("tip", 1.2, 0.31)
    system.add(lm.Clamp("root", body.edge("x-")))
    load = (12.0, -7.0, 20.0)
    system.add(lm.PointForce("load", body.marker("tip", 1.2, 0.31), load))
    middle = np.array((0.4, -0.2, 0.3)) + matrix_from_vector(np.array((0.1, -0.3, 0.7))) @ np.array((0.0, 0.45, 0.0))
    force, torque = balance(lm.equilibrium(system), {"root": lambda r: middle}, "tip", load)
    # Newton accepts a displacement error of 1e-8 of the size; membrane stiffness A = 4.4e7 N/m turns it into forces
    assert np.abs(force).max() < 1e-5
    assert np.abs(torque).max() < 1e-5


def test_two_clamps_that_share_a_corner_give_the_correct_total():
    load = (3.0, 5.0, 40.0)
    system, body = lm.System(), plate(rotation=(0, 0, 0), position=(0, 0, 0))
    system.add(body)
    tip = body.marker("tip", 1.2, 0.9)
    system.add(lm.Clamp("left", body.edge("x-")))
    system.add(lm.Clamp("front", body.edge("y-")))
    system.add(lm.PointForce("load", tip, load))
    result = lm.equilibrium(system)
    centres = {"left": lambda r: np.array((0, 0.45, 0)), "front": lambda r: np.array((0.6, 0, 0))}
    force, torque = balance(result, centres, "tip", load)
    assert np.abs(force).max() < 1e-5
    assert np.abs(torque).max() < 1e-5


def test_support_inside_an_element_is_held_and_carries_the_load():
    system, body = lm.System(), plate(rotation=(0, 0, 0), position=(0, 0, 0))
    system.add(body)
    at = {"a": (0.13, 0.17), "b": (1.01, 0.23), "c": (0.47, 0.81)}  # none is a node: 16 weights each
    for name, (x, y) in at.items():
        system.add(lm.PointSupport(f"pin {name}", body.marker(name, x, y)))
    tip = body.marker("tip", 0.55, 0.4)
    load = (0.0, 0.0, -30.0)
    system.add(lm.PointForce("load", tip, load))
    result = lm.equilibrium(system)
    for name, (x, y) in at.items():
        np.testing.assert_allclose(result[f"{name}.position"], (x, y, 0.0), atol=1e-13)
    centres = {f"pin {name}": lambda r, name=name: r[f"{name}.position"].values for name in at}
    force, torque = balance(result, centres, "tip", load)
    assert np.abs(force).max() < 1e-5
    assert np.abs(torque).max() < 1e-5
    for name in at:  # a pin at a point transmits no moment: its rows act through the point itself
        assert np.abs(result[f"pin {name}.torque"]).max() < 1e-9 * 30.0


def test_reactions_include_inertia_in_motion():
    system, body = lm.System(), plate()
    system.add(body)
    system.add(lm.Clamp("root", body.edge("x-"), motion={"z": lm.Harmonic(amplitude=0.01, frequency=5.0)}))
    load = np.array((0.0, 0.0, 15.0))
    system.add(lm.PointForce("load", body.marker("tip", 1.2, 0.9), tuple(load)))
    result = lm.simulate(system, 0.02, lm.GeneralizedAlpha(dt=2e-3))
    state, model = result.final, result.model
    momentum_rate = (model.mass @ state.a).reshape(-1, 3)[model.is_position].sum(axis=0)
    total = result["root.force"].values[-1] + load
    assert np.abs(momentum_rate).max() > 1.0  # the balance below is not one of zeros
    np.testing.assert_allclose(total, momentum_rate, atol=1e-4 * np.abs(momentum_rate).max())


def test_residual_of_independent_coordinates_vanishes_at_equilibrium():
    system, body = lm.System(), plate()
    system.add(body)
    system.add(lm.Clamp("root", body.edge("x-")))
    system.add(lm.Gravity("weight"))
    result = lm.equilibrium(system)
    equations = Equations(result.model)
    point = equations.point_of(result.final, 0.0)
    point.at_rest = True
    r, _ = equations.residual(point)
    weight = 1.2 * 0.9 * 0.02 * 1200 * 9.81
    assert np.abs(r).max() < 1e-6 * weight
