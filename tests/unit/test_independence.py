"""Redundant constraints are found and named, left out when asked for, and told from contradictions."""

from __future__ import annotations

import numpy as np
import pytest

import lamella as lm
from lamella.assembly.equations import Equations
from lamella.assembly.independence import described, independent_rows
from lamella.errors import ConstraintError

TIGHT = lm.Newton(tolerance=1e-11)
SECTION = lm.Laminate(lm.Isotropic(E=70e9, nu=0.3, rho=2700.0), thickness=0.002)


def link(name, start, end, mass):
    """A slender body between two points of the x-z plane, its x axis along them."""
    start, end = np.array((start[0], 0.0, start[1])), np.array((end[0], 0.0, end[1]))
    length, direction = np.linalg.norm(end - start), end - start
    angle = -np.arctan2(direction[2], direction[0])  # about +y
    J = mass * length**2 / 12
    body = lm.RigidBody(name, mass=mass, inertia=(1e-3, J, J), position=tuple(0.5 * (start + end)), rotation=(0, angle, 0))
    return body, body.marker(f"{name} start", -0.5 * length, 0, 0), body.marker(f"{name} end", 0.5 * length, 0, 0)


def four_bar(joints, redundant="raise"):
    """Crank, coupler and rocker on the ground, with the four joints given by name, all axes along y."""
    system, ground = lm.System(redundant=redundant), lm.Ground()
    points = ((0.0, 0.0), (0.1, 0.3), (1.0, 0.6), (0.9, 0.0))
    bodies = [link(name, points[k], points[k + 1], 1.0 + k) for k, name in enumerate(("crank", "coupler", "rocker"))]
    system.add(ground)
    for body, _, _ in bodies:
        system.add(body)
    ends = [ground.marker("left", 0, 0, 0), *(end for _, _, end in bodies)]
    starts = [*(start for _, start, _ in bodies), ground.marker("right", 0.9, 0, 0)]
    for name, kind, a, b in zip("ABCD", joints, ends, starts, strict=True):
        options = {} if kind is lm.SphericalJoint else {"axis": (0, 1, 0)}
        first, second = (b, a) if name == "D" else (a, b)
        system.add(kind(name, first, second, **options))
    system.add(lm.Gravity("weight"))
    return system


def test_revolutes_of_a_planar_four_bar_hold_three_times_too_much():
    with pytest.raises(ConstraintError, match="redundant in the initial position") as caught:
        Equations(four_bar([lm.RevoluteJoint] * 4).compile())
    message = str(caught.value)
    assert message.count("follows from") == 3
    assert "the system drop what is redundant" in message
    assert any(f"{name}: right angle" in message for name in "ABCD")


def test_four_bar_of_revolute_cylindrical_and_spherical_joints_has_one_degree_of_freedom():
    """Textbook: 18 - 5 - 5 - 3 - 4 = 1; ABCD with R, R, S, C."""
    joints = [lm.RevoluteJoint, lm.RevoluteJoint, lm.SphericalJoint, lm.CylindricalJoint]
    equations = Equations(four_bar(joints).compile())
    assert equations.mobility == 1
    assert equations.notes == []


def test_dropped_rows_leave_the_motion_of_the_mechanism():
    joints = [lm.RevoluteJoint, lm.RevoluteJoint, lm.SphericalJoint, lm.CylindricalJoint]
    options = lm.GeneralizedAlpha(dt=2e-3, newton=TIGHT)
    system = four_bar([lm.RevoluteJoint] * 4, "drop")
    equations = Equations(system.compile())
    assert equations.mobility == 1
    assert equations.notes[0].startswith("left out as redundant: ")
    dropped, clean = (lm.simulate(s, 0.4, options) for s in (system, four_bar(joints)))
    for name in ("crank.position", "coupler.position", "rocker.position", "rocker.angular_velocity"):
        np.testing.assert_allclose(dropped[name].values, clean[name].values, atol=1e-8)  # what Newton leaves, over 200 steps
        assert np.abs(clean[name].values[-1] - clean[name].values[0]).max() > 0.02
    np.testing.assert_allclose(dropped["coupler.position"].values[:, 1], 0.0, atol=1e-10)
    model, state = dropped.model, dropped.final
    phi = np.concatenate([_phi(block, state) for block in model.constraints])
    assert np.abs(phi).max() < 1e-9  # the rows left out hold as well


def _phi(block, state):
    out = np.empty(block.n_lam)
    block.phi(state.t, state.q, out)
    return out


def pendulum(*more):
    system, ground = lm.System(), lm.Ground()
    body, start, end = link("arm", (0.0, 0.0), (1.0, 0.0), 2.0)
    hook = ground.marker("hook", 0, 0, 0)
    for item in (
        ground,
        body,
        lm.RevoluteJoint("pin", hook, start, axis=(0, 1, 0)),
        *(make(ground, hook, start, end) for make in more),
    ):
        system.add(item)
    return system


def test_a_joint_given_twice_is_redundant_and_both_are_named():
    """Between two moving bodies the angles of both take multipliers; towards the ground all is linear (``test_relations.py``)."""
    system, ground = lm.System(), lm.Ground()
    first, a, b = link("first", (0.0, 0.0), (1.0, 0.2), 2.0)
    second, c, _ = link("second", (1.0, 0.2), (1.5, 0.9), 1.0)
    for item in (ground, first, second):
        system.add(item)
    system.add(lm.RevoluteJoint("base", ground.marker("hook", 0, 0, 0), a, axis=(0, 1, 0)))
    system.add(lm.RevoluteJoint("elbow", b, c, axis=(0, 1, 0)))
    system.add(lm.RevoluteJoint("twin", b, c, axis=(0, 1, 0)))
    with pytest.raises(ConstraintError, match=r"twin: right angle .*follows from elbow: right angle"):
        Equations(system.compile())


def test_hinge_of_two_rigid_plates_shares_a_director_without_a_word():
    system = lm.System()
    a = system.add(lm.Plate("a", (1.0, 0.5), (2, 2), SECTION, strain="rigid"))
    b = system.add(lm.Plate("b", (0.8, 0.5), (1, 2), SECTION, strain="rigid", position=(1.0, 0.0, 0.0)))
    system.add(lm.EdgeHinge("hinge", a.edge("x+"), b.edge("x-")))
    equations = Equations(system.compile())
    assert equations.notes == []
    assert equations.n_lam == 5  # six rows of two plates, less the common length of r_y
    assert equations.mobility == 7


def test_points_held_at_two_places_contradict_each_other():
    system = pendulum(lambda ground, hook, start, end: lm.SphericalJoint("shifted", ground.marker("off", 0, 0, 1e-7), start))
    with pytest.raises(ConstraintError, match=r"shifted contradicts .*pin: both hold the same coordinates at different values"):
        Equations(system.compile())


def test_distance_that_cannot_be_reached_is_a_contradiction():
    """A pendulum of 1 m on a rod of 5 m to a peg 2 m away: no position fits."""
    system = pendulum(lambda ground, hook, start, end: lm.DistanceJoint("rod", ground.marker("peg", 1, 0, 2), end, length=5.0))
    with pytest.raises(ConstraintError, match="no position near the initial one satisfies the constraints"):
        lm.simulate(system, 0.1, lm.GeneralizedAlpha(dt=1e-2))


def test_rows_are_chosen_by_rank_with_those_of_bodies_first():
    rng = np.random.default_rng(2)
    rows = rng.uniform(-1, 1, (4, 6))
    jacobian = np.vstack([rows[0], rows[1], 2.0 * rows[0] - rows[1], rows[2], rows[2], rows[3], 1e-3 * rows[3] + 1e-14])
    of_bodies = np.array([False, False, False, True, True, False, True])
    kept, redundant = independent_rows(jacobian, of_bodies)
    assert kept.tolist() == [0, 1, 3, 6]  # of the equal rows of bodies one; the last row of a body before the joint's
    assert [item.row for item in redundant] == [2, 5]
    assert set(redundant[0].repeats) == {0, 1}
    assert redundant[1].repeats == ()
    labels = [f"row {k}" for k in range(7)]
    assert described(redundant[1:], labels) == "row 5 (follows from the bodies alone)"
    assert described([redundant[0]] * 6, labels).endswith(" and 2 more")


def test_a_row_that_vanishes_is_redundant():
    """A point in a plane whose normal turns about that point holds nothing there: a row of zeros."""
    jacobian = np.array([[1.0, 2.0, 0.0], [0.0, 0.0, 0.0]])
    kept, redundant = independent_rows(jacobian, np.zeros(2, dtype=bool))
    assert kept.tolist() == [0]
    assert redundant[0].row == 1
