"""Forces written in Python: tangents, the comparison with differences, statics and motion, and what files say of them."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from measure_cases import derivative

import lamella as lm
from lamella.dofs import Build
from lamella.errors import DeclarationError, FunctionError, ModelError, ModelFileError, ResultFileError
from lamella.io.model_file import dumps, loads
from lamella.io.schema import json_schema
from lamella.result import Cause

TIME = 0.7
SHEET = lm.Laminate(lm.Isotropic(E=70e9, nu=0.3, rho=2700.0), thickness=0.01)


def spring_between(t, r, v):
    """A stiffening spring and an air drag between two points: nonlinear in r, in v, and in both."""
    d, rate = r[1] - r[0], v[1] - v[0]
    pull = (3.0 + t + 2.0 * d @ d) * d + (1.0 + d @ d) * np.linalg.norm(rate) * rate
    return np.stack([pull, -pull])


def spring_tangent(t, r, v):
    d, rate = r[1] - r[0], v[1] - v[0]
    speed, one = np.linalg.norm(rate), np.eye(3)
    by_d = (3.0 + t + 2.0 * d @ d) * one + 4.0 * np.outer(d, d) + 2.0 * speed * np.outer(rate, d)
    by_rate = (1.0 + d @ d) * (speed * one + np.outer(rate, rate) / speed)
    signs = np.array([[-1.0, 1.0], [1.0, -1.0]])
    return np.kron(signs, by_d), np.kron(signs, by_rate)


def well(t, r, v):
    return -5.0 * r * (1.0 + (r**2).sum(axis=1, keepdims=True))


def well_tangent(t, r, v):
    return -5.0 * (np.eye(3) * (1.0 + r[0] @ r[0]) + 2.0 * np.outer(r[0], r[0])), np.zeros((3, 3))


class Case:
    """A force between a plate and a rigid body, or on the body alone, in a random state."""

    def __init__(self, function, tangent=None, *, potential=False, both=True):
        plate = lm.Plate("plate", (1.0, 0.8), (1, 1), SHEET)
        body = lm.RigidBody("body", mass=1.0, inertia=(0.1, 0.1, 0.1), position=(0.3, 0.2, 0.9))
        tip = body.marker("tip", 0.1, 0.2, -0.3)
        places = (plate.marker("spot", 0.3, 0.7), tip) if both else (tip,)
        build = Build()
        for item in (plate, body, lm.UserForce("user", places, function, tangent, potential)):
            item.contribute(build)
        (self.block,) = build.loads
        rng = np.random.default_rng(1)
        self.q = build.initial.reshape(-1) + rng.uniform(-0.2, 0.2, 3 * build.n_vectors)
        self.v = rng.uniform(-1.0, 1.0, self.q.size)

    def f(self, q, v):
        buffer, total = np.full(len(self.block.f_coords), np.nan), np.zeros(self.q.size)
        self.block.force(TIME, q, v, buffer)
        np.add.at(total, self.block.f_coords, buffer)
        return total

    def tangent(self, alpha_q, alpha_v):
        f, k = np.full(len(self.block.f_coords), np.nan), np.full(len(self.block.k_rows), np.nan)
        self.block.force_tangent(TIME, self.q, self.v, alpha_q, alpha_v, self.q, f, k)
        K = np.zeros((self.q.size,) * 2)
        np.add.at(K, (self.block.k_rows, self.block.k_cols), k)
        if self.block.symmetry == "symmetric":
            assert np.all(self.block.k_rows <= self.block.k_cols)
            K += np.triu(K, 1).T
        return K


@pytest.mark.parametrize("given", [True, False])
@pytest.mark.parametrize("kind", ["coupled", "potential"])
def test_tangent_is_the_derivative_of_the_force(kind, given):
    function, tangent = (spring_between, spring_tangent) if kind == "coupled" else (well, well_tangent)
    case = Case(function, tangent if given else None, potential=kind == "potential", both=kind == "coupled")
    q, v, alpha_v = case.q, case.v, 1.9 if kind == "coupled" else 0.0
    K_q = np.stack([derivative(lambda s, d=d: case.f(q + s * d, v), 1e-3) for d in np.eye(q.size)], axis=1)
    K_v = np.stack([derivative(lambda s, d=d: case.f(q, v + s * d), 1e-3) for d in np.eye(q.size)], axis=1)
    K = case.tangent(0.7, alpha_v)
    # differences of second order at the cube root of rounding: 1e-10 of the largest entry
    np.testing.assert_allclose(K, 0.7 * K_q + alpha_v * K_v, atol=1e-8 * np.abs(K).max())
    assert case.block.depends_on_velocity == (kind == "coupled")


def test_resultant_of_internal_forces_vanishes_and_power_is_force_times_velocity():
    case = Case(spring_between)
    F = case.block.forces(TIME, case.q, case.v)
    r, v = case.block._motion(case.q, case.v)
    np.testing.assert_allclose(F, spring_between(TIME, r, v))
    assert -case.f(case.q, case.v) @ case.v == pytest.approx(float((F * v).sum()), rel=1e-12)


def wrong(entry, part):
    def tangent(t, r, v):
        parts = spring_tangent(t, r, v)
        parts[part][entry] *= 1.01
        return parts

    return tangent


@pytest.mark.parametrize(
    ("part", "entry", "said"),
    [
        (
            0,
            (4, 2),
            r"dF/dr at t = 0\.7 s, entry \[4, 2\] \(force along y of body\.tip, by z of plate\.spot\), is .*differences give",
        ),
        (1, (0, 3), r"dF/dv at t = 0\.7 s, entry \[0, 3\] \(force along x of plate\.spot, by x of body\.tip\), is"),
    ],
)
def test_a_wrong_tangent_is_refused_with_the_entry_that_differs_most(part, entry, said):
    with pytest.raises(DeclarationError, match="UserForce 'user': " + said):
        Case(spring_between, wrong(entry, part)).tangent(1.0, 1.0)


@pytest.mark.parametrize(
    ("function", "tangent", "potential", "said"),
    [
        (lambda t, r, v: r[0], None, False, r"'function' gave an array of shape \(3,\); accepted are forces of shape \(1, 3\)"),
        (lambda t, r, v: 1j * r, None, False, r"'function' gave array.*; accepted are real numbers"),
        (lambda t, r, v: "much", None, False, "'function' gave 'much'; accepted are real numbers"),
        (lambda t, r, v: None, None, False, "'function' gave None; accepted are real numbers"),
        (well, lambda t, r, v: None, False, "'tangent' gave None; accepted is the pair dF/dr and dF/dv"),
        (
            well,
            lambda t, r, v: (np.eye(2), np.eye(2)),
            False,
            r"shapes \(2, 2\) and \(2, 2\); accepted are dF/dr and dF/dv, each",
        ),
        (
            lambda t, r, v: np.cross([0, 0, 1.0], r),
            None,
            True,
            r"its transpose is .*accepted with potential=True is a symmetric one",
        ),
    ],
)
def test_what_the_functions_give_is_checked(function, tangent, potential, said):
    with pytest.raises(DeclarationError, match="UserForce 'user': .*" + said):
        Case(function, tangent, potential=potential, both=False).tangent(1.0, 1.0)


@pytest.mark.parametrize("which", ["function", "tangent"])
def test_an_error_in_the_functions_is_told_with_the_force_and_the_time(which):
    def fails(t, r, v):
        raise LookupError("no law")

    functions = {"function": lambda t, r, v: -r, which: fails}
    system = lm.System()
    ball = system.add(lm.RigidBody("ball", mass=1.0, inertia=(1, 1, 1)))
    system.add(lm.UserForce("user", on=(ball.origin,), **functions))
    said = f"UserForce 'user' at t = 0 s: '{which}' raised LookupError: no law"
    with pytest.raises(ModelError, match=said) as caught:
        lm.simulate(system, t_end=0.01, integrator=lm.GeneralizedAlpha(dt=1e-3))
    assert isinstance(caught.value.__cause__, LookupError)


def test_load_steps_until_a_function_fails_are_kept():
    def fails(t, r, v):
        if r[0, 2] > 0.03:
            raise LookupError("too far")
        return np.zeros_like(r)

    system = lm.System()
    plate = system.add(lm.Plate("plate", (1.0, 0.5), (1, 1), SHEET))
    system.add(lm.Clamp("root", plate.edge("x-")))
    tip = plate.marker("tip", 1.0, 0.25)
    system.add(lm.UserForce("spring", [tip], fails))
    system.add(lm.PointForce("load", tip, (0, 0, 1000.0)))
    with pytest.raises(FunctionError, match="'function' raised LookupError: too far") as caught:
        lm.equilibrium(system, steps=10)
    kept = caught.value.result
    assert 0.0 < kept.at[-1] < 1.0
    assert kept.outcome.cause is Cause.FUNCTION_FAILED
    assert kept.samples("tip.position")[-1, 2] < 0.03


@pytest.mark.parametrize("compute", [lambda system: lm.simulate(system, 0.1, lm.GeneralizedAlpha(1e-2)), lm.equilibrium])
def test_forces_that_are_no_numbers_where_a_computation_begins_are_told(compute):
    system = lm.System()
    plate = system.add(lm.Plate("plate", (1.0, 0.5), (1, 1), SHEET))
    system.add(lm.Clamp("root", plate.edge("x-")))
    system.add(lm.UserForce("wind", [plate.marker("tip", 1.0, 0.25)], lambda t, r, v: np.full_like(r, np.nan)))
    said = r"UserForce 'wind': 'function' gave \[\[nan, nan, nan\]\] at t = 0 s, .*accepted are finite numbers \[N\]"
    with pytest.raises(DeclarationError, match=said):
        compute(system)


def test_impossible_declarations_are_named():
    with pytest.raises(DeclarationError, match="UserForce 'user': on"):
        lm.UserForce("user", (), well)
    with pytest.raises(DeclarationError, match="UserForce 'user': function"):
        lm.UserForce("user", (lm.Ground().origin,), 3.0)
    with pytest.raises(DeclarationError, match=r"UserForce 'user': ground\.origin cannot move; accepted is a marker of a body"):
        lm.UserForce("user", (lm.Ground().origin,), well).contribute(Build())


@pytest.mark.parametrize("at_rest", [lambda t, r, v: np.full((1, 3), 1e6), lambda t, r, v: -np.linalg.norm(v) * v])
def test_a_right_tangent_is_accepted_where_derivatives_vanish(at_rest):
    constant = at_rest(0.0, np.zeros((1, 3)), np.zeros((1, 3))).any()

    def tangent(t, r, v):
        none = np.zeros((3, 3))
        speed = np.linalg.norm(v)
        return none, none if constant or not speed else -(speed * np.eye(3) + np.outer(v, v) / speed)

    case = Case(at_rest, tangent, both=False)
    case.v[:] = 0.0
    case.tangent(1.0, 1.0)


def falling(tangent=None) -> lm.System:
    system = lm.System()
    body = system.add(lm.RigidBody("body", mass=2.0, inertia=(0.1, 0.1, 0.1)))
    system.add(lm.Gravity("gravity"))
    centre = body.marker("centre", 0.0, 0.0, 0.0)
    system.add(lm.UserForce("drag", (centre,), lambda t, r, v: -0.5 * np.linalg.norm(v) * v, tangent))
    return system


def test_fall_through_air_against_the_closed_form(tmp_path: Path):
    result = lm.simulate(falling(), 2.0, lm.GeneralizedAlpha(dt=5e-3))
    c, g = 0.5 / 2.0, 9.81
    fallen = np.log(np.cosh(np.sqrt(c * g) * result.at)) / c
    # second order: the acceleration varies over 0.6 s, (5e-3 / 0.6)^2 / 12 of the way is 6e-6
    np.testing.assert_allclose(-result["centre.position"].values[:, 2], fallen, atol=2e-5 * fallen.max())
    assert result["drag.force"].values[-1, 2] == pytest.approx(2.0 * g * np.tanh(np.sqrt(c * g) * 2.0) ** 2, rel=1e-4)
    assert abs(result["energy.balance"].values[-1]) < 1e-3 * abs(result["work.loads"].values).max()

    result.save(tmp_path / "fall.h5")
    stored = lm.read_result(tmp_path / "fall.h5")
    np.testing.assert_array_equal(stored["drag.force"].values, result["drag.force"].values)
    assert stored.model_text == ""
    assert "UserForce 'drag': function: <lambda> is a Python function" in stored.model_missing
    with pytest.raises(ResultFileError, match=r"holds no model .*UserForce 'drag'"):
        assert stored.model


def test_a_tangent_is_checked_once_in_each_run():
    calls = []

    def tangent(t, r, v):
        calls.append(t)
        speed = max(np.linalg.norm(v), 1e-12)
        return np.zeros((3, 3)), -0.5 * (speed * np.eye(3) + np.outer(v, v) / speed)

    model = falling(tangent).compile()
    counts = []
    for _ in range(2):
        calls.clear()
        tangents = lm.simulate(model, 0.02, lm.GeneralizedAlpha(dt=5e-3)).statistics.tangents
        counts.append((len(calls), tangents))
    assert counts[0] == counts[1]


@pytest.mark.parametrize("potential", [True, False])
def test_statics_scales_it_with_the_load_factor(potential):
    """A strip is lifted against a spring that is part of the same load."""
    system = lm.System()
    strip = system.add(lm.Plate("strip", (1.0, 0.1), (2, 1), SHEET))
    tip = strip.marker("tip", 1.0, 0.05)
    system.add(lm.Clamp("root", strip.edge("x-")))
    lift = np.array([0.0, 0.0, 30.0])
    system.add(lm.UserForce("lift", (tip,), lambda t, r, v: lift - [0.0, 0.0, 100.0] * r, potential=potential))
    result = lm.equilibrium(system, steps=2)
    rise = result.history("tip.position").values[:, 2]
    np.testing.assert_allclose(result.history("lift.force").values[:, 2], [0.0, 15.0 - 50.0 * rise[1], 30.0 - 100.0 * rise[2]])
    E_I = 70e9 * 0.1 * 0.01**3 / 12.0
    # beam and plate differ by the anticlastic bending, at most by 1 - nu^2
    assert rise[2] == pytest.approx(30.0 / (3.0 * E_I + 100.0), rel=0.05)


def test_model_files_neither_hold_nor_offer_it():
    text = "lamella: 1\nsystem:\n  a: {type: rigid_body, mass: 1, inertia: [1, 1, 1]}\n  f: {type: user_force, on: [a.origin]}\n"
    with pytest.raises(
        ModelFileError, match=r"system\.f\.type: user_force holds Python functions, and nothing in a model file is executed"
    ):
        loads(text)
    with pytest.raises(
        DeclarationError, match="UserForce 'drag': function: <lambda> is a Python function, which a model file cannot"
    ):
        dumps(falling())
    assert "user_force" not in json.dumps(json_schema())
    assert "point_force" in json.dumps(json_schema())


def test_ground_markers_in_a_list_are_written_with_their_ground():
    system, ground = lm.System(), lm.Ground()
    body = system.add(lm.RigidBody("body", mass=2.0, inertia=(0.1, 0.1, 0.1)))
    pegs = (ground.marker("left", -1.0, 0.0, 1.0), body.marker("hook", 0.0, 0.0, 0.1), ground.marker("right", 1.0, 0.0, 1.0))
    system.add(lm.Cable("rope", pegs))
    read = {item.name: item for item in loads(dumps(system)).system.declarations}
    assert read["rope"] == system.declarations[-1]
