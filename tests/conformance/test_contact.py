"""Contact of shells with every obstacle, on both elements: derivatives, balance, invariance, and what bristles remember."""

from __future__ import annotations

import numpy as np
import pytest

import lamella as lm
from lamella.assembly.equations import Equations
from lamella.contact.block import ContactBlock
from lamella.dofs import Build
from lamella.errors import DeclarationError
from lamella.math.rotation import matrix_from_vector

RADIUS, TOP = 0.3, -0.006  # the sheet's lower side is at z = -0.01
TURN, ARM = np.array((0.2, -0.1, 0.1)), np.array((0.02, 0.01, -0.1))
LAMINATE = lm.Laminate(lm.Isotropic(E=2e9, nu=0.3, rho=1200), thickness=0.02)
OBSTACLES = ("cylinder", "sphere", "plane")
LAWS = {
    "elastic": {},
    "damped": {"damping": 0.2},
    "regularised": {"damping": 0.2, "mu": 0.3, "friction": lm.RegularisedFriction(velocity=0.1)},
    "sliding bristles": {"damping": 0.2, "mu": 0.3, "friction": lm.BristleFriction(stiffness=1e8, damping=1e3)},
    "sticking bristles": {"mu": 30.0, "friction": lm.BristleFriction(stiffness=1e6, damping=1e3)},
}


class Case:
    """A sheet that touches an obstacle, turned and displaced a little in all coordinates."""

    def __init__(
        self,
        obstacle="cylinder",
        law="elastic",
        fixed=False,
        element="plate48",
        exponent=3.0,
        spread=(0.0, 0),
        amount=1e-3,
        flat=False,
    ):
        self.build = Build()
        place = np.array((0.2, 0.2, TOP - (0.0 if obstacle == "plane" else RADIUS)))
        turn = np.eye(3) if fixed else matrix_from_vector(TURN)
        if fixed:
            body = lm.Ground()
            at = body.marker("centre", *place)
        else:
            body = lm.RigidBody("roller", mass=3.0, inertia=(1.0, 1.2, 1.5), position=place - turn @ ARM, rotation=TURN)
            at = body.marker("centre", *ARM)
        size, mesh = (0.5 + spread[0], 0.4), (2 + spread[1], 1)
        plate = lm.Plate("sheet", size, mesh, LAMINATE, element=element)
        # a unit of length such that differences are as exact for the cubic law as they can be
        options = {"stiffness": 1e7 / 0.004 ** (exponent - 1.5), "exponent": exponent, **LAWS[law]}
        along = turn.T @ (0.05, 1.0, 0.02) if obstacle == "cylinder" else turn.T @ ((0, 0, 1) if flat else (0.01, -0.01, 1.0))
        if obstacle == "cylinder":
            contact = lm.CylinderContact("pair", plate, at, RADIUS, 0.2, axis=along, edge=0.2, **options)
        elif obstacle == "sphere":
            contact = lm.SphereContact("pair", plate, at, RADIUS, **options)
        else:
            contact = lm.PlaneContact("pair", plate, at, along, **options)
        for item in (body, plate, contact):
            item.contribute(self.build)
        (self.block,) = [block for block in self.build.forces if block.name == "pair"]
        self.is_position = np.concatenate(self.build.is_position)
        rng = np.random.default_rng(3)
        self.rest = self.build.initial.reshape(-1)
        self.q = self.rest + amount * rng.standard_normal(self.rest.size)
        self.v = 0.2 * rng.standard_normal(self.rest.size)
        # bristles that slide do so everywhere, and go on: away from the corners of the law differences are exact
        self.block.settle(0.0, self.sheared(-5e-3 if law == "sliding bristles" else 0.0))
        if law == "sliding bristles":
            self.v = 0.1 * self.v
            self.v[self.along_x()] += 0.5

    def along_x(self):
        """Coordinates x of the positions of the sheet."""
        sheet = np.arange(len(self.is_position)) >= self.build.bodies["sheet"].first
        return 3 * np.flatnonzero(self.is_position & sheet)

    def sheared(self, by):
        """The sheet at rest, displaced along x."""
        q = self.rest.copy()
        q[self.along_x()] += by
        return q

    def settled_at_rest(self):
        self.block.reset()
        self.block.settle(0.0, self.rest)
        return self

    def f(self, q, v):
        block, total = self.block, np.zeros(len(q))
        buffer = np.full(len(block.f_coords), np.nan)
        block.force(0.0, q, v, buffer)
        used = block.f_coords >= 0
        np.add.at(total, block.f_coords[used], (buffer * block.f_scale)[used])
        return total

    def tangent(self, alpha_q=1.0, alpha_v=0.0):
        block, K = self.block, np.zeros((len(self.q),) * 2)
        buffer, k = np.full(len(block.f_coords), np.nan), np.full(len(block.k_rows), np.nan)
        block.force_tangent(0.0, self.q, self.v, alpha_q, alpha_v, self.q, buffer, k)
        written = np.repeat(block.k_used, np.diff(block.k_parts))
        assert np.isfinite(k[written]).all()
        assert np.isnan(k[~written]).all()
        used = written & (block.k_rows >= 0)
        np.add.at(K, (block.k_rows[used], block.k_cols[used]), (k * block.k_scale)[used])
        return K


def derivative(function, x, direction, step=5e-6):
    """Along a direction, by central differences of fourth order: the error h^4 / 30 of the fifth derivative, and rounding."""

    def difference(h):
        return (function(x + h * direction) - function(x - h * direction)) / (2 * h)

    return (4 * difference(step) - difference(2 * step)) / 3


def check_tangent(case):
    rng = np.random.default_rng(5)
    for alpha_q, alpha_v in ((1.0, 0.0), (0.0, 1.0), (1.0, 300.0)):
        K = case.tangent(alpha_q, alpha_v)
        for _ in range(4):
            d = rng.standard_normal(len(case.q))
            d /= np.abs(d).max()
            found = alpha_q * derivative(lambda q: case.f(q, case.v), case.q, d)
            if alpha_v:
                found = found + alpha_v * derivative(lambda v: case.f(case.q, v), case.v, d, step=1e-3)
            scale = max(np.abs(found).max(), np.abs(K).max())
            assert scale > 0.0 or (alpha_q == 0.0 and not case.block.depends_on_velocity)
            assert np.abs(K @ d - found).max() <= 1e-8 * scale


@pytest.mark.parametrize("element", ["plate48", "plate36"])
@pytest.mark.parametrize("fixed", [False, True], ids=["moving", "fixed"])
@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("obstacle", OBSTACLES)
def test_tangent_is_the_derivative_of_the_force(obstacle, law, fixed, element):
    case = Case(obstacle, law, fixed, element)
    assert case.block.totals(case.q, case.v).points >= 3
    check_tangent(case)


@pytest.mark.parametrize("obstacle", OBSTACLES)
def test_tangent_of_the_hertzian_exponent(obstacle):
    """With e = 3/2 differences are good to 1e-6 only: the second derivative is infinite where contact begins."""
    case = Case(obstacle, "regularised", exponent=1.5)
    d = np.random.default_rng(5).standard_normal(len(case.q))
    found = derivative(lambda q: case.f(q, case.v), case.q, d, step=1e-7)
    assert np.abs(case.tangent() @ d - found).max() <= 1e-6 * np.abs(found).max()


def test_points_on_the_rounded_end_of_a_cylinder_touch():
    """So that the derivatives above cover the ends: some points lie beyond the straight part."""
    case = Case("cylinder")
    field = case.block.field(case.q, case.v)
    y = (np.arange(7) + 0.5) / 7 * 0.4
    beyond = (np.abs(y - 0.2) > 0.11)[:, None] & (field.gap.reshape(2, 7, 7) < 0.0)
    assert beyond.any()


@pytest.mark.parametrize("element", ["plate48", "plate36"])
@pytest.mark.parametrize("exponent", [1.5, 3.0])
@pytest.mark.parametrize("obstacle", OBSTACLES)
def test_elastic_force_is_the_gradient_of_the_energy(obstacle, exponent, element):
    case = Case(obstacle, element=element, exponent=exponent)
    d = np.random.default_rng(7).standard_normal(len(case.q))
    found = derivative(lambda q: case.block.energy(0.0, q), case.q, d, step=1e-6)
    assert found == pytest.approx(d @ case.f(case.q, case.v), rel=1e-7)  # rounding of the energy over 1e-6
    K = case.tangent()
    assert np.abs(K - K.T).max() <= 1e-13 * np.abs(K).max()


def rigid(case, translation, rotation):
    """Velocities of all vectors in a rigid motion."""
    vectors = case.q.reshape(-1, 3)
    moved = np.cross(rotation, vectors)
    moved[case.is_position] += translation
    return moved.reshape(-1)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("obstacle", OBSTACLES)
def test_forces_and_torques_on_sheet_and_obstacle_sum_to_zero(obstacle, law):
    """The body's axes are orthonormal, as they are in every solution; the sheet is bent and all moves."""
    case = Case(obstacle, law)
    case.q[:12] = case.rest[:12]
    f, totals = case.f(case.q, case.v), case.block.totals(case.q, case.v)
    size = np.abs(totals.force).max()
    assert size > 1.0
    for direction in np.eye(3):
        assert abs(f @ rigid(case, direction, np.zeros(3))) <= 1e-12 * size
        assert abs(f @ rigid(case, np.zeros(3), direction)) <= 1e-12 * size
    body = case.q[:12].reshape(4, 3)
    centre = body[0] + ARM @ body[1:]
    own = np.where(np.arange(len(f)) < 12, f, 0.0)
    for k, direction in enumerate(np.eye(3)):
        assert -own @ rigid(case, direction, np.zeros(3)) == pytest.approx(totals.force[k], abs=1e-12 * size)
        about = rigid(case, -np.cross(direction, centre), direction)
        assert -own @ about == pytest.approx(totals.torque[k], abs=1e-12 * size)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("obstacle", OBSTACLES)
def test_damping_force_is_what_velocities_add(obstacle, law):
    case = Case(obstacle, law)
    block, buffer = case.block, np.full(len(case.block.f_coords), np.nan)
    block.damping_force(0.0, case.q, case.v, buffer)
    used, found = block.f_coords >= 0, np.zeros(len(case.q))
    np.add.at(found, block.f_coords[used], (buffer * block.f_scale)[used])
    whole, still = case.f(case.q, case.v), case.f(case.q, np.zeros_like(case.v))
    np.testing.assert_allclose(found, whole - still, atol=1e-12 * np.abs(whole).max())
    assert (np.abs(found).max() > 1e-6 * np.abs(whole).max()) == (law != "elastic")


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("obstacle", OBSTACLES)
def test_power_is_what_is_stored_and_what_becomes_heat(obstacle, law):
    case = Case(obstacle, law)
    case.q[:12] = case.rest[:12]
    spin = np.array((0.3, -0.5, 0.2))
    case.v[3:12] = np.cross(spin, case.q[3:12].reshape(3, 3)).reshape(-1)
    power = case.f(case.q, case.v) @ case.v
    totals = case.block.totals(case.q, case.v)
    stored = derivative(lambda t: case.block.energy(0.0, case.q + t * case.v), 0.0, 1.0, step=1e-6)
    # what bristles store is theirs to first order in stretch over radius
    exact = 1e-7 if "bristles" not in law else 0.02
    assert power == pytest.approx(stored + totals.friction_power + totals.damping_power, rel=exact)
    assert case.block.dissipation(0.0, case.q, case.v) == totals.friction_power + totals.damping_power
    assert totals.friction_power > 0.0 or case.block.law.mu == 0.0


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("obstacle", OBSTACLES)
def test_a_frame_that_is_turned_and_moves_changes_nothing(obstacle, law):
    case = Case(obstacle, law)
    case.q[:12] = case.rest[:12]
    before, totals = case.f(case.q, case.v), case.block.totals(case.q, case.v)
    R, shift, drift = matrix_from_vector(np.array((1.0, -2.0, 0.5))), np.array((3.0, -1.0, 2.0)), np.array((0.5, 0.1, -0.2))
    spin = np.array((0.0, 3.0, -1.0))
    q, v = case.q.reshape(-1, 3) @ R.T, case.v.reshape(-1, 3) @ R.T
    q[case.is_position] += shift
    v = v + np.cross(spin, q)
    v[case.is_position] += drift
    np.testing.assert_allclose(
        case.f(q.reshape(-1), v.reshape(-1)).reshape(-1, 3), before.reshape(-1, 3) @ R.T, atol=1e-10 * np.abs(before).max()
    )
    moved = case.block.totals(q.reshape(-1), v.reshape(-1))
    assert moved.friction_power == pytest.approx(totals.friction_power, rel=1e-9, abs=1e-12)


def test_contact_never_pulls():
    case = Case("plane", "damped", fixed=True, flat=True)
    v = np.zeros_like(case.q)
    v.reshape(-1, 3)[case.is_position, 2] = 100.0  # leaves faster than 1 / alpha
    assert case.block.totals(case.rest, np.zeros_like(v)).normal > 0.0
    assert case.block.totals(case.rest, v).normal == 0.0
    assert not case.f(case.rest, v).any()
    totals = case.block.totals(case.rest, v)
    assert totals.damping_power == pytest.approx(100.0 * case.block.totals(case.rest, 0 * v).normal)  # all of it becomes heat


@pytest.mark.parametrize("element", ["plate48", "plate36"])
@pytest.mark.parametrize("obstacle", OBSTACLES)
def test_elements_far_away_are_left_out_and_none_that_touches(obstacle, element):
    case = Case(obstacle, fixed=True, element=element, spread=(7.0, 28))
    totals, field = case.block.totals(case.q, case.v), case.block.field(case.q, case.v)
    assert totals.points == np.count_nonzero(field.gap < 0.0) > 0
    assert totals.evaluated % 49 == 0
    assert totals.evaluated <= 49 * 4 or obstacle == "plane"
    lifted = case.q.copy()
    lifted.reshape(-1, 3)[case.is_position, 2] += 1.0
    assert case.block.totals(lifted, case.v).evaluated == 0


def test_areas_sum_to_the_area_of_a_curved_shell():
    shell = lm.Shell("belt", lm.BeltSurface(2.5, 0.8), (24, 1), LAMINATE)
    body = lm.Ground()
    contact = lm.CylinderContact("pair", shell, body.marker("centre", 0, 0, 0.4), 0.1, 1.0, stiffness=1e8)
    build = Build()
    for item in (shell, body, contact):
        item.contribute(build)
    block = build.forces[-1]
    assert block.sheet.area.sum() == pytest.approx(2.0, rel=1e-5)  # the cubic arc of 15 deg is short by 6e-6


def test_bristles_hold_slide_and_return():
    case = Case("plane", "sliding bristles", fixed=True, flat=True).settled_at_rest()
    block, still = case.block, np.zeros_like(case.q)
    normal = block.totals(case.rest, still).normal
    stiffness = 1e8 * 0.5 * 0.4  # of all bristles together
    limit = 0.3 * normal
    for by in (-0.9 * limit / stiffness, 0.9 * limit / stiffness):
        held = block.totals(case.sheared(by), still)
        assert held.force[0] == pytest.approx(stiffness * by, rel=1e-9)
        for _ in range(50):  # held under less than mu N it does not creep
            block.settle(0.0, case.sheared(by))
        np.testing.assert_array_equal(block.totals(case.sheared(by), still).force, held.force)
        assert held.energy - block.totals(case.rest, still).energy == pytest.approx(0.5 * stiffness * by**2, rel=1e-6)
    far = 1e-2
    assert block.totals(case.sheared(far), still).force[0] == pytest.approx(limit, rel=1e-12)
    block.settle(0.0, case.sheared(far))
    assert block.totals(case.sheared(far), still).force[0] == pytest.approx(limit, rel=1e-9)
    for by in (-0.5, -1.5):  # from where it slid to it lets go elastically, and pulls the other way
        back = block.totals(case.sheared(far + by * limit / stiffness), still)
        assert back.force[0] == pytest.approx((1.0 + by) * limit, rel=1e-9)
    assert block.totals(case.sheared(far - 3.0 * limit / stiffness), still).force[0] == pytest.approx(-limit, rel=1e-12)


def test_history_changes_with_accepted_steps_alone():
    case = Case("plane", "sliding bristles", fixed=True).settled_at_rest()
    block, still = case.block, np.zeros_like(case.q)
    before = block.totals(case.q, still).force
    for by in (1e-4, -3e-3, 5e-2):  # steps that are tried and rejected
        case.f(case.sheared(by), case.v)
        block.totals(case.sheared(by), case.v)
        block.energy(0.0, case.sheared(by))
    np.testing.assert_array_equal(block.totals(case.q, still).force, before)
    block.settle(0.0, case.sheared(5e-2))
    assert np.abs(block.totals(case.q, still).force - before).max() > 0.1
    block.reset()
    assert block.energy(0.0, case.q) == pytest.approx(Case("plane", fixed=True).block.energy(0.0, case.q))  # no bristle holds
    block.settle(0.0, case.rest)
    np.testing.assert_array_equal(block.totals(case.q, still).force, before)


def test_bristles_on_a_roller_that_rolls_with_the_sheet_are_not_stretched():
    """A plane on a body and the sheet turn together by a large angle."""
    case = Case("plane", "sticking bristles")
    R, still = matrix_from_vector(np.array((0.4, 1.9, -0.7))), np.zeros_like(case.q)
    before = case.block.totals(case.rest, still)
    turned = (case.rest.reshape(-1, 3) @ R.T).reshape(-1)
    after = case.block.totals(turned, still)
    np.testing.assert_allclose(after.force, R @ before.force, atol=1e-9 * before.normal)
    assert after.energy == pytest.approx(before.energy, rel=1e-12)


def make(**change):
    shell = lm.Plate("sheet", (0.5, 0.4), (2, 1), LAMINATE)
    ground = lm.Ground()
    given = {
        "shell": shell,
        "at": ground.marker("centre", 0.2, 0.2, -0.31),
        "radius": 0.3,
        "length": 0.5,
        "stiffness": 1e7,
        **change,
    }
    return shell, ground, lm.CylinderContact("roller", **given)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"mu": -0.1}, "CylinderContact 'roller': mu = -0.1; accepted is a value at least 0"),
        ({"stiffness": 0.0}, "CylinderContact 'roller': stiffness = 0.0; accepted is a value greater than 0"),
        ({"damping": "-1 s/m"}, "damping"),
        ({"axis": (0, 0, 0)}, "axis = (0, 0, 0)"),
        ({"exponent": 0.5}, "exponent = 0.5; accepted is a value at least 1"),
        ({"friction": "glue"}, "CylinderContact 'roller': friction"),
    ],
)
def test_impossible_values_are_named(change, said):
    with pytest.raises(DeclarationError) as error:
        make(**change)[2].obstacle()
    assert said in str(error.value)


def test_a_marker_of_a_shell_is_refused():
    shell, other = (lm.Plate(name, (0.5, 0.4), (2, 1), LAMINATE) for name in ("sheet", "other"))
    with pytest.raises(
        DeclarationError, match=r"PlaneContact 'floor': the marker sheet.x-y- is on the same shell; accepted is a Rig"
    ):
        lm.PlaneContact("floor", shell, shell.corner("x-y-"), stiffness=1e7)
    with pytest.raises(DeclarationError, match=r"the marker other\.x-y- is on a deformable body"):
        lm.PlaneContact("floor", shell, other.corner("x-y-"), stiffness=1e7)


def test_an_offset_laminate_is_refused():
    laminate = lm.Laminate(lm.Isotropic(E=2e9, nu=0.3, rho=1200), thickness=0.02, offset=0.005)
    shell = lm.Plate("sheet", (0.5, 0.4), (2, 1), laminate)
    with pytest.raises(DeclarationError, match=r"the laminate of 'sheet' has offset = 0\.005 m; accepted is"):
        lm.PlaneContact("floor", shell, lm.Ground().origin, stiffness=1e7)


def test_an_obstacle_in_the_sheet_at_the_start_is_named_with_depth_and_place():
    ground = lm.Ground()
    shell, _, contact = make(at=ground.marker("centre", 0.2, 0.2, -0.25), axis=(0, 1, 0))
    build = Build()
    ground.contribute(build)
    shell.contribute(build)
    with pytest.raises(DeclarationError) as error:
        contact.contribute(build)
    said = str(error.value)
    assert (
        "CylinderContact 'roller': the obstacle at ground.centre overlaps 'sheet' by 0.05997 m at the start, at x = 0.1964"
        in said
    )
    assert "accepted is up to half the thickness, 0.01 m" in said


def refused(*placed, belt=True, bodies=True):
    """What is said about rollers 'a', 'b' ... of a radius, centre and axis in a belt of 2.5 m, R = 0.398 m."""
    if belt:
        shell = lm.Shell("belt", lm.BeltSurface(2.5, 0.8), (24, 1), LAMINATE, position=(0, 0, -0.4))
    else:
        shell = lm.Plate("sheet", (2.0, 2.0), (2, 2), LAMINATE, position=(0, 0, -5.0))
    build, ground = Build(), lm.Ground()
    items = [ground, shell]
    for name, (radius, centre, axis) in zip("abc", placed, strict=False):
        roller = lm.RigidBody(f"roller_{name}", mass=1.0, inertia=(1, 1, 1), position=centre)
        items.insert(0, roller)
        at = roller.origin if bodies else ground.marker(name, *centre)
        items.append(lm.CylinderContact(name, shell, at, radius, 1.2, axis, stiffness=1e8))
    try:
        for item in items:
            item.contribute(build)
    except DeclarationError as error:
        return str(error)
    return ""


Z = (0, 0, 1)


def test_rollers_that_overlap_are_named_with_radii_and_distance():
    said = refused((0.15, (-0.14, 0, 0), Z), (0.12, (0.12, 0, 0), Z))
    assert said == (
        "CylinderContact 'b': its cylinder at roller_b.origin and that of 'a' overlap by 0.01 m at the start: "
        "radii of 0.12 and 0.15 m, axes 0.26 m apart; "
        "accepted are cylinders that are apart, or both on one body; move one of them"
    )
    assert not refused((0.15, (-0.15, 0, 0), Z), (0.12, (0.121, 0, 0), Z))
    assert not refused((0.15, (-0.14, 0, 0), Z), (0.12, (0.12, 0, 0), Z), bodies=False)  # one obstacle of two cylinders


@pytest.mark.parametrize(
    ("centre", "axis", "overlap"),
    [
        ((0.25, 0, 0), (0.02, 0, 1), True),  # askew: the middles are apart, the ends are not
        ((0.25, 0, 0.55), (0.02, 0, 1), True),
        ((0.25, 0, 1.15), (-0.02, 0, 1), False),  # leans away where they are side by side
        ((0.25, 0, 0), (0, 0.02, 1), False),
        ((0.0, 0.1, 0.0), (1, 0, 0), True),  # crosswise
        ((0.0, 0.25, 0.0), (1, 0, 0), False),
        ((0.0, 0.0, 1.25), Z, False),  # one behind the other
        ((0.0, 0.0, 1.15), Z, True),
        ((0.1, 0.0, 1.25), Z, False),
    ],
)
def test_overlap_of_rollers_in_any_place(centre, axis, overlap):
    said = refused((0.12, (0, 0, 0), Z), (0.12, centre, axis), belt=False)
    assert ("overlap by" in said) == overlap


def test_a_belt_too_short_for_its_rollers_is_told_what_it_needs():
    """Around two circles of 0.15 m that are 0.8 m apart are 2 x 0.8 + 2 pi 0.15 = 2.542 m."""
    said = refused((0.15, (-0.2, 0, 0), Z), (0.15, (0.395, 0, 0), Z), (0.15, (0.0, 0.35, 0), Z))
    assert "overlaps" in said  # long enough, but the second is not within the circle
    said = refused((0.15, (-0.24, 0, 0), Z), (0.25, (0.385, 0, 0), Z))
    needed = 2 * np.sqrt(0.625**2 - 0.1**2) + np.pi * 0.4 + 2 * np.arcsin(0.1 / 0.625) * 0.1
    assert said == (
        f"CylinderContact 'b': 'belt' is 2.5 m around at the start, the cylinders inside it, 'a' and 'b', are {needed:.4g} m; "
        "accepted is a longer shell, or smaller or closer cylinders"
    )
    assert "the cylinders inside it, 'a', are 2.639 m" in refused((0.42, (0, 0, 0), Z))
    assert not refused((0.2, (-0.19, 0, 0), Z), (0.12, (0.6, 0, 0), Z))  # the second presses from outside


def test_a_roller_that_cuts_the_belt_is_named():
    said = refused((0.12, (0.45, 0, 0), Z))
    assert "CylinderContact 'a': the obstacle at roller_a.origin overlaps 'belt' by 0.0" in said
    assert "accepted is up to half the thickness, 0.01 m" in said


def test_statics_finds_how_deep_a_block_sinks():
    """Depth (m g / (k A))^(2/3); friction has no part in it."""
    side, mass, k = 0.2, 6.4, 1e9
    block = lm.Plate(
        "block", (side, side), (1, 1), lm.Laminate(lm.Isotropic(E=2e11, nu=0.3, rho=8000), thickness=0.02), strain="rigid",
        position=(0, 0, 0.01 - 1e-5),
    )  # fmt: skip
    system, ground = lm.System(), lm.Ground()
    floor = lm.PlaneContact("floor", block, ground.origin, stiffness=k, damping=0.4, mu=0.3)
    guide = lm.PrismaticJoint("guide", ground.marker("middle", 0.1, 0.1, 0.01), block.marker("middle", 0.1, 0.1))
    for item in (ground, block, floor, guide, lm.Gravity("weight", (0, 0, -9.81))):
        system.add(item)
    result = lm.equilibrium(system)
    assert float(result["floor.depth"]) == pytest.approx((mass * 9.81 / (k * side**2)) ** (2 / 3), rel=1e-8)
    assert result["floor.force"].values[2] == pytest.approx(-mass * 9.81, rel=1e-8)


@pytest.mark.parametrize("how", [{}, {"damping": 0.4, "mu": 0.3}], ids=["without friction", "with friction"])
def test_a_recorded_state_is_evaluated_once(how, monkeypatch):
    """By the reaction of a support beside the contact and by all its signals together: they are given the same arrays."""
    sheet = lm.Laminate(lm.Isotropic(E=7e10, nu=0.3, rho=2700), thickness=2e-3)
    plate = lm.Plate("plate", (0.5, 0.2), (2, 1), sheet, position=(0, 0, 1e-3 - 1e-6))
    system, ground = lm.System(), lm.Ground()
    contact = lm.PlaneContact("floor", plate, ground.origin, stiffness=1e8, **how)
    for item in (ground, plate, contact, lm.Clamp("root", plate.edge("x-"))):
        system.add(item)
    equations, calls, real = Equations(system.compile()), [], ContactBlock._evaluate

    def counted(self, *arguments, **options):
        calls.append(1)
        real(self, *arguments, **options)

    monkeypatch.setattr(ContactBlock, "_evaluate", counted)
    state = equations.state(equations.start())
    values = [signal.evaluate(state) for signal in equations.model.signals if signal.name.startswith("floor.")]
    assert len(values) > 3
    assert np.abs(values[0]).max() > 0.0
    assert len(calls) == 1
