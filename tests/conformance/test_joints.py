"""Every support and joint keeps the same rules: it holds what it says, its derivatives are exact, its reactions balance."""

from __future__ import annotations

import importlib
import inspect
import pkgutil

import numpy as np
import pytest
from joint_pairs import PAIRS

import lamella as lm
import lamella.joint
from lamella.errors import DeclarationError, LamellaError
from lamella.math.rotation import matrix_from_vector
from lamella.roles import Declaration

SECTION = lm.Laminate(lm.Isotropic(E=2e9, nu=0.3, rho=1200.0), thickness=0.02)
SIZE, PLACE, TURN = (1.2, 0.9), (0.4, -0.2, 0.3), (0.1, -0.3, 0.7)
DRIVE = lm.Harmonic(amplitude=0.02, frequency=4.0)
LOAD = (12.0, -7.0, 20.0)


def direction(x, y, z):
    """A direction given in the plate's axes, in the inertial frame."""
    return tuple(matrix_from_vector(np.array(TURN)) @ (x, y, z))


def make_plate():
    return lm.Plate("plate", SIZE, (2, 2), SECTION, position=PLACE, rotation=TURN)


# Each joint with the supports it needs beside it so that the plate cannot move freely.
JOINTS = {
    "clamp of an edge": lambda p: [lm.Clamp("joint", p.edge("x-"))],
    "clamp of a point": lambda p: [lm.Clamp("joint", p.marker("at", 0.3, 0.5))],
    "restrained clamp": lambda p: [lm.Clamp("joint", p.edge("y-"), kind="restrained")],
    "sliding clamp": lambda p: [lm.Clamp("joint", p.edge("x-"), kind="sliding")],
    "moving restrained clamp": lambda p: [lm.Clamp("joint", p.edge("x+"), {"x": DRIVE, "y": DRIVE}, "restrained")],
    "moving sliding clamp": lambda p: [lm.Clamp("joint", p.edge("y+"), {"x": DRIVE, "z": DRIVE}, "sliding")],
    "moving clamp": lambda p: [lm.Clamp("joint", p.edge("y+"), motion={"x": DRIVE, "z": DRIVE})],
    "point support": lambda p: [lm.PointSupport("joint", p.marker("at", 0.31, 0.47)), lm.Clamp("other", p.edge("x-"))],
    "point support along z": lambda p: [lm.PointSupport("joint", p.corner("x+y+"), axes="z"), lm.Clamp("other", p.edge("x-"))],
    "edge support": lambda p: [lm.EdgeSupport("joint", p.edge("x+")), lm.Clamp("other", p.edge("x-"))],
    "edge support across": lambda p: [lm.EdgeSupport("joint", p.edge("y-"), axes="xz"), lm.Clamp("other", p.edge("x-"))],
    "oblique edge support": lambda p: [
        lm.EdgeSupport("joint", p.edge("x+"), axes="yz", rotation=(0.3, 0.2, -0.5)),
        lm.Clamp("other", p.edge("x-")),
    ],
    "moving edge support": lambda p: [
        lm.EdgeSupport("joint", p.edge("x+"), axes="xz", rotation=(0.3, 0.2, -0.5), motion={"z": DRIVE}),
        lm.Clamp("other", p.edge("x-")),
    ],
    "symmetry": lambda p: [lm.Symmetry("joint", p.edge("x+"), normal=direction(1, 0, 0)), lm.Clamp("other", p.edge("x-"))],
    "symmetry that meets a clamp": lambda p: [
        lm.Symmetry("joint", p.edge("y-"), normal=direction(0, -2, 0)),
        lm.Clamp("other", p.edge("x-")),
    ],
    "diaphragm": lambda p: [lm.Diaphragm("joint", p.edge("x+"), normal=direction(1, 0, 0.4)), lm.Clamp("other", p.edge("x-"))],
    "mean of an edge": lambda p: [
        lm.EdgeAverage("joint", p.edge("x+"), "xz", rotations="xz", motion={"z": DRIVE}),
        lm.Clamp("other", p.edge("x-")),
    ],
    "mean of an edge on the ground": lambda p: [
        ground := lm.Ground(),
        lm.EdgeAverage("joint", p.edge("y-"), to=ground.marker("peg", 2.0, 1.5, 1.0)),
        lm.Clamp("other", p.edge("x-")),
    ],
    "prescribed motion": lambda p: [
        lm.PrescribedMotion("joint", p.marker("at", 0.9, 0.4), "z", DRIVE),
        lm.Clamp("other", p.edge("x-")),
    ],
    "distance to the ground": lambda p: [
        ground := lm.Ground(),
        lm.DistanceJoint("joint", ground.marker("peg", 2.0, 1.5, 1.0), p.marker("at", 1.1, 0.6)),
        lm.Clamp("other", p.edge("x-")),
    ],
    "distance within a plate": lambda p: [
        lm.DistanceJoint("joint", p.marker("from", 0.7, 0.2), p.marker("at", 1.2, 0.9)),
        lm.Clamp("other", p.edge("x-")),
    ],
}


def make_system(name):
    system, plate = lm.System(), make_plate()
    system.add(plate)
    for item in JOINTS[name](plate):
        system.add(item)
    system.add(lm.PointForce("load", plate.marker("tip", 1.2, 0.71), LOAD))
    return system


joints = pytest.mark.parametrize("name", JOINTS)
multiplied = pytest.mark.parametrize("name", [name for name in JOINTS if "distance" in name])


# what holds angles, displacements and lengths has its cases in test_drives.py, linear constraints in test_linear_constraint.py
TESTED_APART = {"AngleDrive", "SlideDrive", "AngleCoupling", "PositionCoupling", "Cable", "LinearConstraint"}


def test_every_joint_of_the_package_is_tested():
    found = set()
    for module in pkgutil.iter_modules(lamella.joint.__path__, "lamella.joint."):
        for item in vars(importlib.import_module(module.name)).values():
            is_declaration = isinstance(item, type) and issubclass(item, Declaration) and not inspect.isabstract(item)
            if is_declaration and item.__module__.startswith("lamella.joint"):
                found.add(item)
    tested = {type(item) for make in JOINTS.values() for item in make(make_plate())}
    tested |= {type(pair.make()[2]) for pair in PAIRS.values()}
    assert {cls.__name__ for cls in found - tested} == TESTED_APART


@joints
def test_constraints_hold_after_statics_and_in_motion(name):
    system = make_system(name)
    still = lm.equilibrium(system, t=0.03)
    moving = lm.simulate(system, 0.02, lm.GeneralizedAlpha(dt=1e-3))
    for state, factor in ((still.final, 1.0), (moving.final, 1.0)):
        for row in still.model.rows:
            motion = row.motion.value(state.t) * factor if row.motion else 0.0
            assert row.coefs @ state.q[row.coords] == pytest.approx(row.constant + motion, abs=1e-13)
        for block in still.model.constraints:
            phi = np.empty(block.n_lam)
            block.phi(state.t, state.q, phi)
            assert np.abs(phi).max() < 1e-10


def external_and_inertia(result):
    """Force and torque about the origin of load and inertia in the last state."""
    state, model = result.final, result.model
    tip = result.history("tip.position").values[-1]
    inertia = (model.mass @ state.a).reshape(-1, 3) if result.axis == "time" else np.zeros((model.n_q // 3, 3))
    force = np.array(LOAD) - inertia[model.is_position].sum(axis=0)
    torque = np.cross(tip, LOAD) - np.cross(state.q.reshape(-1, 3), inertia).sum(axis=0)
    return force, torque


def reactions(result):
    """The same of all supports and of joints to the ground; a joint between points of one body adds nothing."""
    state, vectors = result.final, result.final.q.reshape(-1, 3)
    force, torque = np.zeros(3), np.zeros(3)
    for support in result.model.supports:
        part = result.history(f"{support.name}.force").values[-1]
        force += part
        torque += result.history(f"{support.name}.torque").values[-1] + np.cross(support.centre.at(vectors), part)
    for block in result.model.constraints:
        jacobian = np.empty(len(block.j_rows))
        block.jacobian(state.t, state.q, jacobian)
        generalised = np.zeros(result.model.n_q)
        np.add.at(generalised, block.j_cols, -jacobian * state.lam[block.j_rows])
        generalised = generalised.reshape(-1, 3)
        force += generalised[result.model.is_position].sum(axis=0)
        torque += np.cross(vectors, generalised).sum(axis=0)
    return force, torque


@joints
@pytest.mark.parametrize("kind", ["statics", "motion"])
def test_reactions_balance_load_and_inertia(name, kind):
    system = make_system(name)
    if kind == "statics":
        result = lm.equilibrium(system, t=0.03, newton=lm.Newton(tolerance=1e-10, keep=0.0))
    else:
        result = lm.simulate(system, 0.01, lm.GeneralizedAlpha(dt=1e-3, newton=lm.Newton(tolerance=1e-10)))
    (force, torque), (held, twisted) = external_and_inertia(result), reactions(result)
    # Newton leaves 1e-10 of displacement, a membrane stiffness of 4e7 N/m makes it 4e-3 N at the most; loads are some 25 N
    np.testing.assert_allclose(force + held, 0.0, atol=4e-3)
    np.testing.assert_allclose(torque + twisted, 0.0, atol=4e-3)


@joints
def test_signals_are_recorded(name):
    result = lm.equilibrium(make_system(name), t=0.03)
    assert result["joint.force"].shape == (3,)
    if "distance" in name:
        n = result["joint.force"].values
        assert abs(result["joint.tension"].values) == pytest.approx(np.linalg.norm(n))
    else:
        assert result["joint.torque"].shape == (3,)


def test_tension_is_positive_when_the_rod_is_pulled():
    """The plate hangs from a rod above its free edge and is pulled down: the rod pulls the plate up."""
    system, plate, ground = lm.System(), lm.Plate("plate", (1.0, 0.5), (1, 1), SECTION), lm.Ground()
    system.add(plate)
    system.add(ground)
    system.add(lm.EdgeSupport("hinge", plate.edge("x-")))
    system.add(lm.DistanceJoint("left", ground.marker("a", 1.0, 0.0, 2.0), plate.corner("x+y-")))
    system.add(lm.DistanceJoint("right", ground.marker("b", 1.0, 0.5, 2.0), plate.corner("x+y+")))
    system.add(lm.EdgeForce("pull", plate.edge("x+"), (0, 0, -60.0)))
    result = lm.equilibrium(system)
    # 30 N shared by two rods; the rods lean by the sag over 2 m, a change of second order
    assert float(result["left.tension"]) == pytest.approx(15.0, rel=1e-3)
    assert result["right.force"].values[2] == pytest.approx(15.0, rel=1e-3)


class Along:
    """A block of one joint along a smooth curve q(t) with its derivatives."""

    def __init__(self, name, seed=4):
        model = make_system(name).compile()
        (self.block,) = model.constraints
        rng = np.random.default_rng(seed)
        size = model.magnitude
        self.q, self.v = model.q0 + 0.1 * size * rng.uniform(-1, 1, model.n_q), size * rng.uniform(-1, 1, model.n_q)
        self.a, self.n = size * rng.uniform(-1, 1, model.n_q), model.n_q
        self.rng, self.size = rng, size

    def phi(self, q, t=0.3):
        out = np.empty(self.block.n_lam)
        self.block.phi(t, q, out)
        return out

    def jacobian(self, q):
        out, J = np.empty(len(self.block.j_rows)), np.zeros((self.block.n_lam, self.n))
        self.block.jacobian(0.3, q, out)
        np.add.at(J, (self.block.j_rows, self.block.j_cols), out)
        return J


@multiplied
def test_constraint_jacobian_is_the_derivative(name):
    case, h = Along(name), 1e-4
    for _ in range(3):
        d = case.size * case.rng.uniform(-1, 1, case.n)
        plus, minus = (case.phi(case.q + s * d) for s in (h, -h))
        np.testing.assert_allclose(case.jacobian(case.q) @ d, (plus - minus) / (2 * h), rtol=1e-6)


@multiplied
def test_curvature_is_the_derivative_of_the_constraint_force(name):
    case, h = Along(name), 1e-4
    lam = case.rng.uniform(1, 2, case.block.n_lam)
    out, K = np.empty(len(case.block.k_rows)), np.zeros((case.n, case.n))
    case.block.curvature(0.3, case.q, lam, out)
    np.add.at(K, (case.block.k_rows, case.block.k_cols), out)
    K = K + np.triu(K, 1).T
    assert np.all(case.block.k_rows <= case.block.k_cols)
    d = case.size * case.rng.uniform(-1, 1, case.n)
    force = [case.jacobian(case.q + s * d).T @ lam for s in (h, -h)]
    np.testing.assert_allclose(K @ d, (force[0] - force[1]) / (2 * h), atol=1e-6 * np.abs(K @ d).max())


@multiplied
def test_gamma_and_phi_t_are_derivatives_along_a_motion(name):
    case, h = Along(name), 1e-3

    def phi(s):
        return case.phi(case.q + s * case.v + 0.5 * s**2 * case.a, 0.3 + s)

    rate, gamma = np.empty(case.block.n_lam), np.empty(case.block.n_lam)
    case.block.phi_t(0.3, case.q, rate)
    case.block.gamma(0.3, case.q, case.v, gamma)
    J = case.jacobian(case.q)
    first = (-phi(2 * h) + 8 * phi(h) - 8 * phi(-h) + phi(-2 * h)) / (12 * h)
    second = (-phi(2 * h) + 16 * phi(h) - 30 * phi(0.0) + 16 * phi(-h) - phi(-2 * h)) / (12 * h**2)
    np.testing.assert_allclose(J @ case.v + rate, first, rtol=1e-6)
    np.testing.assert_allclose(J @ case.a + gamma, second, rtol=1e-5)


def test_given_length_is_reached_at_the_start_of_a_motion():
    system, plate, ground = lm.System(), make_plate(), lm.Ground()
    system.add(plate)
    system.add(ground)
    peg = np.array((0.0, 0.0, 1.5))
    tip = plate.marker("tip", 1.2, 0.9)
    build = system.compile()
    length = np.linalg.norm(build.plates[0].locate((1.2, 0.9)).at(build.q0.reshape(-1, 3)) - peg) + 1e-5
    system.add(lm.DistanceJoint("rod", ground.marker("peg", *peg), tip, length=float(length)))
    result = lm.simulate(system, 0.003, lm.GeneralizedAlpha(dt=1e-3))
    distance = np.linalg.norm(result["tip.position"].values - peg, axis=1)
    np.testing.assert_allclose(distance, length, atol=1e-10)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda p: lm.PointSupport("s", p.corner("x-y-"), axes="xw"), r"PointSupport 's': axes 'xw'; accepted are distinct"),
        (lambda p: lm.PointSupport("s", p.corner("x-y-"), axes="xx"), r"PointSupport 's': axes 'xx'"),
        (lambda p: lm.PointSupport("s", p.corner("x-y-"), axes=""), r"PointSupport 's': axes ''"),
        (lambda p: lm.EdgeSupport("s", p.edge("x-"), axes="xyzz"), r"EdgeSupport 's': axes 'xyzz'"),
        (
            lambda p: lm.EdgeSupport("s", p.edge("x-"), "xy", motion={"z": 1.0}),
            r"EdgeSupport 's': a motion along z of an edge held along x, y; accepted are motions along axes that are held",
        ),
        (lambda p: lm.Symmetry("s", p.edge("x-"), "w"), r"Symmetry 's'.*normal"),
        (lambda p: lm.EdgeAverage("s", p.edge("x-"), "xw"), r"EdgeAverage 's': axes 'xw'"),
        (lambda p: lm.EdgeAverage("s", p.edge("x-"), ""), r"EdgeAverage 's': axes ''"),
        (lambda p: lm.EdgeAverage("s", p.edge("x-"), rotations="xx"), r"EdgeAverage 's': axes 'xx'"),
        (
            lambda p: lm.EdgeAverage("s", p.edge("x-"), "x", motion={"y": 1.0}),
            r"EdgeAverage 's': a motion along y of a mean held along 'x'; accepted",
        ),
        (
            lambda p: lm.EdgeAverage("s", p.edge("x-"), "x", motion={"x": 1.0}, to=lm.Ground().origin),
            r"EdgeAverage 's': a motion along x of a mean held along 'x' with 'ground.origin'; accepted .* in space",
        ),
        (lambda p: lm.LinearConstraint("s", ()), r"LinearConstraint 's'.*terms"),
        (lambda p: lm.Component(p.corner("x-y-"), "w"), r"axis"),
        (lambda p: lm.Component(p.corner("x-y-"), "x", of="slope"), r"position.*slope_x.*slope_y"),
        (lambda p: lm.Clamp("s", p.edge("x-"), motion={"w": 1.0}), r"Clamp 's': axes 'w'"),
        (lambda p: lm.Clamp("s", p.edge("x-"), kind="loose"), r"Clamp 's'.*kind.*full.*restrained.*sliding"),
        (
            lambda p: lm.Clamp("s", p.corner("x-y-"), kind="sliding"),
            r"Clamp 's': kind 'sliding' of the point plate\.x-y-; accepted",
        ),
        (lambda p: lm.Clamp("s", p.edge("left")), r"no edge 'left'; accepted is x-, x\+, y- or y\+"),
        (lambda p: lm.PointSupport("s", p.corner("top")), r"no corner 'top'; accepted is x-y-"),
        (lambda p: lm.PrescribedMotion("s", p.corner("x-y-"), "w", 1.0), r"PrescribedMotion 's'.*axis"),
        (lambda p: lm.DistanceJoint("s", p.corner("x-y-"), p.corner("x-y+"), length=-1.0), r"DistanceJoint 's'.*length"),
        (lambda p: lm.PointSupport("s", p.marker("out", 2.0, 0.0)), r"marker 'out' lies outside the plate at x = 2 m"),
    ],
)
def test_impossible_joints_are_refused_with_a_message(make, message):
    with pytest.raises(DeclarationError, match=message):
        make(make_plate())


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (
            lambda p: lm.Symmetry("s", p.edge("x-"), "x"),
            r"Symmetry 's': edge plate\.x- leaves the plane with the normal \(1, 0, 0\) by .* m and .* deg; accepted is an edge",
        ),
        (lambda p: lm.Symmetry("s", p.edge("x-"), (0, 0, 0)), r"Symmetry 's': axis = \(0\.0, 0\.0, 0\.0\); accepted"),
        (
            lambda p: lm.Symmetry("s", p.edge("x-"), direction(1, 0, 0.5)),
            r"Symmetry 's': the lines of plate that cross edge plate\.x- meet the plane .* at 63\.4349 deg; accepted",
        ),
        (lambda p: lm.Diaphragm("s", p.edge("x-"), direction(0, 1, 0)), r"Diaphragm 's': edge plate\.x- leaves the plane"),
        (
            lambda p: lm.EdgeAverage("s", p.edge("x-"), to=p.corner("x+y+")),
            r"EdgeAverage 's': plate\.x\+y\+ and plate\.x- are on one body",
        ),
        (
            lambda p: lm.LinearConstraint(
                "s", (lm.Component(p.corner("x-y-"), "x", 0.0), lm.Component(p.corner("x-y+"), "x", 0.0))
            ),
            r"LinearConstraint 's': nothing in it can move: 0 position of plate\.x-y-, 0 position of plate\.x-y\+; accepted",
        ),
        (
            lambda p: lm.LinearConstraint("s", (lm.Component(p.corner("x-y-"), "x"), lm.Component(p.corner("x-y-"), "x", -1.0))),
            r"LinearConstraint 's': nothing in it can move: 1 position of plate\.x-y-, -1 position",
        ),
        (
            lambda p: lm.LinearConstraint("s", (lm.Component(lm.Plate("other", SIZE, (1, 1), SECTION).corner("x-y-"), "x"),)),
            r"body 'other' is referred to but was not added",
        ),
        (lambda p: lm.LinearConstraint("s", (lm.Component(p.corner("x-y-"), (0, 0, 0)),)), r"LinearConstraint 's': axis = "),
    ],
)
def test_joints_that_do_not_fit_the_reference_are_refused(make, message):
    system, plate = lm.System(), make_plate()
    system.add(plate)
    system.add(make(plate))
    with pytest.raises(LamellaError, match=message):
        system.compile()


def test_terms_on_the_ground_alone_and_slopes_of_the_ground_are_refused():
    for of, message in (
        ("position", "nothing in it can move: 1 position of ground.origin"),
        ("slope_x", "ground.origin has no slope_x"),
    ):
        system, ground = lm.System(), lm.Ground()
        system.add(make_plate())
        system.add(ground)
        system.add(lm.LinearConstraint("s", (lm.Component(ground.origin, "x", of=of),)))
        with pytest.raises(DeclarationError, match=message):
            system.compile()


def test_mean_rotation_about_a_straight_edge_is_refused():
    system, plate = lm.System(), lm.Plate("plate", SIZE, (1, 1), SECTION)
    system.add(plate)
    system.add(lm.EdgeAverage("s", plate.edge("y+"), rotations="x"))
    with pytest.raises(
        DeclarationError, match=r"EdgeAverage 's': the mean rotation of edge plate\.y\+ about x, on which it lies"
    ):
        system.compile()


def test_points_that_coincide_cannot_be_held_apart():
    system, plate = lm.System(), make_plate()
    system.add(plate)
    system.add(lm.DistanceJoint("rod", plate.corner("x-y-"), plate.marker("same", 0.0, 0.0)))
    with pytest.raises(DeclarationError, match=r"DistanceJoint 'rod': plate.x-y- and plate.same coincide"):
        system.compile()
