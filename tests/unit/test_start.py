"""The consistent start: what is changed in the initial state is told, contradictions and locked systems are refused."""

from __future__ import annotations

import numpy as np
import pytest
from linear_systems import system_of
from scipy.spatial.transform import Rotation

import lamella as lm
from lamella.errors import ConstraintError, ModelError
from lamella.inertia import whole_mass
from lamella.io.results import read_result
from lamella.result import Start

SECTION = lm.Laminate(lm.Isotropic(E=2e9, nu=0.3, rho=1200.0), thickness=0.02)
STEPS = lm.GeneralizedAlpha(dt=1e-3)


def arm(name, **changes):
    """A rod of 1 m along x with its middle at 0.5 m."""
    options = {"mass": 1.0, "inertia": (0.01, 0.1, 0.1), "position": (0.5, 0, 0)} | changes
    body = lm.RigidBody(name, **options)
    return body, body.marker(f"{name} in", -0.5, 0, 0), body.marker(f"{name} out", 0.5, 0, 0)


def pendulum(*more, redundant="raise", **changes):
    """An arm on a hinge at the origin, and what ``more`` makes of ground, arm and its end."""
    system, ground = lm.System(redundant=redundant), lm.Ground()
    body, start, end = arm("arm", **changes)
    system.add(ground)
    system.add(body)
    system.add(lm.RevoluteJoint("hinge", ground.marker("o", 0, 0, 0), start, axis=(0, 1, 0)))
    for make in more:
        system.add(make(ground, body, end))
    return system


def run(system, **options):
    return lm.simulate(system, 2e-3, STEPS, **options)


def test_a_consistent_start_says_nothing():
    start = run(pendulum(angular_velocity=(0, 2.0, 0), velocity=(0, 0, -1.0))).start
    assert max(start.displacement, start.turn, start.velocity, start.spin) < 1e-12
    assert start.notes == ()


def test_velocities_that_the_joints_forbid_are_changed_and_told(tmp_path):
    """An arm that hangs on a rod at its middle is thrown along the rod and across: what is along it goes."""
    system, ground = lm.System(), lm.Ground()
    body, _, _ = arm("arm", velocity=(0.3, 0, 1.0))
    for item in (ground, body, lm.DistanceJoint("rod", ground.marker("peg", 0.5, 0, 1.0), body.marker("middle", 0, 0, 0))):
        system.add(item)
    result = run(system)
    start = result.start
    assert start.velocity == pytest.approx(1.0, rel=1e-12)
    assert max(start.displacement, start.turn, start.spin) < 1e-12
    assert start.where == ("", "", "the position of rigid body 'arm'", "")
    text = "the initial velocities were changed to obey supports and joints, by up to 1 m/s (the position of rigid body 'arm')"
    assert start.notes == result.outcome.start.notes == (text,)
    assert read_result(result.save(tmp_path / "run.h5")).start == start
    assert result["arm.velocity"].values[0] == pytest.approx([0.3, 0, 0], abs=1e-12)


def craft(turn, **thrown):
    """A free body with a panel at rest fixed to it by an edge, all turned; the body is thrown and spins."""
    vector = tuple(Rotation.from_matrix(turn).as_rotvec())
    place = {"position": tuple(turn @ (0.1, -0.1, 0.0)), "rotation": vector}
    thrown = {name: tuple(turn @ v) for name, v in thrown.items()}
    hub = lm.RigidBody("hub", mass=2.0, inertia=(0.02, 0.03, 0.04), rotation=vector, **thrown)
    panel = lm.Plate("panel", (0.5, 0.2), (2, 1), SECTION, **place)
    return system_of(hub, panel, lm.FixedJoint("mount", hub.marker("rim", 0.1, 0, 0), panel.edge("x-")))


def momenta(model, q, v):
    """Momentum, and moment of momentum about the origin."""
    p = model.vectors(whole_mass(model.vector_mass, model.n_q) @ v)
    return np.sum(p[model.is_position], axis=0), np.sum(np.cross(model.vectors(q), p), axis=0)


def test_bodies_thrown_apart_from_what_is_fixed_to_them_keep_all_momentum():
    """What closes an eliminated joint is an impulse between the bodies, whichever way the system lies."""
    thrown = {"velocity": (0.3, -0.2, 0.1), "angular_velocity": (0.5, 1.0, -2.0)}
    model = craft(np.eye(3), **thrown).compile()
    begun = run(craft(np.eye(3), **thrown))
    v = begun.frame_v[0]
    for kept, given in zip(momenta(model, begun.frame_q[0], v), momenta(model, model.q0, model.v0), strict=True):
        np.testing.assert_allclose(kept, given, rtol=0, atol=1e-12)
    assert "the initial velocities were changed" in begun.start.notes[0]
    turn = Rotation.from_rotvec((0.4, -1.1, 2.0)).as_matrix()
    turned = run(craft(turn, **thrown)).frame_v[0]
    np.testing.assert_allclose(model.vectors(turned), model.vectors(v) @ turn.T, rtol=0, atol=1e-8)  # M has a condition of 1e7
    mass = whole_mass(model.vector_mass, model.n_q)
    assert v @ mass @ v < model.v0 @ mass @ model.v0


def test_positions_that_the_joints_forbid_are_changed_and_told(tmp_path):
    """A rod that is 1 mm shorter than the initial distance, sqrt 2, turns the arm about the hinge."""
    system, ground = lm.System(), lm.Ground()
    body, start, end = arm("arm")
    system.add(ground)
    system.add(body)
    system.add(lm.SphericalJoint("ball", ground.marker("o", 0, 0, 0), start))
    system.add(lm.DistanceJoint("rod", ground.marker("peg", 0, 0, 1), end, length=np.sqrt(2) - 1e-3))
    result = run(system)
    begun = result.start
    # |end - peg|^2 = 2 - 2 sin(phi) = L^2
    turn = np.arcsin(1 - 0.5 * (np.sqrt(2) - 1e-3) ** 2)
    assert begun.turn == pytest.approx(2 * np.sin(turn / 2), rel=1e-6)
    assert begun.displacement == pytest.approx(np.sin(turn / 2), rel=1e-6)
    assert begun.where[0] == "the position of rigid body 'arm'"
    assert "initial positions were changed" in begun.notes[0]
    assert " m (the position of rigid body 'arm') and " in begun.notes[0]
    stored = read_result(result.save(tmp_path / "run.h5"))
    assert stored.start == begun
    assert stored.attributes["start_displacement"] == begun.displacement


def test_changes_by_supports_whose_rows_are_eliminated_are_told():
    """A corner that begins 2 mm away from the reference, with 0.3 m/s."""
    system, plate = lm.System(), lm.Plate("plate", (0.4, 0.2), (2, 1), SECTION)
    system.add(plate)
    system.add(lm.Clamp("root", plate.edge("x-")))
    away = lm.Table(times=(0.0, 1.0), values=(2e-3, 0.302))
    system.add(lm.PrescribedMotion("pull", plate.corner("x+y+"), "z", away))
    start = run(system).start
    assert start.displacement == pytest.approx(2e-3)
    assert start.velocity == pytest.approx(0.3, rel=0.6)  # the slope of the table's first piece
    assert "r at node (2, 1)" in start.where[0]
    assert len(start.notes) == 2


def test_a_continued_run_is_compared_with_the_state_given():
    system = pendulum(lambda ground, body, end: lm.Gravity("weight"))
    first = lm.simulate(system, 0.2, lm.GeneralizedAlpha(dt=2e-3, stabilised=True))
    second = lm.simulate(system, 0.3, STEPS, t_start=0.2, initial=first.final)
    assert second.start.notes == ()


def test_statics_starts_likewise():
    system, plate, ground = lm.System(), lm.Plate("plate", (0.4, 0.2), (2, 1), SECTION), lm.Ground()
    for item in (ground, plate, lm.Clamp("root", plate.edge("x-"))):
        system.add(item)
    system.add(lm.DistanceJoint("rod", ground.marker("peg", 0.4, 0.1, 0.5), plate.marker("tip", 0.4, 0.1), length=0.498))
    result = lm.equilibrium(system)
    assert result.history("tip.position").values[0, 2] == pytest.approx(2e-3, rel=1e-3)
    assert result.start.displacement > 1.9e-3
    assert "initial positions were changed" in result.start.notes[0]
    assert result.outcome.completed


def rod_twice(second):
    """Two rods between the same points of two arms, which hang on the ground."""
    system, ground = lm.System(redundant="drop"), lm.Ground()
    system.add(ground)
    (a, a_in, a_out), (b, b_in, b_out) = arm("a"), arm("b", position=(0.5, 0, 1.0))
    for item in (a, b):
        system.add(item)
    system.add(lm.RevoluteJoint("low", ground.marker("o", 0, 0, 0), a_in, axis=(0, 1, 0)))
    system.add(lm.RevoluteJoint("high", ground.marker("p", 0, 0, 1), b_in, axis=(0, 1, 0)))
    system.add(lm.DistanceJoint("rod", a_out, b_out))
    system.add(lm.DistanceJoint("twin", a_out, b_out, length=second))
    return system


def test_rows_left_out_are_told():
    result = run(rod_twice(1.0))
    assert result.start.notes == ("left out as redundant: the distance 'twin' (follows from the distance 'rod')",)
    assert result.outcome.detail == ""


def test_rows_left_out_that_ask_for_something_else_contradict():
    with pytest.raises(ConstraintError, match=r"contradictory: .*'twin' against .*'rod' \(by .*\); remove one"):
        run(rod_twice(1.01))
    with pytest.raises(ConstraintError, match="contradictory: the distance 'twin'"):
        lm.equilibrium(rod_twice(1.01))


@pytest.mark.parametrize("speed", [0.5, 0.6])
def test_drives_of_one_joint_agree_in_speed_or_contradict(speed):
    system, ground = lm.System(redundant="drop"), lm.Ground()
    system.add(ground)
    (a, a_in, a_out), (b, b_in, _) = arm("a"), arm("b", position=(1.5, 0, 0))
    for item in (a, b):
        system.add(item)
    system.add(lm.RevoluteJoint("base", ground.marker("o", 0, 0, 0), a_in, axis=(0, 1, 0)))
    elbow = system.add(lm.RevoluteJoint("elbow", a_out, b_in, axis=(0, 1, 0)))
    for name, rate in (("motor", 0.5), ("twin", speed)):
        system.add(lm.AngleDrive(name, elbow, speed=lm.Constant(rate)))
    if speed == 0.5:
        assert run(system)["elbow.rate"].values[0] == pytest.approx(0.5)
    else:
        with pytest.raises(ConstraintError, match=r"contradictory: .*elbow.* in velocity"):
            run(system)


def test_a_singular_start_is_told_at_the_end():
    """An arm and a rod in line: to first order the rod does not hold the arm's end, and its row is left out."""
    system = pendulum(
        lambda ground, body, end: lm.DistanceJoint("rod", ground.marker("peg", 2, 0, 0), end),
        lambda ground, body, end: lm.Gravity("weight"),
        redundant="drop",
    )
    result = lm.simulate(system, 0.1, lm.GeneralizedAlpha(dt=5e-3))
    assert "left out as redundant" in result.start.notes[-1]
    assert "singular position, and violated at the end: the distance 'rod'" in result.outcome.detail


def test_a_system_locked_by_its_joints_is_refused_and_they_are_named():
    def system(drive):
        made = pendulum()
        body, start, _ = arm("b", position=(1.5, 0, 0))
        made.add(body)
        upper = made.declarations[1]
        made.add(lm.FixedJoint("weld", upper.marker("arm out", 0.5, 0, 0), start))
        made.add(drive(made.declarations[2]))
        return made

    with pytest.raises(ModelError, match=r"locked by its joints, nothing can move: .*hinge.*weld.*rod.*; leave something free"):
        run(
            system(lambda hinge: lm.DistanceJoint("rod", lm.Ground().marker("peg", 0.5, 0, 1), hinge.b.body.marker("m", 0, 0, 0)))
        )
    result = run(system(lambda hinge: lm.AngleDrive("motor", hinge, speed=lm.Constant(0.5))))  # driven, so it moves
    assert result["hinge.angle"].values[-1] == pytest.approx(1e-3)


def test_a_file_without_the_attributes_reads_as_an_unchanged_start():
    from lamella.io.result_layout import read_start

    assert read_start({}) == Start()
