"""A half and a quarter with symmetry planes move as the whole does; supports in oblique axes are those of a turned system."""

from __future__ import annotations

import numpy as np
import pytest

import lamella as lm
from lamella.math.rotation import matrix_from_vector

SECTION = lm.Laminate(lm.Isotropic(E=2e9, nu=0.3, rho=1200.0), thickness=0.01)
SIZE, MESH = (1.2, 0.8), (4, 4)
TURN, SLANT = (0.1, -0.3, 0.7), (0.7, 0.0, 0.0)
R = matrix_from_vector(np.array(SLANT))
TIGHT = lm.Newton(tolerance=1e-12, keep=0.0)


def cut_system(parts, element="plate48"):
    """The piece of a plate with a clamped edge on both sides that are drawn apart, under a load and weight; 1/parts of it."""
    system = lm.System()
    size = (SIZE[0] / (2 if parts >= 2 else 1), SIZE[1] / (2 if parts == 4 else 1))
    mesh = (MESH[0] // (2 if parts >= 2 else 1), MESH[1] // (2 if parts == 4 else 1))
    plate = lm.Plate("plate", size, mesh, SECTION, rotation=SLANT, element=element)
    system.add(plate)
    for side, outwards in (("x-", -0.001), ("x+", 0.001))[: 1 if parts >= 2 else 2]:
        system.add(lm.Clamp(f"clamp {side}", plate.edge(side), {"x": lm.SmoothStep(t_end=0.01, end=outwards)}, "restrained"))
    if parts >= 2:
        system.add(lm.Symmetry("middle", plate.edge("x+"), tuple(R[:, 0])))
    if parts == 4:
        system.add(lm.Symmetry("axis", plate.edge("y+"), tuple(-3 * R[:, 1])))
    system.add(lm.SurfaceForce("load", plate, tuple(-5e4 * R[:, 2])))
    system.add(lm.Gravity("weight", tuple(-9.81 * R[:, 2])))
    return system


def piece(result, mesh):
    """The nodal vectors of the first nodes, shape (mesh_y + 1, mesh_x + 1, vectors, 3)."""
    plate = result.model.plates[0]
    x = result.final.q.reshape(plate.ny + 1, plate.nx + 1, plate.element.vectors_per_node, 3)
    return x[: mesh[1] + 1, : mesh[0] + 1]


@pytest.mark.parametrize("element", ["plate48", "plate36"])
def test_half_and_quarter_are_parts_of_the_whole_under_large_deflection(element):
    results = {parts: lm.equilibrium(cut_system(parts, element), t=0.02, steps=(0.3, 1.0), newton=TIGHT) for parts in (1, 2, 4)}
    whole = piece(results[1], (2, 2))
    sag = np.ptp(whole[..., 0, :] @ R[:, 2])
    assert sag > 5 * 0.01  # several thicknesses
    for parts in (2, 4):
        np.testing.assert_allclose(
            piece(results[parts], (2, 2)), whole, atol=1e-9
        )  # Newton's 1e-12, through a stiffness of 1e7 N/m
    force = {parts: results[parts].history("clamp x-.force").values[-1] for parts in results}
    np.testing.assert_allclose(force[2], force[1], atol=1e-3)
    # the quarter's clamp carries half of it but for what passes across the other plane, along its normal
    halved = force[1] - force[1] @ R[:, 1] * R[:, 1]
    mine = force[4] - force[4] @ R[:, 1] * R[:, 1]
    np.testing.assert_allclose(mine, halved / 2, atol=1e-3)
    # the middle carries no shear; its force is the tension of the membrane and balances the clamp's along the plate
    middle = results[2].history("middle.force").values[-1]
    np.testing.assert_allclose(middle, -(force[2] @ R[:, 0]) * R[:, 0], atol=1e-3)
    assert abs(middle @ R[:, 0]) > 1e3


def test_half_moves_as_the_whole():
    results = {parts: lm.simulate(cut_system(parts), 0.02, lm.GeneralizedAlpha(dt=1e-3, newton=TIGHT)) for parts in (1, 4)}
    np.testing.assert_allclose(piece(results[4], (2, 2)), piece(results[1], (2, 2)), atol=1e-8)


def test_frequencies_of_the_quarter_are_those_of_the_symmetric_modes():
    def frequencies(parts, count):
        system = lm.System()
        plate = lm.Plate("plate", tuple(np.array(SIZE) / parts), tuple(np.array(MESH) // parts), SECTION)
        system.add(plate)
        for side in ("x-", "y-") if parts == 2 else ("x-", "x+", "y-", "y+"):
            system.add(lm.EdgeSupport(f"support {side}", plate.edge(side)))
        if parts == 2:
            system.add(lm.Symmetry("first", plate.edge("x+"), "x"))
            system.add(lm.Symmetry("second", plate.edge("y+"), "y"))
        return lm.modes(system, count).frequencies

    whole, quarter = frequencies(1, 12), frequencies(2, 3)
    for f in quarter:
        assert np.abs(whole / f - 1).min() < 1e-8


def test_a_half_of_elements_without_twist_is_part_of_the_whole():
    """Bent and stretched far: the mirror image of Plate36 is one as well."""
    tips = {}
    for half in (False, True):
        system, size = lm.System(), (SIZE[0], SIZE[1] / (1 + half))
        plate = lm.Plate("plate", size, (4, 4 // (1 + half)), SECTION, element="plate36")
        system.add(plate)
        plate.marker("tip", SIZE[0], SIZE[1] / 2)
        system.add(lm.EdgeSupport("root", plate.edge("x-")))
        system.add(lm.EdgeSupport("end", plate.edge("x+"), "yz"))
        system.add(lm.SurfaceForce("load", plate, (1e4, 0.0, -2e4)))
        if half:
            system.add(lm.Symmetry("middle", plate.edge("y+"), "y"))
        tips[half] = lm.equilibrium(system, newton=TIGHT)["tip.position"].values
    np.testing.assert_allclose(tips[True], tips[False], atol=1e-10)  # Newton's 1e-12
    assert abs(tips[True][0] - SIZE[0]) > 1e-4


def strip(turn=(0.0, 0.0, 0.0)):
    """A plate on which a skew force acts, all turned by a rotation vector."""
    system, rotation = lm.System(), matrix_from_vector(np.array(turn))
    plate = lm.Plate("plate", SIZE, (2, 2), SECTION, rotation=turn)
    system.add(plate)
    system.add(lm.Clamp("root", plate.edge("x-")))
    system.add(lm.EdgeForce("load", plate.edge("y+"), tuple(rotation @ (30.0, 40.0, 8.0))))
    return system, plate, rotation


def solved(system, *items):
    for item in items:
        system.add(item)
    return lm.equilibrium(system, newton=TIGHT)


def test_oblique_support_is_that_of_the_turned_system():
    system, plate, _ = strip()
    motion = {"z": lm.Constant(0.02)}
    straight = solved(system, lm.EdgeSupport("edge", plate.edge("x+"), "yz", motion=motion))
    system, plate, turned = strip(TURN)
    oblique = solved(system, lm.EdgeSupport("edge", plate.edge("x+"), "yz", TURN, motion))
    np.testing.assert_allclose(oblique.final.q.reshape(-1, 3), straight.final.q.reshape(-1, 3) @ turned.T, atol=1e-9)
    for name in ("force", "torque"):
        before, after = straight[f"edge.{name}"].values, oblique[f"edge.{name}"].values
        np.testing.assert_allclose(after, turned @ before, atol=1e-4)
        assert np.abs(before).max() > 1.0
    np.testing.assert_allclose(oblique["edge.force"].values @ turned[:, 0], 0.0, atol=1e-9)  # nothing along the free axis


def test_diaphragm_is_the_edge_support_along_its_plane():
    found = []
    for make in (
        lambda edge: lm.EdgeSupport("edge", edge, "xz"),
        lambda edge: lm.Diaphragm("edge", edge, "y"),
        lambda edge: lm.Diaphragm("edge", edge, (0, -0.5, 0)),
    ):
        system, plate, _ = strip()
        found.append(solved(system, make(plate.edge("y-"))))
    for other in found[1:]:
        np.testing.assert_allclose(other.final.q, found[0].final.q, atol=1e-11)
        np.testing.assert_allclose(other["edge.force"].values, found[0]["edge.force"].values, atol=1e-5)


def test_mean_of_an_edge_is_carried_by_a_dead_load():
    """Held in the mean, the edge carries what an even force along it would."""
    system, plate, _ = strip()
    held = solved(system, lm.EdgeAverage("mean", plate.edge("x+"), "xz", motion={"z": lm.Constant(0.05)}))
    force = held["mean.force"].values
    assert abs(force[2]) > 10.0
    assert abs(force[1]) < 1e-9
    system, plate, _ = strip()
    loaded = solved(system, lm.EdgeForce("carry", plate.edge("x+"), tuple(force / SIZE[1])))
    np.testing.assert_allclose(loaded.final.q, held.final.q, atol=1e-9)


def course(result):
    """Mean position of the edge x+ and its mean direction, int (y - <y>) r dy, by a quadrature of its own."""
    plate, places = result.model.plates[0], np.polynomial.legendre.leggauss(6)
    s, w = np.concatenate([places[0] / 4 + 0.25, places[0] / 4 + 0.75]), np.concatenate([places[1], places[1]]) / 4
    r = np.array([plate.locate((SIZE[0], t * SIZE[1])).at(result.final.q.reshape(-1, 3)) for t in s])
    line = (w * (s - 0.5)) @ r
    return w @ r, line / np.linalg.norm(line)


def test_mean_rotation_is_held_while_the_edge_bends():
    system, plate, _ = strip()
    held = solved(system, lm.EdgeAverage("mean", plate.edge("x+"), rotations="xz"))
    middle, line = course(held)
    np.testing.assert_allclose(middle, (SIZE[0], 0.5 * SIZE[1], 0.0), atol=1e-12)
    np.testing.assert_allclose(line, (0.0, 1.0, 0.0), atol=1e-12)
    tilt = held.final.q.reshape(-1, 3)[[held.model.plates[0].vector(int(k), "r_y") for k in (2, 5, 8)]]
    assert np.abs(tilt[:, 2]).max() > 1e-4  # it bends
    assert np.abs(held["mean.torque"].values[[0, 2]]).min() > 0.1


def test_a_body_carries_and_turns_an_edge_in_the_mean():
    """A hub is turned by 1.2 rad about an axis along y through the edge's mean, and the edge with it."""
    system = lm.System()
    ground, hub = lm.Ground(), lm.RigidBody("hub", mass=1.0, inertia=(0.1, 0.1, 0.1), position=(SIZE[0], 0.3, 0.1))
    plate = lm.Plate("plate", SIZE, (2, 2), SECTION)
    for item in (ground, hub, plate):
        system.add(item)
    axis = (0.4, 0.0, 1.0)
    pin = lm.RevoluteJoint("pin", ground.marker("pin", SIZE[0], 0.3, 0.1), hub.origin, axis=axis)
    system.add(pin)
    system.add(lm.AngleDrive("motor", pin, angle=lm.SmoothStep(t_end=0.1, end=1.2)))
    system.add(lm.EdgeAverage("mean", plate.edge("x+"), rotations="xz", to=hub.origin))
    result = lm.simulate(system, 0.1, lm.GeneralizedAlpha(dt=2e-3, rho_inf=0.8))
    turn = matrix_from_vector(1.2 * np.array(axis) / np.linalg.norm(axis))
    middle, line = course(result)
    np.testing.assert_allclose(middle, (SIZE[0], 0.3, 0.1) + turn @ (0.0, 0.1, -0.1), atol=1e-10)
    np.testing.assert_allclose(line, turn[:, 1], atol=1e-10)
