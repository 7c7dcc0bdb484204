"""Differences of residuals by the parts that differ, against those of whole residuals."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from functools import partial
from itertools import product
from types import SimpleNamespace

import numpy as np
import pytest
from shell_patch import SURFACES, gathered_force, patch

import lamella as lm
from lamella.assembly.equations import Equations
from lamella.assembly.point import Weights
from lamella.differentiation.difference import PartDifference, WholeDifference
from lamella.differentiation.exact_matrix import ExactMatrix
from lamella.differentiation.neighbours import neighbours_of
from lamella.differentiation.reactions import Reactions
from lamella.element.plate48.beside import ReferenceChange
from lamella.element.plate48.block import SHELL
from lamella.element.plate48.exact import ShellBlock
from lamella.element.plate48.matrix_free import ShellTangent
from lamella.element.plate48.section import Section
from lamella.element.plate48.shape import PLATE48
from lamella.roles import ForceChange
from lamella.state import State

BLOCKS = {"elastic": SHELL.strain_models["exact"], "viscous": SHELL.viscous, "both": SHELL.damped}
OPTIONS = {"unit": {}, "cubed": {"curvature": "cubed_normal"}, "fewer points": {"membrane_gauss": 3}}


def plate(E=7e10, rho=2700.0, thickness=4e-3, force=-10.0, damping=0.0, length=0.6, width=0.3, shaken=0.0, alpha=None):
    """A plate that is pushed at its tip, shaken at a corner, to and fro by so much [m], and warmed by the sun if it expands."""
    heat = {} if alpha is None else {"alpha": alpha, "k": 5.0, "c": 900.0}
    layup = lm.Laminate(lm.Isotropic(E, 0.3, rho, **heat), thickness=thickness)
    how = {"damping": damping} if damping else {}
    system = lm.System()
    panel = system.add(lm.Plate("panel", (length, width), (2, 2), layup, **how))
    tip = panel.marker("tip", length, 0.1)
    system.add(lm.Clamp("root", panel.edge("x-")))
    system.add(lm.PointForce("push", tip, (0.0, 0.0, force)))
    if shaken:
        system.add(lm.PrescribedMotion("shaker", panel.marker("corner", length, width), "z", lm.Harmonic(shaken, 20.0)))
    if heat:
        system.add(lm.TemperatureField("heat", panel))
        system.add(lm.SolarFlux("sun", panel, direction=(0.6, 0.0, -0.8), absorptivity=0.8, constant=1361.0))
    return system


ROUNDING = 1e-8
"""Of differences of whole residuals over 4e-4 of the parameter, beside the residual: their parts are larger than their sum."""
AT = {"E": 7e10, "rho": 2700.0, "thickness": 4e-3, "force": -10.0, "length": 0.6, "width": 0.3}


def neighbours(name, by_tables=False, **more):
    made = partial(plate, **more)
    base = Equations(made().compile())
    value = {**AT, **more}[name]
    return base, neighbours_of(name, base, value, abs(value), lambda x: made(**{name: x}), by_tables)


def moved(base):
    n = np.arange(base.n_u)
    point = base.start()
    point.u += 1e-3 * np.sin(n) * base.magnitude
    point.ud, point.udd = np.cos(n) * base.magnitude, 10.0 * np.sin(2.0 * n) * base.magnitude
    return point, np.sin(3.0 * n) * base.magnitude, np.cos(5.0 * n) * base.magnitude


MORE = {"plain": {}, "damped": {"damping": 2e-3}, "shaken": {"damping": 2e-3, "shaken": 1e-3}, "warm": {"alpha": 2.3e-5}}


@pytest.mark.parametrize(("name", "how", "share"), [("rho", "plain", 1 / 2700.0), ("thickness", "damped", 1 / 4e-3)])
def test_masses_that_differ_by_a_share_take_no_product_of_their_own(name, how, share):
    """Of a plate without rotary inertia; a length changes the masses of positions and slopes differently."""
    base, beside = neighbours(name, **MORE[how])
    point, dud, dudd = moved(base)
    r, _, accelerations = beside.parts.apart(point, dud, dudd)
    np.testing.assert_allclose(accelerations, dudd + share * point.udd, rtol=1e-7)
    expected = beside.residual(point, dud, dudd)[0]
    np.testing.assert_allclose(r + base.inertia_force(accelerations), expected, atol=1e-12 * np.abs(expected).max())
    _, of_length = neighbours("length", **MORE[how])
    np.testing.assert_array_equal(of_length.parts.apart(point, dud, dudd)[2], dudd)


HELD = ("width", "warm")
"""The clamp stands where the width says, and the tangent between shape and temperature does not tell what follows from that."""


@pytest.mark.parametrize(("name", "how"), [*(each for each in product(AT, MORE) if each != HELD), ("alpha", "warm")])
def test_parts_are_as_good_as_the_whole(name, how):
    base, beside = neighbours(name, **MORE[how])
    assert isinstance(beside.residual, PartDifference)
    whole = WholeDifference(beside.sides)
    point, dud, dudd = moved(base)
    scale, still = 1.0 / {**AT, **MORE[how]}[name], base.start(at_rest=True)
    still.u, still.factor = point.u, 0.7
    point.t = 0.01
    for at, rates in ((still, (None, None)), (point, (None, None)), (point, (scale * dud, scale * dudd))):
        expected, found = (each(at, *rates)[0] for each in (whole, beside.residual))
        largest = np.abs(base.residual(at)[0]).max() * abs(scale)
        np.testing.assert_allclose(found, expected, atol=ROUNDING * largest)


@pytest.mark.parametrize(("name", "how"), [*(each for each in product(AT, MORE) if each != HELD), ("alpha", "warm")])
def test_parts_tell_the_derivative_of_reactions(name, how):
    """Of unknowns as they are, and of those that follow the parameter where coordinates may."""
    base, beside = neighbours(name, **MORE[how])
    point, dud, dudd = moved(base)
    scale, still = 1.0 / {**AT, **MORE[how]}[name], base.start(at_rest=True)
    still.u, still.factor = point.u, 0.7
    point.t = 0.01
    for at in (still, point):
        expected = beside.difference(lambda side, at=at: side.equations.state(at).reaction)
        largest = np.abs(base.state(at).reaction).max() * abs(scale)
        np.testing.assert_allclose(beside.parts.reaction(at, base.state(at)), expected, atol=ROUNDING * largest)
    if beside.parts.follows:
        du = 0.1 * np.cos(2.0 * np.arange(base.n_u)) * base.magnitude
        change = State(point.t, *(base.expand(x) for x in (du, dud, dudd)), np.zeros(0), np.zeros(0))
        tangents = Reactions(base)
        tangents.look(point, base.state(point))
        found, unmoved = (beside.parts.reaction(point, base.state(point), *along) for along in ([change], []))
        expected = unmoved + tangents.change(replace(beside, residual=WholeDifference(beside.sides)), np.zeros(0), change)
        np.testing.assert_allclose(found, expected, atol=1e-12 * np.abs(expected).max())


def test_supports_that_follow_the_parameter_ask_for_whole_residuals():
    assert isinstance(neighbours("shaken", shaken=1e-3)[1].residual, WholeDifference)
    assert isinstance(neighbours(HELD[0], **MORE[HELD[1]])[1].residual, WholeDifference)


@pytest.mark.parametrize("how", ["plain", "damped", "shaken"])
@pytest.mark.parametrize("name", ["length", "width"])
def test_tables_of_two_models_tell_of_places_what_those_of_four_do(name, how):
    """Tables are products of few lengths, and two models that lie near leave 1e-8 of their derivatives and less."""
    base, beside = neighbours(name, **MORE[how])
    near = neighbours(name, by_tables=True, **MORE[how])[1]
    assert (len(beside.sides), len(near.sides)) == (4, 2)
    for at, rates in ((base.start(at_rest=True), (None, None)), (point := moved(base)[0], (point.ud, point.udd))):
        expected, found = (each.residual(at, *rates)[0] for each in (beside, near))
        np.testing.assert_allclose(found, expected, atol=1e-8 * np.abs(expected).max())
    heated = neighbours(name, by_tables=True, **MORE["warm"])[1]
    assert len(heated.sides) == 4


def test_forces_that_a_parameter_leaves_alone_are_not_evaluated(monkeypatch):
    base, beside = neighbours("force")
    point, dud, dudd = moved(base)
    expected = WholeDifference(beside.sides)(point, dud, dudd)[0]

    def refuse(*_):
        raise AssertionError("evaluated")

    monkeypatch.setattr(ShellBlock, "force", refuse)
    np.testing.assert_allclose(beside.residual(point, dud, dudd)[0], expected, atol=1e-6 * np.abs(expected).max())


@pytest.mark.parametrize(
    ("name", "forces", "changes"), [("force", 0, 0), ("rho", 0, 0), ("E", 1, 0), ("thickness", 1, 0), ("length", 0, 1)]
)
def test_one_evaluation_serves_all_sides(name, forces, changes, monkeypatch):
    """Forces are linear in a stiffness; of a length it is the derivatives of tables that give that of the force."""
    base, beside = neighbours(name)
    evaluated = Counter()
    for owner in (ShellBlock, ReferenceChange):
        force = owner.force

        def counted(*arguments, owner=owner, force=force):
            evaluated[owner] += 1
            force(*arguments)

        monkeypatch.setattr(owner, "force", counted)
    beside.residual(*moved(base))
    assert (evaluated[ShellBlock], evaluated[ReferenceChange]) == (forces, changes)


def test_blocks_of_other_meshes_or_times_have_no_change_of_their_own():
    block, longer = (plate(length=length).compile().forces[0] for length in (0.6, 0.7))
    assert block.force_change([block, block], [1.0, -1.0]) is not None
    assert block.force_change([longer, longer], [1.0, -1.0]) is not None
    slow, fast = (plate(damping=damping).compile().forces[0].symmetric_form for damping in (1e-3, 2e-3))
    assert slow.force_change([slow], [1.0]) is not None
    assert slow.force_change([fast], [1.0]) is None
    assert block.force_change([slow], [1.0]) is None
    warm, warmer = (plate(alpha=alpha).compile().forces[0] for alpha in (2e-5, 3e-5))
    heated = warm.force_change([warm, warmer], [-1.0, 1.0])
    assert isinstance(heated, ReferenceChange)
    assert not isinstance(heated, ForceChange)  # as temperatures do not follow
    assert block.force_change([warm], [1.0]) is None
    assert warm.force_change([block], [1.0]) is None
    other = ShellBlock("plate", *patch(PLATE48, (0.0, 0.3, 0.6), (0.0, 0.1, 0.2, 0.3)).tables, np.eye(6))
    assert block.force_change([other], [1.0]) is None


@pytest.mark.parametrize("surface", SURFACES)
@pytest.mark.parametrize("option", OPTIONS)
@pytest.mark.parametrize("kind", BLOCKS)
def test_change_of_the_reference_is_that_of_the_force(kind, option, surface):
    """Against differences of sixth order of the force itself, of elements whose sizes, reference and stiffness change with p."""
    rng = np.random.default_rng(8)
    A, B = rng.standard_normal((2, 6, 6))
    C, dC = A @ A.T + np.eye(6), 0.1 * (B + B.T)

    def at(p):
        mesh = patch(
            PLATE48, np.array([0.0, 0.5, 0.9]) * (1.0 + p), np.array([0.0, 0.4, 0.8]) * (1.0 - 0.4 * p), SURFACES[surface]
        )
        return mesh, BLOCKS[kind](
            "plate", *mesh.tables, Section(C + p * dC, **OPTIONS[option]), *(() if kind == "elastic" else (0.3,))
        )

    (mesh, block), h = at(0.0), 1e-3
    q = mesh.rest + 0.05 * rng.standard_normal(mesh.rest.shape)
    v = rng.standard_normal(len(q))
    places, weights = (-2, -1, 1, 2), np.array([1 / 12, -8 / 12, 8 / 12, -1 / 12]) / h
    found = block.force_change([at(place * h)[1] for place in places], weights)
    assert isinstance(found, ForceChange)
    dq, dv = 0.1 * rng.standard_normal((2, len(q)))
    sixth = {1: 3 / 4, 2: -3 / 20, 3: 1 / 60}
    for follows in (0.0, 1.0):  # coordinates and velocities stay, or follow p

        def force(p, follows=follows):
            return gathered_force(at(p)[1], q + follows * p * dq, v + follows * p * dv)

        expected = sum(w / h * (force(k * h) - force(-k * h)) for k, w in sixth.items())
        change = along(found, dq, dv) if follows else found
        np.testing.assert_allclose(gathered_force(change, q, v), expected, atol=1e-8 * np.abs(expected).max())

        def energy(p, follows=follows):
            return at(p)[1].energy(0.0, q + follows * p * dq)

        expected = sum(w / h * (energy(k * h) - energy(-k * h)) for k, w in sixth.items())
        whole, of_change = found.energy(0.0, q, follows * dq)
        assert whole == pytest.approx(block.energy(0.0, q), rel=1e-13)
        assert of_change == pytest.approx(expected, rel=1e-8)
        assert (expected == 0.0) == (kind == "viscous")


def along(change, dq, dv):
    """The force that a change writes where coordinates and velocities follow the parameter."""

    def force(t, q, v, f):
        change.along(t, q, v, dq, dv, f)

    return SimpleNamespace(force=force, f_coords=change.f_coords, f_scale=change.f_scale)


@pytest.mark.parametrize(
    ("name", "how", "follows"),
    [
        ("length", "plain", True),
        ("length", "damped", True),
        ("length", "warm", False),
        ("length", "shaken", True),
        ("width", "damped", True),
        ("thickness", "plain", True),
        ("E", "damped", True),
        ("thickness", "warm", False),
        ("force", "plain", False),
    ],
)
def test_unknowns_follow_the_parameter(name, how, follows, monkeypatch):
    """As the product of the exact tangent tells, where all forces that depend on them may."""
    base, beside = neighbours(name, **MORE[how])
    assert (beside.parts is not None and beside.parts.follows) == follows
    if beside.parts is None or not follows:
        return
    point, dud, dudd = moved(base)
    du, weights = 0.1 * np.cos(2.0 * np.arange(base.n_u)) * base.magnitude, Weights(1.0, 30.0, 900.0, 30.0)
    product = ExactMatrix(base).product(point, weights)(du)
    expected = beside.residual(point, dud, dudd)[0] + product
    found = beside.parts.along(point, dud, dudd, du, weights)[0]
    np.testing.assert_allclose(found, expected, atol=1e-12 * max(np.abs(expected).max(), np.abs(product).max()))
    matrix, looks = ExactMatrix(base), []
    monkeypatch.setattr(ShellTangent, "look", lambda *_: looks.append(1))
    elsewhere = base.start()
    for at in (elsewhere, point):  # what was seen of another point is not taken for this one
        beside.parts.along(at, dud, dudd, du, weights, matrix.ahead(at, weights))
    np.testing.assert_allclose(matrix.product(point, weights)(du), product, atol=1e-12 * np.abs(product).max())
    assert not looks
    matrix.product(point, weights)
    matrix.ahead(elsewhere, weights)
    matrix.product(elsewhere, weights)
    assert len(looks) == 2
