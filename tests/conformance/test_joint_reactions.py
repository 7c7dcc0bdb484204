"""The reactions of joints between two bodies: they balance loads and inertia, are opposite on both, and do no work."""

from __future__ import annotations

import numpy as np
import pytest
from joint_pairs import PAIRS
from test_joint_pairs import Along

import lamella as lm
from lamella.assembly.equations import Equations
from lamella.dofs import DotRow
from lamella.errors import ModelError
from lamella.math.rotation import polar
from lamella.reaction_signals import reaction_signals
from lamella.roles import Declaration
from lamella.solve.initial import make_consistent
from lamella.solve.linear import linear_solver

pairs = pytest.mark.parametrize("name", PAIRS)
TIGHT = lm.Newton(tolerance=1e-11)
LOCKED = "fixed, ground and rigid"


def started(system):
    """Equations and consistent state at the start."""
    equations = Equations(system.compile())
    point = equations.start()
    make_consistent(equations, point, linear_solver(equations.matrix.pattern))
    return equations, equations.state(point)


def wanted(equations, state, body):
    """Force, and torque about the joint's centre, that a body's inertia less its loads needs; its own forces have none."""
    model, x = equations.model, state.q.reshape(-1, 3)
    own = np.array([owner == body for owner in model.owners])
    total = model.mass @ state.a + equations.forces(state.t, state.q, state.v) + equations.loads(state.t, state.q, state.v)
    f = np.where(own[:, None], total.reshape(-1, 3), 0.0)
    centre = next(support.centre.at(x) for support in model.supports if support.name == "joint")
    torque = np.cross(x - np.outer(model.is_position, centre), f).sum(axis=0)
    return f[model.is_position].sum(axis=0), torque


def frame_of_a(model, pair, q):
    """Axes of a's joint frame in a configuration: the reference axes turned as a's marker has."""
    owner = np.array(model.owners)
    if "a" not in owner:
        return pair.axes
    if model.rigid_bodies and model.rigid_bodies[0].name == "a":
        now, before = (model.rigid_bodies[0].rotation(vectors) for vectors in (q, model.q0))
    else:
        rows = model.plates[0].locate((0.8, 0.25))
        now, before = (polar(np.stack([u.at(x.reshape(-1, 3)) for u in rows.tangents], axis=1))[0] for x in (q, model.q0))
    return now @ before.T @ pair.axes


@pairs
def test_reaction_balances_both_bodies_at_the_start(name):
    equations, state = started(PAIRS[name].system())
    (support,) = equations.model.supports
    force, torque = (signal.evaluate(state) for signal in reaction_signals(support, equations)[:2])
    # rounding of one solution, whose entries are as large as 1e3 N where plates are suddenly pulled
    for body, side in (("b", 1.0), ("a", -1.0)):
        if body in equations.model.owners:
            needed = wanted(equations, state, body)
            np.testing.assert_allclose(side * force, needed[0], atol=1e-7)
            np.testing.assert_allclose(side * torque, needed[1], atol=1e-7)


@pairs
def test_constraints_do_no_work(name):
    equations, state = started(PAIRS[name].system())
    model = equations.model
    power = state.v * (model.mass @ state.a + equations.forces(0.0, state.q, state.v) + equations.loads(0.0, state.q, state.v))
    assert abs(power.sum()) < 1e-11 * np.abs(power).sum() + 1e-12  # rounding


@pairs
def test_joint_holds_and_reaction_balances_in_motion(name):
    pair = PAIRS[name]
    if name == LOCKED:
        with pytest.raises(ModelError, match="locked by its joints, nothing can move: joint"):
            lm.simulate(pair.system(), 0.01, lm.GeneralizedAlpha(dt=1e-3))
        return
    result = lm.simulate(pair.system(), 0.01, lm.GeneralizedAlpha(dt=1e-3, newton=TIGHT))
    model, state = result.model, result.final
    for block in model.constraints:
        phi = np.full(block.n_lam, np.nan)
        block.phi(state.t, state.q, phi)
        assert np.abs(phi).max() < 1e-10
    for row in model.rows:
        assert row.coefs @ state.q[row.coords] == pytest.approx(row.constant, abs=1e-12)
    needed = wanted(Equations(model), state, "b")
    force, torque = result["joint.force"].values[-1], result["joint.torque"].values[-1]
    # Newton leaves 1e-11 of displacement; a membrane stiffness of 4e7 N/m makes it 4e-4 N
    np.testing.assert_allclose(force, needed[0], atol=4e-4)
    np.testing.assert_allclose(torque, needed[1], atol=4e-4)
    if "joint.force_local" in result:
        turns = name not in ("spherical, plate and rigid", "spherical, plate and plate", "spherical, rigid plate and rigid plate")
        R = frame_of_a(model, pair, state.q) if turns else np.eye(3)  # a point of a plate gets no axes for nothing
        np.testing.assert_allclose(R @ result["joint.force_local"].values[-1], force, atol=1e-9)
        np.testing.assert_allclose(R @ result["joint.torque_local"].values[-1], torque, atol=1e-9)
    else:
        assert "hinge" in name or "weld" in name


PLACES = ((0.35, 0.0, -0.3), (0.7, 0.6, -0.1), (0.0, 0.0, 0.1), (0.3, 0.6, 0.3), (0.5, 0.1, 0.5))
NORMALS = ((1, 0.3, 0.2), (0.1, 1, -0.4), (0.5, -0.3, 1), (1, 1, 0.2), (-1, 0.6, 1))


def propped(pair):
    """A system at rest: a is fixed, and b held by as many points in planes as the joint leaves it free directions."""
    system, ground, (a, b, joint) = lm.System(), lm.Ground("earth"), pair.make()
    for item in (ground, a, b, joint, lm.Gravity("gravity", (1.0, -2.0, -9.0))):
        system.add(item)
    if bends(a):
        system.add(lm.Clamp("base", a.edge("x-")))
    elif isinstance(a, lm.Plate):
        system.add(lm.FixedJoint("base", ground.marker("foot", 0, 0, 0), a.edge("x-")))
    elif isinstance(a, lm.RigidBody):
        system.add(lm.FixedJoint("base", ground.marker("foot", *a.position), a.origin))
    alone = lm.System()
    alone.add(b)
    model = alone.compile()
    body = (*model.plates, *model.rigid_bodies)[0]
    places = [place[:2] if isinstance(b, lm.Plate) else place for place in PLACES]
    points = [body.locate(place).at(model.q0.reshape(-1, 3)) for place in places]
    far = np.argsort([-np.linalg.norm(point - pair.centre) for point in points])  # a short arm may pass through a limit point
    for k in range(len(pair.free.split())):
        marker, foot = b.marker(f"prop {k}", *places[far[k]]), ground.marker(f"foot {k}", *points[far[k]])
        system.add(lm.PointInPlaneJoint(f"prop {k} joint", foot, marker, axis=NORMALS[k]))
    return system


@pytest.mark.parametrize("name", [name for name in PAIRS if name != "weld, rigid"])
def test_reactions_balance_the_weight_at_rest(name):
    result = lm.equilibrium(propped(PAIRS[name]), newton=lm.Newton(tolerance=1e-11, keep=0.0))
    model, state, x = result.model, result.final, result.final.q.reshape(-1, 3)
    state.a[:] = 0.0
    force, torque = np.zeros(3), np.zeros(3)
    centre = next(support.centre.at(x) for support in model.supports if support.name == "joint")
    for support in model.supports:
        if support.side == "b":
            part = result[f"{support.name}.force"].values
            force += part
            torque += result[f"{support.name}.torque"].values + np.cross(support.centre.at(x) - centre, part)
    needed = wanted(Equations(model), state, "b")
    np.testing.assert_allclose(force, needed[0], atol=4e-4)  # as in motion
    np.testing.assert_allclose(torque, needed[1], atol=4e-4)
    for block in model.constraints:
        phi = np.full(block.n_lam, np.nan)
        block.phi(0.0, state.q, phi)
        assert np.abs(phi).max() < 1e-10


def bends(body):
    return isinstance(body, lm.Plate) and body.strain == "exact"


STILL = ("fixed, ground and rigid", "prismatic, ground and rigid")  # at rest, and in uniform acceleration, which is exact
SWINGING = [name for name, pair in PAIRS.items() if name not in STILL and not any(bends(body) for body in pair.make()[:2])]


@pytest.mark.parametrize("name", SWINGING)
def test_energy_is_kept_to_second_order(name):
    errors = []
    for dt in (2e-3, 1e-3):
        result = lm.simulate(PAIRS[name].system(), 0.1, lm.GeneralizedAlpha(dt=dt, rho_inf=0.9, newton=TIGHT))
        errors.append(np.abs(result["energy.balance"].values).max())
    # spins of some 3 rad/s: (omega dt)^2 = 4e-5 of an energy of 3 J
    assert errors[0] < 1e-4
    assert errors[1] < errors[0] / 3


def test_a_system_held_altogether_is_refused():
    with pytest.raises(ModelError, match="nothing can move"):
        lm.equilibrium(propped(PAIRS["weld, rigid"]))


class DrivenDistance(Declaration):
    """A drive of this test: half the square of the distance of two markers follows a function of time."""

    def __init__(self, name, a, b, motion):
        self.name, self.a, self.b, self.motion = name, a, b, motion

    def contribute(self, build):
        a, b = self.a.rows(build).point, self.b.rows(build).point
        half = 0.5 * float(np.sum((b.at(build.initial) - a.at(build.initial)) ** 2))
        row = DotRow("half the square of the distance", ((0.5, b - a, b - a),), half, self.motion)
        build.hold(self.name, [row], b, self.b.body.name)


def driven():
    """A pendulum whose end is drawn towards a point in space and let go again."""
    system = PAIRS["revolute, ground and rigid"].system()
    body = system.bodies[1]
    ground = system.bodies[0]
    motion = lm.Harmonic(amplitude=0.05, frequency=2.0)
    system.add(DrivenDistance("drive", ground.marker("winch", 1.5, 0.8, 1.0), body.marker("hook", 0.3, -0.2, 0.4), motion))
    return system


def test_derivatives_of_a_driven_joint_are_exact():
    model = driven().compile()
    for block in model.constraints:
        Along(model, block).check()


def test_work_of_a_driven_joint_is_the_change_of_energy():
    errors = []
    for dt in (2e-3, 1e-3):
        result = lm.simulate(driven(), 0.3, lm.GeneralizedAlpha(dt=dt, rho_inf=0.8, newton=TIGHT))
        work, kinetic = result["work.supports"].values, result["energy.kinetic"].values
        errors.append(np.abs(kinetic - kinetic[0] - work - result["work.loads"].values).max())
    assert np.abs(work).max() > 0.3
    assert errors[0] < 1e-2 * np.abs(work).max()  # (omega dt)^2 = 6e-4, with the start-up oscillation of the multiplier
    assert errors[1] < errors[0] / 3  # second order
