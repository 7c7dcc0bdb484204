"""Linear rows of joints that repeat others are found and named like those with multipliers; edges that meet may overlap."""

from __future__ import annotations

import numpy as np
import pytest

import lamella as lm
from lamella.assembly.equations import Equations
from lamella.assembly.independence import independent_rows
from lamella.assembly.relations import BODY, Rows, relations, repeated_rows
from lamella.errors import ConstraintError

SECTION = lm.Laminate(lm.Isotropic(E=2e9, nu=0.3, rho=1200.0), thickness=0.02)
STEPS = lm.GeneralizedAlpha(dt=2e-3, newton=lm.Newton(tolerance=1e-11))


def system_of(*items, redundant="raise"):
    system = lm.System(redundant=redundant)
    for item in items:
        system.add(item)
    return system


def equations_of(*items, redundant="raise"):
    return Equations(system_of(*items, redundant=redundant).compile())


def balls(count, redundant="raise"):
    """A rod of 1 m that swings about ball joints to the ground, all at its left end."""
    ground, arm = lm.Ground(), lm.RigidBody("arm", mass=1.0, inertia=(0.01, 0.1, 0.1), position=(0.5, 0, 0))
    end = arm.marker("end", -0.5, 0, 0)
    joints = [lm.SphericalJoint(name, ground.origin, end) for name in ("first", "second")[:count]]
    return system_of(ground, arm, *joints, lm.Gravity("weight"), redundant=redundant)


def test_two_ball_joints_at_one_point_are_named():
    with pytest.raises(ConstraintError, match="redundant in the initial position") as caught:
        Equations(balls(2).compile())
    for axis in "xyz":
        words = f"{axis} of the distance of the points of"
        assert f"{words} second (follows from {words} first)" in str(caught.value)
    assert "the system drop what is redundant" in str(caught.value)
    assert "locked" not in str(caught.value)


def test_the_second_ball_joint_is_left_out_and_the_motion_is_that_of_the_first():
    alone, both = (lm.simulate(balls(count, "drop"), 0.4, STEPS) for count in (1, 2))
    np.testing.assert_allclose(both["arm.position"].values, alone["arm.position"].values, atol=1e-12)
    np.testing.assert_allclose(both["first.force"].values, alone["first.force"].values, atol=1e-9)
    assert np.abs(both["second.force"].values).max() == 0.0
    assert alone.start.notes == ()
    assert both.start.notes[0].startswith("left out as redundant: x of the distance of the points of second (follows from")


def door(high, redundant="raise"):
    """A door on a hinge to the ground with the axis z, and what ``high`` joins 1 m above."""
    ground, leaf = lm.Ground(), lm.RigidBody("leaf", mass=1.0, inertia=(0.1, 0.1, 0.1), position=(0.5, 0, 0))
    low = lm.RevoluteJoint("low", ground.origin, leaf.marker("low", -0.5, 0, 0), axis=(0, 0, 1))
    return system_of(ground, leaf, low, high(ground.marker("top", 0, 0, 1), leaf.marker("high", -0.5, 0, 1)), redundant=redundant)


DOORS = {
    "revolute": (lambda a, b: lm.RevoluteJoint("high", a, b, axis=(0, 0, 1)), 5),
    "cylindrical": (lambda a, b: lm.CylindricalJoint("high", a, b, axis=(0, 0, 1)), 4),
    "spherical": (lambda a, b: lm.SphericalJoint("high", a, b), 3),
    "on line": (lambda a, b: lm.PointOnLineJoint("high", a, b, axis=(0, 0, 1)), 2),
    "skew plane": (lambda a, b: lm.PointInPlaneJoint("high", a, b, axis=(0.6, 0, 0.8)), 1),
}


@pytest.mark.parametrize("kind", DOORS)
def test_a_door_is_held_by_its_second_hinge_as_often_as_grueblers_rule_says(kind):
    """The first hinge leaves one rotation, which the second one allows: every equation of the second is redundant.

    Elimination meets none of those of the spherical joint: it leaves out the equations of rigidity in their place.
    """
    high, number = DOORS[kind]
    with pytest.raises(ConstraintError, match="redundant in the initial position"):
        Equations(door(high).compile())
    equations = Equations(door(high, "drop").compile())
    assert equations.mobility == 1
    found = every_repeated_row(equations)
    assert len(found) == number
    rows = rows_of(equations)
    assert {rows.names[rows.owners[item.row]] for item in found} == {"high"}
    assert all({rows.names[rows.owners[k]] for k in item.repeats} == {"low"} for item in found)


def rows_of(equations):
    start = equations.start()
    size = np.sqrt(equations.constraints.matrix(0.0, equations.coordinates(start)).power(2) @ equations.model.magnitude**2)
    return Rows.of(equations.model, equations.constraints, size)


def every_repeated_row(equations):
    rows, elimination = rows_of(equations), equations.elimination
    matrix = equations.constraints.matrix(0.0, equations.coordinates(equations.start()))
    reduced = (matrix @ elimination.T).toarray() * equations.magnitude
    kept, _ = independent_rows(reduced, equations.constraints.of_bodies)
    R = relations(rows, elimination, matrix, reduced, kept)
    dense = np.zeros((rows.n_linear, equations.model.n_q))
    for k, row in enumerate(equations.model.rows):
        np.add.at(dense[k], row.coords, row.coefs)
    every = np.vstack([dense, matrix.toarray()]) * equations.model.magnitude
    every /= np.linalg.norm(every, axis=1, keepdims=True)
    assert np.abs(R @ every).max() < 1e-12  # they are relations
    assert len(R) == len(every) - np.linalg.matrix_rank(every)  # and all there are
    found = repeated_rows(rows, R, len(elimination.relations))
    bodies = every[rows.owners == BODY]
    assert len(found) == np.linalg.matrix_rank(bodies) + (rows.owners != BODY).sum() - np.linalg.matrix_rank(every)
    return found


def test_a_fixed_joint_on_the_ground_repeats_rigidity_without_a_word():
    """An edge of a rigid plate fixed to the ground holds each of its nodes, and the lengths of its axes."""
    ground, plate = lm.Ground(), lm.Plate("plate", (1.0, 0.5), (2, 2), SECTION, strain="rigid")
    other = lm.Plate("other", (1.0, 0.5), (2, 2), SECTION, strain="rigid", position=(1.0, 0, 0))
    weld = lm.FixedJoint("weld", ground.origin, plate.edge("x-"))
    hinge = lm.EdgeHinge("hinge", plate.edge("x+"), other.edge("x-"))
    equations = equations_of(ground, plate, other, weld, hinge)
    assert equations.elimination.relations
    assert equations.notes == []
    assert equations.mobility == 1


def flexible(name="plate", position=(0.0, 0.0, 0.0), **options):
    return lm.Plate(name, (1.0, 1.0), (2, 2), SECTION, position=position, **options)


def test_edges_that_share_a_corner_overlap_and_it_is_told():
    plate = flexible()
    equations = equations_of(plate, lm.Clamp("left", plate.edge("x-")), lm.Clamp("front", plate.edge("y-")))
    text = "where 'front' meets 'left' it holds the same (12 rows); the reaction of what they share is counted in 'left'"
    assert equations.notes == [text]


def test_hinge_and_supports_of_both_corners_overlap():
    a, b = flexible("a"), flexible("b", (1.0, 0.0, 0.0))
    supports = lm.PointSupport("one", a.corner("x+y-")), lm.PointSupport("two", b.corner("x-y-"), axes="z")
    equations = equations_of(a, b, lm.EdgeHinge("hinge", a.edge("x+"), b.edge("x-")), *supports)
    assert equations.notes[0].startswith("where 'two' meets 'hinge' and 'one' it holds the same (1 row); the reaction of")


def four_plates(**options):
    """Four plates around a point, hinged to each other."""
    places = {"a": (0.0, 0.0, 0.0), "b": (1.0, 0.0, 0.0), "c": (1.0, 1.0, 0.0), "d": (0.0, 1.0, 0.0)}
    a, b, c, d = (flexible(name, place, **options) for name, place in places.items())
    pairs = {"ab": (a, "x+", b, "x-"), "bc": (b, "y+", c, "y-"), "cd": (c, "x-", d, "x+"), "da": (d, "y-", a, "y+")}
    return [a, b, c, d, *(lm.EdgeHinge(name, p.edge(side), q.edge(other)) for name, (p, side, q, other) in pairs.items())]


def test_hinges_around_a_point_overlap_when_plates_are_flexible_and_are_redundant_when_rigid():
    """The crease pattern of four rigid panels, in its flat position, is a closed chain with three equations too many, or more."""
    (text,) = equations_of(*four_plates()).notes
    assert text.startswith("where 'da' meets 'ab' and 'bc' and 'cd' it holds the same (3 rows)")
    with pytest.raises(ConstraintError, match=r"by 'da' \(follows from "):
        equations_of(*four_plates(strain="rigid"))


@pytest.mark.parametrize(
    ("second", "named"),
    [
        (lambda plate: lm.EdgeSupport("again", plate.edge("x-")), "x of r at node 0 of edge plate.x- by 'again'"),
        (lambda plate: lm.PointSupport("again", plate.corner("x-y-"), axes="z"), "z of the position at plate.x-y- by 'again'"),
    ],
)
def test_a_support_that_holds_nothing_new_is_redundant(second, named):
    plate = flexible()
    items = plate, lm.Clamp("root", plate.edge("x-")), second(plate)
    with pytest.raises(ConstraintError) as caught:
        equations_of(*items)
    assert f"{named} (follows from " in str(caught.value)
    assert "by 'root')" in str(caught.value)
    assert equations_of(*items, redundant="drop").notes[0].startswith(f"left out as redundant: {named} (follows from ")


def test_two_supports_of_one_point_are_redundant():
    plate = flexible()
    marker = plate.marker("m", 0.3, 0.4)
    with pytest.raises(
        ConstraintError, match=r"z of the position at plate.m by 'b' \(follows from z of the position at plate.m by 'a'\)"
    ):
        equations_of(plate, lm.PointSupport("a", marker), lm.PointSupport("b", marker, axes="z"))


def test_a_table_on_four_legs_stands_on_three_when_it_is_rigid():
    def table(**options):
        plate = flexible(**options)
        return [plate, *(lm.PointSupport(f"leg {c}", plate.corner(c), axes="z") for c in ("x-y-", "x+y-", "x-y+", "x+y+"))]

    assert equations_of(*table()).notes == []
    with pytest.raises(
        ConstraintError, match=r"by 'leg x\+y\+' \(follows from .*by 'leg x-y-', .*by 'leg x\+y-', .*by 'leg x-y\+'\)"
    ):
        equations_of(*table(strain="rigid"))


@pytest.mark.parametrize("end", [0.0, 0.1])
def test_a_rigid_plate_that_is_pulled_along_contradicts(end):
    """Both corners of an edge are held along it; elimination keeps these rows and leaves out the length of r_x."""

    def pulled(redundant):
        plate = flexible(strain="rigid")
        pull = lm.PrescribedMotion("pull", plate.corner("x+y-"), "x", lm.Ramp(t_end=1.0, end=end))
        return system_of(plate, lm.PointSupport("pin", plate.corner("x-y-")), pull, redundant=redundant)

    with pytest.raises(ConstraintError, match=r"x of the position at plate.x\+y- by 'pull' \(follows from .*by 'pin'"):
        lm.simulate(pulled("raise"), 0.01, STEPS)
    if end:
        with pytest.raises(
            ConstraintError, match=r"contradictory: unit length of r_x of plate 'plate' against the joints in velocity"
        ):
            lm.simulate(pulled("drop"), 0.01, STEPS)
    else:
        assert lm.simulate(pulled("drop"), 0.01, STEPS).outcome.detail == ""


def test_a_redundant_joint_that_locks_the_system_is_told_so():
    ground, arm = lm.Ground(), lm.RigidBody("arm", mass=1.0, inertia=(0.1, 0.1, 0.1))
    joints = [lm.RevoluteJoint(name, ground.origin, arm.origin, axis=axis) for name, axis in (("p", (0, 1, 0)), ("q", (1, 0, 0)))]
    with pytest.raises(ConstraintError, match=r"points of q \(follows from .* the system is locked by its joints"):
        equations_of(ground, arm, *joints)
