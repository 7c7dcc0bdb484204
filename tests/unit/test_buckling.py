"""Linear buckling, critical points, branches, imperfections and displacement control: signs, constraints, files and messages."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.sparse.linalg import ArpackNoConvergence

import lamella as lm
from lamella.errors import ConvergenceError, DeclarationError, ModelError
from lamella.io.modes import read_modes, write_modes
from lamella.solve import critical_search
from lamella.verification.hinged_roofs.case import roof

E, H, L, B = 70e9, 1e-3, 0.4, 0.02
EULER = np.pi**2 * E * B * H**3 / 12 / (4 * L**2)
SECTION = lm.Laminate(lm.Isotropic(E=E, nu=0.0, rho=2700.0), thickness=H)


def column(force=-1.0, mesh=8, **changes):
    """A strip clamped at x = 0 under an axial force [N] at its end."""
    system, plate = lm.System(), lm.Plate("strip", (L, B), (mesh, 1), SECTION, **changes)
    system.add(plate)
    tip = plate.marker("tip", L, B / 2)
    system.add(lm.Clamp("root", plate.edge("x-")))
    system.add(lm.EdgeForce("push", plate.edge("x+"), (force / B, 0.0, 0.0)))
    return system, tip


def test_factors_do_not_depend_on_the_size_of_the_load():
    found = [load * lm.buckling(column(-load)[0], 2).factors for load in (1e-3, 1.0, 1e3)]
    np.testing.assert_allclose(found, [found[1]] * 3, rtol=1e-8)  # differenced over a fixed displacement, whatever the load


def test_pulling_gives_negative_factors():
    found = lm.buckling(column(+1.0)[0], 2).factors
    np.testing.assert_allclose(found, -lm.buckling(column(-1.0)[0], 2).factors, rtol=1e-8)


def test_factor_about_a_loaded_state_is_that_of_the_whole_load():
    system, _ = column(-EULER)
    state = lm.equilibrium(system, steps=[0.7]).final
    # the stiffness is linear in the load up to the shortening of 1e-6
    assert lm.buckling(system, 1, state=state).factors[0] == pytest.approx(lm.buckling(system, 1).factors[0], rel=1e-5)


def test_a_support_that_moves_buckles_the_column_at_the_same_force():
    system, plate = lm.System(), lm.Plate("strip", (L, B), (8, 1), SECTION)
    system.add(plate)
    system.add(lm.Clamp("left", plate.edge("x-"), kind="restrained"))
    system.add(lm.Clamp("right", plate.edge("x+"), kind="restrained", motion={"x": lm.Constant(-1e-6)}))
    strain = lm.buckling(system, 1).factors[0] * 1e-6 / L
    # eight cubics for a full wave: (2 pi / 8)^4 / 720 = 5e-4
    assert strain == pytest.approx(4 * (np.pi * H / L) ** 2 / 12, rel=1e-3)


@pytest.mark.parametrize("n", [0, -1, 10_000])
def test_impossible_number_of_shapes_is_refused(n):
    with pytest.raises(DeclarationError, match=r"buckling: n = .*accepted is 1 to"):
        lm.buckling(column()[0], n)


def test_what_cannot_buckle_is_refused():
    with pytest.raises(ModelError, match="no load changes the stiffness"):
        lm.buckling(column(strain="linear")[0])
    with pytest.raises(ModelError, match="the loads deform nothing"):
        lm.buckling(column(0.0)[0])
    free = lm.System()
    free.add(lm.Plate("plate", (L, B), (2, 1), SECTION))
    with pytest.raises(ModelError, match="nothing holds the system"):
        lm.buckling(free)


def test_shapes_are_stored_and_read(tmp_path):
    found = lm.buckling(column()[0], 2)
    stored = read_modes(write_modes(found, tmp_path / "modes.h5"))
    assert isinstance(stored, lm.Buckling)
    np.testing.assert_array_equal(stored.factors, found.factors)
    np.testing.assert_array_equal(stored.shapes, found.shapes)


@pytest.fixture(scope="module")
def straight():
    return lm.equilibrium_path(column()[0], until=1.5 * EULER)


def test_load_steps_and_path_find_the_same_bifurcation(straight):
    steps = lm.equilibrium(column()[0], steps=[1.5 * EULER])
    for result in (straight, steps):
        (point,) = result.critical_points
        assert point.kind == "bifurcation"
        assert point.negative == (0, 1)
        assert point.factor == pytest.approx(EULER, rel=5e-6)  # shortening before buckling 1.3e-6, step located to 1e-6
    assert 0 < straight.critical_points[0].at < len(straight.at) - 1
    assert steps.critical_points[0].at == steps.critical_points[0].factor


def test_shape_of_the_bifurcation_is_the_column_s_mode(straight):
    """w = 1 - cos(pi x / 2L), slopes and twists too, whatever the length is to 1 m."""
    point, plate = straight.critical_points[0], straight.model.plates[0]
    shape = point.shape.reshape(-1, 3)[:, 2]
    for i in range(plate.nx + 1):
        x = np.pi / 2 * i / plate.nx
        w, slope, twist = (shape[plate.vector(plate.node(i, 0), name)] for name in ("r", "r_x", "r_xy"))
        assert w == pytest.approx(1 - np.cos(x), abs=1e-5)  # eight cubics: 5e-6
        assert slope == pytest.approx(np.pi / 2 / L * np.sin(x), abs=1e-4 / L)
        assert abs(twist) < 1e-6 / L


def test_a_jump_over_several_bifurcations_finds_each():
    found = lm.equilibrium(column()[0], steps=[30 * EULER]).critical_points
    assert [point.negative for point in found] == [(0, 1), (1, 2), (2, 3)]
    np.testing.assert_allclose([point.factor / EULER for point in found], [1, 9, 25], rtol=1e-3)


@pytest.mark.parametrize("found", [6, 4, 0])
def test_eigenvalues_that_the_iteration_does_not_find_stop_no_solution(found, monkeypatch):
    """Prestrain has six negative eigenvalues before the first step, two of them too far from zero: those of a small model are
    found from the whole inverse, of others what the iteration has found is told."""
    if found < 6:

        def gives_up(operator, count, **how):
            raise ArpackNoConvergence("too far", np.full(found, -1.0), np.ones((operator.shape[0], found)))

        monkeypatch.setattr(critical_search.linalg, "eigsh", gives_up)
        monkeypatch.setattr(critical_search, "AFTER_ALL", 0)
    laminate = lm.Laminate(lm.Isotropic(E=70e9, nu=0.3, rho=2700), thickness=2e-3, offset=1e-3)
    system = lm.System()
    plate = system.add(lm.Plate("plate", (0.5, 0.1), (3, 1), laminate, prestrain=(-2e-3, 1e-3, 0.0)))
    system.add(lm.Clamp("root", plate.edge("x-"), kind="restrained"))
    system.add(lm.PointForce("pull", plate.marker("tip", 0.5, 0.05), (0.0, 0.0, 2.0)))
    result = lm.equilibrium(system)
    assert result.outcome.completed
    assert len(result.critical_points) == found


def test_branches_leave_to_either_side(straight):
    point = straight.critical_points[0]
    tips = [
        lm.equilibrium_path(straight.model, until=1.2 * EULER, branch=point.branch(side * 0.01))["tip.position"].values
        for side in (1, -1)
    ]
    np.testing.assert_allclose(tips[0][-1] * (1, 1, -1), tips[1][-1], atol=1e-8)
    assert abs(tips[0][-1, 2]) > 0.5 * L
    assert tips[0][0, 2] == pytest.approx(0.0, abs=1e-9)


def test_imperfection_is_free_of_stress_and_leads_to_the_branch(straight):
    point = straight.critical_points[0]
    system, _ = column()
    path = lm.equilibrium_path(system, until=1.2 * EULER, imperfection=point.imperfection(1e-5))
    assert path["tip.position"].values[0, 2] == pytest.approx(1e-5, rel=1e-9)
    assert float(path["energy.strain"][0]) < 1e-20
    branch = lm.equilibrium_path(straight.model, until=1.2 * EULER, branch=point.branch(0.01))
    # the imperfection of 1e-5 m moves the tip by its size over the slope of the branch
    np.testing.assert_allclose(np.abs(path["tip.position"].values[-1]), np.abs(branch["tip.position"].values[-1]), atol=1e-4)
    assert not path.critical_points


def test_critical_points_and_imperfection_are_stored(tmp_path, straight):
    stored = lm.read_result(straight.save(tmp_path / "run.h5")).critical_points[0]
    point = straight.critical_points[0]
    assert (stored.factor, stored.at, stored.kind, stored.negative) == (point.factor, point.at, point.kind, point.negative)
    np.testing.assert_array_equal(stored.shape, point.shape)
    np.testing.assert_array_equal(stored.state.q, point.state.q)
    bent = lm.equilibrium(column()[0], steps=[0.1 * EULER], imperfection=point.imperfection(1e-3))
    again = lm.read_result(bent.save(tmp_path / "bent.h5"))
    np.testing.assert_array_equal(again.model.q0, bent.model.q0)


def test_imperfections_that_do_not_fit_are_refused(straight):
    system, _ = column()
    with pytest.raises(DeclarationError, match=r"an imperfection of shape \(3,\); accepted are \d+ finite numbers"):
        lm.equilibrium(system, imperfection=np.zeros(3))
    system.add(lm.RigidBody("block", mass=1.0, inertia=(1.0, 1.0, 1.0)))
    with pytest.raises(DeclarationError, match="moves the rigid body 'block'"):
        lm.equilibrium_path(system, imperfection=np.ones(len(straight.model.q0) + 12))


def test_arguments_that_exclude_each_other_are_refused(straight):
    system, tip = column()
    control = lm.DisplacementControl(tip, "z", 0.1)
    with pytest.raises(DeclarationError, match="control and until"):
        lm.equilibrium_path(system, until=1.0, control=control)
    with pytest.raises(DeclarationError, match="control and arc"):
        lm.equilibrium_path(system, arc=lm.ArcLength(), control=control)
    with pytest.raises(DeclarationError, match="a branch of amplitude 0"):
        lm.equilibrium_path(system, branch=straight.critical_points[0].branch(0.0))
    with pytest.raises(DeclarationError, match="a point of another system"):
        lm.equilibrium_path(column(mesh=4)[0], branch=straight.critical_points[0].branch(0.01))
    with pytest.raises(DeclarationError, match=r"equilibrium: times = \[1.0\].*at least two ascending"):
        lm.equilibrium(system, times=[1.0])


def test_impossible_displacement_control_is_refused():
    system, tip = column()
    with pytest.raises(DeclarationError, match="to = 0 m"):
        lm.DisplacementControl(tip, "z", 0.0)
    root = system.bodies[0].marker("foot", 0.0, B / 2)
    with pytest.raises(DeclarationError, match=r"the supports hold z of 'strip.foot'"):
        lm.equilibrium_path(system, control=lm.DisplacementControl(root, "z", 0.1))
    other = lm.Plate("other", (1.0, 1.0), (1, 1), SECTION).marker("m", 0.5, 0.5)
    with pytest.raises(DeclarationError, match="is on no body of the system"):
        lm.equilibrium_path(system, control=lm.DisplacementControl(other, "z", 0.1))


def test_preload_then_push():
    """Pulled first, pushed sideways then: the stiffness of a stretched cantilever, tanh(x) / x of the tension's."""
    push = lm.Table((0.0, 1.0, 2.0), (0.0, 0.0, 1.0))
    system = lm.System()
    plate = system.add(lm.Plate("strip", (L, B), (8, 1), SECTION))
    plate.marker("tip", L, B / 2)
    system.add(lm.Clamp("root", plate.edge("x-")))
    pull, side = 20.0, 1e-4
    ramp = lm.Table((0.0, 1.0, 2.0), (0.0, 1.0, 1.0))
    system.add(lm.EdgeForce("pull", plate.edge("x+"), (pull / B, 0.0, 0.0), profile=ramp))
    system.add(lm.EdgeForce("side", plate.edge("x+"), (0.0, 0.0, side / B), profile=push))
    result = lm.equilibrium(system, times=[0.0, 1.0, 2.0])
    assert result.axis == "time"
    w = result["tip.position"].values[:, 2]
    k = np.sqrt(pull / (E * B * H**3 / 12))
    expected = side / pull * (L - np.tanh(k * L) / k)
    assert abs(w[1]) < 1e-12
    # eight cubics resolve the layer of width 1 / k = L / 7 to 1e-4, and the stretch of 1.4e-5
    assert w[2] == pytest.approx(expected, rel=5e-4)


def arch(metre=1.0):
    """A clamped shallow strip is bent to an arch by its imperfection and pressed at its crown; lengths in another unit."""
    section = lm.Laminate(lm.Isotropic(1e9 / metre**2, 0.0, 1000.0 / metre**3), thickness=4e-3 * metre)
    system, plate = lm.System(), lm.Plate("strip", (metre, 0.1 * metre), (8, 1), section)
    system.add(plate)
    crown = plate.marker("crown", 0.5 * metre, 0.05 * metre)
    system.add(lm.EdgeSupport("left", plate.edge("x-")))
    system.add(lm.EdgeSupport("right", plate.edge("x+")))
    system.add(lm.PointForce("press", crown, (0.0, 0.0, -1.0)))
    return system, crown


PRECISE = lm.Newton(tolerance=1e-12, keep=0.0)


def bent(rise):
    """The arch, its crown, and an imperfection that raises it by ``rise`` [m]."""
    system, crown = arch()
    shape = lm.modes(system, 1).imperfection(0, 1.0)
    return system, crown, rise * np.sign(shape.reshape(-1, 3)[:, 2].sum()) * shape


def test_displacement_control_passes_limit_points_as_the_arc_length_does():
    """A shallow arch: it may leave to a side before each of its two limit points."""
    system, crown, rise = bent(0.006)
    control = lm.DisplacementControl(crown, "z", -0.0135, steps=15)
    pushed = lm.equilibrium_path(system, control=control, imperfection=rise, newton=PRECISE)
    along = lm.equilibrium_path(system, until=1.0, imperfection=rise, newton=PRECISE)
    z = pushed["crown.position"].values[:, 2]
    assert z[-1] - z[0] == pytest.approx(-0.0135, abs=1e-9)
    kinds = ["bifurcation", "limit point", "limit point", "bifurcation"]
    for path in (pushed, along):
        assert [point.kind for point in path.critical_points] == kinds
        assert [point.negative for point in path.critical_points] == [(0, 1), (1, 2), (2, 1), (1, 0)]
    found = [[point.factor for point in path.critical_points] for path in (pushed, along)]
    np.testing.assert_allclose(
        *found, rtol=2e-5
    )  # bifurcations are located to 1e-6 of a step, over which the load changes by 0.6


def test_kinds_of_critical_points_do_not_depend_on_the_unit_of_length():
    """Lengths in micrometres, millimetres and kilometres: the load does as much work on the null vector."""
    for metre in (1e6, 1e3, 1e-3):
        system, _ = arch(metre)
        shape = lm.modes(system, 1).imperfection(0, 1.0)
        rise = 0.006 * metre * np.sign(shape.reshape(-1, 3)[:, 2].sum()) * shape
        points = lm.equilibrium_path(system, until=1.0, imperfection=rise).critical_points
        assert [point.kind for point in points] == ["bifurcation", "limit point", "limit point", "bifurcation"]


def test_snap_back_ends_displacement_control_with_a_hint_and_keeps_what_was_found():
    """A higher arch: its crown turns back, which the arc length shows."""
    system, crown, rise = bent(0.02)
    with pytest.raises(ConvergenceError, match=r"0\.045 m along z at 'strip.crown'.*snap-back.*arc length") as caught:
        lm.equilibrium_path(system, control=lm.DisplacementControl(crown, "z", -0.045, steps=15), imperfection=rise)
    reached = caught.value.result["crown.position"].values[:, 2]
    along = lm.equilibrium_path(system, until=3.8, imperfection=rise)["crown.position"].values[:, 2]
    assert len(reached) > 10
    assert reached.min() == pytest.approx(along.min(), abs=2e-3)  # points of the arc length miss the turn by a share of a step
    assert along[-1] > along.min() + 0.01


def test_a_step_onto_another_path_is_taken_back():
    """Beside the bifurcation a long step of the arc length lands on the upper, disconnected path of an imperfect roof."""
    system, _ = roof(6.35, "[0/90/0]", 8)
    bifurcation = lm.equilibrium_path(system, until=0.22, arc=lm.ArcLength(first=0.1, largest=0.003)).critical_points[0]
    assert bifurcation.kind == "bifurcation"
    crooked = bifurcation.imperfection(1e-3 * 6.35e-3)
    long, short = (
        lm.equilibrium_path(system, until=0.9, imperfection=crooked, arc=lm.ArcLength(first=0.1, largest=largest))
        for largest in (0.004, 0.0016)
    )
    assert long.statistics.rejected > 0
    assert long.critical_points[0].factor == pytest.approx(short.critical_points[0].factor, rel=1e-3)
