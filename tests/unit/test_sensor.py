"""Sensors: mean position, the place where an edge passes a plane, and the tension of an edge."""

from __future__ import annotations

import numpy as np
import pytest

import lamella as lm
from lamella.errors import DeclarationError
from lamella.math.rotation import matrix_from_vector
from lamella.state import State

SHEET = lm.Laminate(lm.Isotropic(E="70 GPa", nu=0.3, rho=2700), thickness="2 mm")
TURN = np.array([0.3, -0.5, 0.8])


def state_of(model, q=None, v=None) -> State:
    q = model.q0 if q is None else q
    return State(0.0, q, model.v0 if v is None else v, 0.0 * q, np.zeros(0), np.zeros(0))


def read(model, name, q=None, v=None):
    return next(signal for signal in model.signals if signal.name == name).evaluate(state_of(model, q, v))


def belt(*items) -> lm.System:
    system = lm.System()
    shell = lm.Shell("belt", lm.PulleySurface(((0, 0, 0.1), (0.6, 0, 0.1)), width=0.3), (32, 1), SHEET, position=(0, 0, -0.15))
    ground = lm.Ground()
    for item in (shell, ground, *(make(shell, ground) for make in items)):
        system.add(item)
    return system


def test_the_mean_of_a_plate_is_its_middle_wherever_it_flies() -> None:
    system, spin = lm.System(), np.array([0.2, 1.0, -0.4])
    plate = system.add(
        lm.Plate(
            "p",
            (0.4, 0.2),
            (3, 2),
            SHEET,
            position=(1, 2, 3),
            rotation=tuple(TURN),
            velocity=(0.5, 0, 0),
            angular_velocity=tuple(spin),
        )
    )
    system.add(lm.MeanPosition("mean", plate))
    model = system.compile()
    arm = matrix_from_vector(TURN) @ [0.2, 0.1, 0.0]
    np.testing.assert_allclose(read(model, "mean.position"), np.array([1, 2, 3]) + arm, atol=1e-14)
    np.testing.assert_allclose(read(model, "mean.velocity"), np.array([0.5, 0, 0]) + np.cross(spin, arm), atol=1e-14)


def test_the_mean_of_an_arc_is_its_centroid() -> None:
    """R sin(a)/a from the centre for half the angle a; cubics on 8 elements of 0.125 rad are within 1e-7 of the circle."""
    system = lm.System()
    arc = system.add(lm.Shell("arc", lm.CylinderSurface(2.0, 0.5, angle=(-0.5, 0.5)), (8, 1), SHEET))
    system.add(lm.MeanPosition("mean", arc))
    x, y, _ = read(system.compile(), "mean.position")
    assert np.hypot(x, y) == pytest.approx(2.0 * np.sin(0.5) / 0.5, rel=1e-6)


def test_an_edge_is_seen_where_it_passes_the_sensor() -> None:
    """A plate turned by 0.2 rad in its plane about a corner: its edges are straight lines."""
    system, ground = lm.System(), lm.Ground()
    plate = system.add(lm.Plate("p", (1.0, 0.2), (4, 1), SHEET, position=(0, 0, 0), rotation=(0, 0, 0.2)))
    system.add(ground)
    system.add(lm.EdgeCrossing("eye", plate.edge("y+"), ground.marker("at", 0.5, 0.3, 0.0)))
    system.add(lm.EdgeCrossing("along", plate.edge("x+"), ground.marker("up", 1.0, 0.25, 0.0), normal=(0, 1, 0)))
    system.add(lm.EdgeCrossing("beside", plate.edge("y+"), ground.marker("off", 1.5, 0.0, 0.0)))
    model = system.compile()
    c, s = np.cos(0.2), np.sin(0.2)
    np.testing.assert_allclose(read(model, "eye.position"), [0.5, 0.2 / c + 0.5 * s / c, 0.0], atol=1e-14)
    np.testing.assert_allclose(read(model, "along.position"), [(1.0 - 0.25 * s) / c, 0.25, 0.0], atol=1e-14)
    assert np.isnan(read(model, "beside.position")).all()


def test_a_belt_passes_a_sensor_that_stays_where_it_is() -> None:
    """Of both strands the nearer one is seen; a belt shifted along itself by part of an element is at the same place."""
    upper = lambda shell, ground: lm.EdgeCrossing("upper", shell.edge("y+"), ground.marker("u", 0.31, 0.1, 0.2))  # noqa: E731
    lower = lambda shell, ground: lm.EdgeCrossing("lower", shell.edge("y-"), ground.marker("l", 0.31, -0.1, 0.0))  # noqa: E731
    model = belt(upper, lower).compile()
    mesh = model.plates[0]
    for shift in (0.0, 0.4):
        surface = lm.PulleySurface(((0, 0, 0.1), (0.6, 0, 0.1)), width=0.3)
        j, i = np.divmod(np.arange(mesh.n_nodes), mesh.nodes_x)
        points = surface.at((i + shift) * mesh.lx, j * mesh.ly)
        q = (
            points.vectors(mesh.element.vector_names).reshape(-1, 3) - np.where(mesh.is_position[:, None], [0, 0, 0.15], 0)
        ).reshape(-1)
        for name, place in (("upper", [0.31, 0.1, 0.15]), ("lower", [0.31, -0.1, -0.15])):
            np.testing.assert_allclose(read(model, f"{name}.position", q), place, atol=1e-12)


def test_a_sensor_may_ride_on_a_body() -> None:
    system = lm.System()
    plate = system.add(lm.Plate("p", (1.0, 0.2), (2, 1), SHEET))
    box = lm.Box((0.1, 0.1, 0.1))
    rider = system.add(lm.RigidBody("r", shape=box, density=100, position=(0.5, 0.3, 0.0), rotation=(0, 0, 0.1)))
    system.add(lm.EdgeCrossing("eye", plate.edge("y+"), rider.origin))
    x, y, _ = read(system.compile(), "eye.position")
    assert y == pytest.approx(0.2, abs=1e-14)
    assert x == pytest.approx(0.5 + 0.1 * np.tan(0.1), abs=1e-14)


def test_the_tension_of_an_edge_is_the_mean_membrane_force() -> None:
    """r_x = 1 + c x and r_y = 1: E11 = c x + c^2 x^2 / 2 has the mean c / 2 + c^2 / 6 over the unit length."""
    system = lm.System()
    plate = system.add(lm.Plate("p", (1.0, 0.2), (3, 2), SHEET, prestrain=(1e-3, 0.0, 0.0)))
    for name, side in (("along", "y+"), ("across", "x+")):
        system.add(lm.EdgeTension(name, plate.edge(side)))
    model = system.compile()
    c, mesh = 0.02, model.plates[0]
    q = model.q0.reshape(-1, 3).copy()
    names = mesh.element.vector_names
    for node in range(mesh.n_nodes):
        first = node * len(names)
        x = q[first + names.index("r"), 0]
        q[first + names.index("r"), 0] = x + 0.5 * c * x**2
        q[first + names.index("r_x"), 0] = 1.0 + c * x
    A = SHEET.A
    assert read(model, "along.mean", q.reshape(-1)) == pytest.approx(A[0, 0] * (c / 2 + c**2 / 6 + 1e-3), rel=1e-10)
    assert read(model, "across.mean", q.reshape(-1)) == pytest.approx(A[1, 0] * (c + c**2 / 2 + 1e-3), rel=1e-10)


def test_what_a_sensor_cannot_see_is_refused() -> None:
    plate = lm.Plate("p", (1.0, 0.2), (2, 1), SHEET)
    with pytest.raises(DeclarationError, match=r"EdgeCrossing 'eye': the marker p.m is on a deformable body.*RigidBody's or the"):
        lm.EdgeCrossing("eye", plate.edge("y+"), plate.marker("m", 0.5, 0.1))
    with pytest.raises(DeclarationError, match=r"EdgeCrossing 'eye': normal = \(0, 0, 0\)"):
        lm.EdgeCrossing("eye", plate.edge("y+"), lm.Ground().origin, normal=(0, 0, 0))
    turned = lm.Plate("p", (1.0, 0.2), (2, 1), SHEET, ply_direction=(0, 1, 0))
    with pytest.raises(DeclarationError, match=r"EdgeTension 'T': 'p' has ply_direction = \(0.0, 1.0, 0.0\)"):
        lm.EdgeTension("T", turned.edge("y+"))
    stiff = lm.Plate("p", (1.0, 0.2), (2, 1), SHEET, strain="rigid")
    with pytest.raises(DeclarationError, match=r"EdgeTension 'T': 'p' has strain = 'rigid'"):
        lm.EdgeTension("T", stiff.edge("y+"))
