"""Equilibrium and equilibrium paths: load steps, limit points against a closed form, both sides of a buckled strip, messages."""

from __future__ import annotations

import numpy as np
import pytest

import lamella as lm
from lamella.errors import ConvergenceError, DeclarationError, ModelError
from lamella.result import Cause

SECTION = lm.Laminate(lm.Isotropic(E=2e9, nu=0.3, rho=1200.0), thickness=0.02)
E, H, L, B, RISE = 1e7, 0.05, 1.0, 0.2, 0.05
LIMIT = E * H * B * RISE**3 / (3 * np.sqrt(3) * L**3)


def truss(load):
    """Half of a shallow von Mises truss: an inclined strip, hinged below, guided vertically above, pressed down.

    Its rise equals its thickness, so it does not buckle by itself: straight, with Green's strain
    (z^2 - rise^2) / 2 L^2, it carries

        V(z) = E A z (rise^2 - z^2) / (2 L^3)
    """
    section = lm.Laminate(lm.Isotropic(E=E, nu=0.0, rho=1000.0), thickness=H)
    system, plate = lm.System(), lm.Plate("strip", (L, B), (2, 1), section, rotation=(0.0, -np.arcsin(RISE / L), 0.0))
    system.add(plate)
    plate.marker("top", L, 0.5 * B)
    system.add(lm.EdgeSupport("foot", plate.edge("x-")))
    system.add(lm.EdgeSupport("guide", plate.edge("x+"), axes="xy"))
    system.add(lm.EdgeForce("push", plate.edge("x+"), (0.0, 0.0, -load / B)))
    return system


def carried(z):
    return E * H * B * z * (RISE**2 - z**2) / (2 * L**3)


@pytest.mark.parametrize(
    ("follower", "moved", "spared"), [(False, 0.0, 1), (True, 0.0, 0), (False, 0.01, 0)], ids=["dead", "follower", "moved"]
)
def test_the_stiffness_at_the_start_serves_the_first_iteration_unless_the_load_factor_changes_it(follower, moved, spared):
    system, plate = lm.System(), lm.Plate("plate", (1.0, 0.3), (3, 1), SECTION)
    system.add(plate)
    system.add(lm.Clamp("root", plate.edge("x-")))
    system.add(lm.PointForce("load", plate.corner("x+y+"), (0, 0, -20.0), follower=follower))
    if moved:
        system.add(lm.PrescribedMotion("push", plate.corner("x+y-"), axis="z", displacement=lm.Constant(moved)))
    found = lm.equilibrium(system).statistics
    assert found.steps == 1
    assert found.tangents == found.factorisations == found.newton_iterations + 2 - spared  # two judge stability, at both ends


@pytest.mark.parametrize("arc", [None, lm.ArcLength(psi=1e-3), lm.ArcLength(first=0.02, largest=0.005)], ids=repr)
def test_arc_length_passes_both_limit_points(arc):
    load = 2.0 * LIMIT
    path = lm.equilibrium_path(truss(load), arc=arc)
    z, V = path["top.position"].values[:, 2], load * path["load_factor"].values
    # Newton leaves 1e-8 of the length; the axial stiffness E A / L = 1e5 N/m, inclined by 1/20 twice, makes it 3e-6 N of 2.4 N
    np.testing.assert_allclose(V, carried(z), atol=1e-5 * LIMIT)
    assert V[-1] == pytest.approx(load)
    assert z[-1] < -RISE  # it has snapped through
    turns = np.flatnonzero(np.diff(np.sign(np.diff(V))))
    assert len(turns) == 2
    assert V.max() == pytest.approx(load)
    assert 0.8 * LIMIT < V[turns[0] + 1] <= LIMIT * (1 + 1e-5)  # the point of the path that is nearest to the maximum
    assert -LIMIT * (1 + 1e-5) <= V[turns[1] + 1] < -0.5 * LIMIT


def test_load_control_stops_at_the_limit_point_and_says_so():
    load = 1.05 * LIMIT
    with pytest.raises(ConvergenceError, match=r"stopped at 0\.95.* of 1: .*load step .*equilibrium_path") as caught:
        lm.equilibrium(truss(load), steps=20)
    assert caught.value.outcome.reached * load == pytest.approx(LIMIT, rel=1e-3)
    assert caught.value.outcome.reached * load <= LIMIT * (1 + 1e-6)
    assert caught.value.result["top.position"].values[2] == pytest.approx(RISE / np.sqrt(3), rel=0.05)


def test_partial_result_can_be_returned():
    result = lm.equilibrium(truss(1.05 * LIMIT), steps=20, on_failure="return")
    assert not result.outcome.completed
    assert result.at[-1] == result.outcome.reached < 1.0


def test_displacement_control_gives_the_same_curve():
    """The driving force of a prescribed descent is the load of the same equilibrium, beyond the limit point too."""
    system = truss(0.0)
    plate = system.bodies[0]
    for k, corner in enumerate(("x+y-", "x+y+")):
        system.add(lm.PrescribedMotion(f"drive {k}", plate.corner(corner), "z", lm.Constant(-2.2 * RISE)))
    result = lm.equilibrium(system, steps=11)
    z = result.history("top.position").values[:, 2]
    force = sum(result.history(f"drive {k}.force").values[:, 2] for k in range(2))
    # driven at its corners, the edge bows a little between them: 0.1 % of the stiffness
    np.testing.assert_allclose(-force, carried(z), atol=2e-3 * LIMIT)
    assert z[-1] == pytest.approx(-1.2 * RISE, rel=2e-3)


def test_path_gives_up_with_its_step_limit():
    with pytest.raises(ConvergenceError, match="largest number of steps") as caught:
        lm.equilibrium_path(truss(2.0 * LIMIT), arc=lm.ArcLength(max_steps=3))
    assert caught.value.outcome.cause is Cause.STEP_LIMIT
    assert len(caught.value.result.at) == 4  # the start and three steps


def buckled(side, shortening=2e-3):
    """A strip clamped at both ends, shortened far beyond its critical strain (pi h)^2 / 3 L^2 = 3.3e-4, led to one side."""
    section = lm.Laminate(lm.Isotropic(E=2e9, nu=0.3, rho=1200.0), thickness=0.01)
    system, plate = lm.System(), lm.Plate("strip", (1.0, 0.1), (6, 1), section)
    system.add(plate)
    middle = plate.marker("middle", 0.5, 0.05)
    system.add(lm.Clamp("left", plate.edge("x-")))
    system.add(lm.Clamp("right", plate.edge("x+"), motion={"x": lm.Constant(-shortening)}))
    system.add(lm.PointForce("lead", middle, (0.0, 0.0, 5.0 * side)))
    return system


@pytest.fixture(scope="module")
def both_sides():
    return [lm.equilibrium(buckled(side), steps=20) for side in (1, -1)]


def test_buckled_strip_has_two_mirrored_shapes(both_sides):
    up, down = (result.final.q.reshape(-1, 3) for result in both_sides)
    np.testing.assert_allclose(up * np.array((1, 1, -1)), down, atol=1e-8)
    # inextensible half wave: w(x) = A (1 - cos 2 pi x) / 2 shortens by (pi A)^2 / 4 L, less the compression that remains;
    # the force that leads it to its side adds 0.3 %
    expected = 2 / np.pi * np.sqrt(2e-3 - (np.pi * 0.01) ** 2 / 3)
    assert both_sides[0]["middle.position"].values[2] == pytest.approx(expected, rel=0.02)


def test_both_shapes_are_stable_and_vibrate_alike(both_sides):
    up, down = (lm.modes(result.model, 3, state=result.final).frequencies for result in both_sides)
    assert up.min() > 0
    np.testing.assert_allclose(up, down, rtol=1e-6)


def test_result_does_not_depend_on_the_steps():
    ends = [lm.equilibrium(truss(0.9 * LIMIT), steps=steps)["top.position"].values for steps in (1, 7, [0.3, 0.31, 1.0])]
    np.testing.assert_allclose(ends[1:], [ends[0]] * 2, atol=1e-8)


def test_every_load_factor_asked_for_is_met():
    result = lm.equilibrium(truss(0.9 * LIMIT), steps=[0.25, 0.4, 1.0])
    for factor in (0.0, 0.25, 0.4, 1.0):
        assert factor in result.at
    z = result.history("top.position").sel(load_factor=0.4).values[2]
    assert carried(z) == pytest.approx(0.4 * 0.9 * LIMIT, rel=1e-5)


def test_a_step_that_is_too_long_is_cut():
    """A wide flat sheet under a load that bends it by half its length, in one step asked for."""
    system, plate = lm.System(), lm.Plate("plate", (1.0, 1.0), (3, 3), SECTION)
    system.add(plate)
    system.add(lm.Clamp("root", plate.edge("x-")))
    system.add(lm.PointForce("load", plate.marker("tip", 1.0, 0.5), (0, 0, -3000.0)))
    cut = lm.equilibrium(system, newton=lm.Newton(max_iterations=5, keep=0.0))
    assert cut.statistics.rejected >= 1
    fine = lm.equilibrium(system, steps=10)
    np.testing.assert_allclose(cut["tip.position"], fine["tip.position"], atol=1e-7)


def test_nothing_that_holds_is_refused_before_anything_is_solved():
    system = lm.System()
    system.add(lm.Plate("plate", (1.0, 1.0), (1, 1), SECTION))
    for solve in (lm.equilibrium, lm.equilibrium_path):
        with pytest.raises(ModelError, match=r"nothing holds the system; add at least one support, for example Clamp"):
            solve(system)


def test_too_few_supports_name_what_is_free():
    system, plate = lm.System(), lm.Plate("plate", (1.0, 1.0), (1, 1), SECTION)
    system.add(plate)
    system.add(lm.PointSupport("pin", plate.corner("x-y-")))
    system.add(lm.Gravity("weight"))
    with pytest.raises(ConvergenceError, match=r"singular.*nothing holds .*plate.*add a support") as caught:
        lm.equilibrium(system)
    assert caught.value.outcome.cause is Cause.SINGULAR
    assert caught.value.outcome.reached == 0.0


@pytest.mark.parametrize("steps", [0, -3, [], [0.5, 0.4], [0.0, 1.0], [0.5, float("nan")], [-0.5, 1.0]])
def test_impossible_steps_are_refused(steps):
    with pytest.raises(DeclarationError, match=r"equilibrium: steps = .*accepted is a positive number of steps"):
        lm.equilibrium(truss(1.0), steps=steps)


def test_support_work_and_load_work_make_the_strain_energy():
    result = lm.equilibrium(truss(0.9 * LIMIT), steps=200)
    work, strain = float(result["work.loads"]), float(result["energy.strain"])
    # the trapezoidal rule over 200 steps of a path whose slope grows towards the limit point
    assert work == pytest.approx(strain, rel=1e-3)
    system = truss(0.0)
    plate = system.bodies[0]
    for k, corner in enumerate(("x+y-", "x+y+")):
        system.add(lm.PrescribedMotion(f"drive {k}", plate.corner(corner), "z", lm.Constant(-RISE)))
    result = lm.equilibrium(system, steps=200)
    z = 0.0
    expected = E * H * B / (8 * L**3) * (RISE**2 - z**2) ** 2
    assert float(result["energy.strain"]) == pytest.approx(expected, rel=1e-3)  # the edge bows between its driven corners
    assert float(result["work.supports"]) == pytest.approx(float(result["energy.strain"]), rel=1e-4)


def test_interruption_keeps_the_steps_solved():
    class Stop:
        closed = ()

        def sample(self, at, values):
            if at >= 0.5:
                raise KeyboardInterrupt

        def frame(self, at, state):
            pass

        def close(self, outcome, statistics):
            self.closed += (outcome,)

    sink = Stop()
    result = lm.equilibrium(truss(0.9 * LIMIT), steps=10, sinks=[sink], on_failure="return")
    assert result.outcome.cause is Cause.INTERRUPTED
    assert 0.4 <= result.outcome.reached <= 0.5
    assert len(sink.closed) == 1


def test_a_path_begins_at_the_equilibrium_of_a_prestrained_plate():
    """Its start is none; the path then ends where load steps do."""
    section = lm.Laminate(lm.Isotropic(E=70e9, nu=0.3, rho=2700), thickness=2e-3)
    system = lm.System()
    plate = system.add(lm.Plate("plate", (0.5, 0.1), (3, 1), section, prestrain=(1e-3, 0, 0)))
    tip = plate.marker("tip", 0.5, 0.05)
    system.add(lm.Clamp("root", plate.edge("x-"), kind="restrained"))
    system.add(lm.PointForce("load", tip, (0, 0, 2.0)))
    path, still = lm.equilibrium_path(system), lm.equilibrium(system)
    assert path["tip.position"].values[0, 0] == pytest.approx(0.5 * (1 - 1e-3), rel=2e-5)
    np.testing.assert_allclose(path["tip.position"].values[-1], still["tip.position"].values, atol=1e-6)


def test_a_path_without_loads_is_refused():
    system = lm.System()
    plate = system.add(lm.Plate("strip", (1.0, 0.1), (2, 1), lm.Laminate(lm.Isotropic(2e9, 0.3, 1200), thickness=1e-3)))
    system.add(lm.Clamp("root", plate.edge("x-")))
    with pytest.raises(ModelError, match=r"equilibrium_path: nothing deforms as the load factor grows; accepted are loads or"):
        lm.equilibrium_path(system)
    assert lm.equilibrium(system).outcome.completed
