"""Linear constraints: what they hold, their multipliers, and their agreement with the joints that they generalise."""

from __future__ import annotations

import numpy as np
import pytest

import lamella as lm
from lamella.math.rotation import matrix_from_vector

SECTION = lm.Laminate(lm.Isotropic(E=2e9, nu=0.3, rho=1200.0), thickness=0.02)
SIZE = (1.2, 0.9)
TURN = (0.1, -0.3, 0.7)
TIGHT = lm.Newton(tolerance=1e-12, keep=0.0)


def loaded():
    system, plate = lm.System(), lm.Plate("plate", SIZE, (2, 2), SECTION, rotation=TURN)
    system.add(plate)
    system.add(lm.Clamp("root", plate.edge("x-")))
    system.add(lm.PointForce("load", plate.marker("at", 0.9, 0.2), (3.0, -2.0, 8.0)))
    return system, plate


def solved(make, motion=False):
    system, plate = loaded()
    system.add(make(plate))
    if motion:
        return lm.simulate(system, 0.02, lm.GeneralizedAlpha(dt=1e-3, newton=TIGHT))
    return lm.equilibrium(system, t=0.03, newton=TIGHT)


def terms(plate):
    return (
        lm.Component(plate.corner("x+y-"), "z", 2.0),
        lm.Component(plate.corner("x+y+"), (0.0, 3.0, -4.0), -1.5),
        lm.Component(plate.corner("x+y+"), "x", 0.4, "slope_x"),
    )


def sum_of(parts, mesh, q):
    """The sum of the terms in a configuration."""
    x, total = q.reshape(-1, 3), 0.0
    for term in parts:
        rows = mesh.locate(term.on.at)
        vector = rows.tangents[0].at(x) if term.of == "slope_x" else rows.at(x)
        axis = np.eye(3)["xyz".index(term.axis)] if isinstance(term.axis, str) else np.array(term.axis) / 5.0
        total += term.factor * float(axis @ vector)
    return total


@pytest.mark.parametrize("motion", [False, True])
def test_one_position_is_a_prescribed_motion(motion):
    drive = lm.Harmonic(amplitude=0.02, frequency=4.0)
    one = solved(lambda p: lm.PrescribedMotion("hold", p.corner("x+y+"), "z", drive), motion)
    other = solved(lambda p: lm.LinearConstraint("hold", (lm.Component(p.corner("x+y+"), "z", 2.0),), _twice(drive)), motion)
    np.testing.assert_allclose(other.final.q, one.final.q, atol=1e-11)
    assert other.history("hold.force").values[-1] * 2 == pytest.approx(one.history("hold.force").values[-1, 2], abs=1e-4)
    assert other.history("work.supports").values[-1] == pytest.approx(one.history("work.supports").values[-1], rel=1e-6)


def _twice(drive):
    return lm.Harmonic(amplitude=2 * drive.amplitude, frequency=drive.frequency)


def test_positions_are_a_position_coupling():
    factors, axes = (2.0, -1.0), ("x", "z")
    one = solved(lambda p: lm.PositionCoupling("hold", (p.corner("x+y-"), p.corner("x+y+")), axes, factors, lm.Constant(0.01)))
    places = ("x+y-", "x+y+")
    other = solved(
        lambda p: lm.LinearConstraint(
            "hold",
            tuple(lm.Component(p.corner(c), axis, factor) for c, axis, factor in zip(places, axes, factors, strict=True)),
            lm.Constant(0.01),
        )
    )
    np.testing.assert_allclose(other.final.q, one.final.q, atol=1e-11)
    assert other["hold.force"].values == pytest.approx(one["hold.force"].values, rel=1e-9)


@pytest.mark.parametrize("motion", [False, True])
@pytest.mark.parametrize("absolute", [False, True])
def test_sum_of_mixed_terms_follows_its_value(absolute, motion):
    system, plate = loaded()
    parts = terms(plate)
    model = system.compile()
    start = sum_of(parts, model.plates[0], model.q0)
    assert abs(start) > 0.1
    base = start if absolute else 0.0
    given = lm.SmoothStep(t_end=0.02, start=base, end=base + 0.03)
    result = solved(lambda p: lm.LinearConstraint("hold", terms(p), given, absolute), motion)
    assert sum_of(parts, model.plates[0], result.final.q) == pytest.approx(start + 0.03, abs=1e-13)


@pytest.mark.parametrize(("of", "quantity"), [("position", "force"), ("slope_x", "torque"), ("slope_y", "torque")])
def test_multiplier_is_the_derivative_of_the_energy_by_the_value(of, quantity):
    """dV/dp = mu for the potential V, strain energy less work of the dead load, in equilibrium (central differences in p)."""
    values, h = [], 1e-4
    for p in (0.01 - h, 0.01, 0.01 + h):
        result = solved(
            lambda plate, p=p: lm.LinearConstraint(
                "hold",
                (lm.Component(plate.corner("x+y+"), (1, 0, 2), 1.0, of), lm.Component(plate.corner("x+y-"), "z", -0.5, of)),
                lm.Constant(p),
            )
        )
        tip = result["at.position"].values
        values.append((float(result["energy.strain"].values) - tip @ (3.0, -2.0, 8.0), float(result[f"hold.{quantity}"].values)))
    slope = (values[2][0] - values[0][0]) / (2 * h)
    assert abs(slope) > 1e-2
    # the potential is smooth in p: h^2 = 1e-8 of its third derivative; rounding of energies of 1 J over 2e-4
    assert values[1][1] == pytest.approx(slope, rel=1e-4)


def test_bodies_of_different_kinds_share_a_relation():
    """A rigid body hangs in a ratio from a plate: its weight times the ratio bends the plate."""
    system, plate, ground = lm.System(), lm.Plate("plate", SIZE, (2, 2), SECTION), lm.Ground()
    weight = lm.RigidBody("weight", mass=0.5, inertia=(1.0, 1.0, 1.0), position=(2.0, 0.0, 0.0))
    for item in (plate, weight, ground, lm.Clamp("root", plate.edge("x-"))):
        system.add(item)
    system.add(lm.PrismaticJoint("guide", ground.marker("rail", 2.0, 0.0, 0.0), weight.origin, axis=(0, 0, 1)))
    tip = plate.marker("tip", 1.2, 0.45)
    fixed = lm.Component(ground.origin, "x", 5.0)  # what does not move adds nothing to a change
    system.add(lm.LinearConstraint("lever", (lm.Component(tip, "z", 3.0), lm.Component(weight.origin, "z", -1.0), fixed)))
    gravity = 9.81
    system.add(lm.PointForce("pull", weight.origin, (0.0, 0.0, -0.5 * gravity)))
    result = lm.equilibrium(system, newton=TIGHT)
    assert float(result["lever.force"].values) == pytest.approx(-0.5 * gravity, rel=1e-8)
    single, plate = lm.System(), lm.Plate("plate", SIZE, (2, 2), SECTION)
    for item in (plate, lm.Clamp("root", plate.edge("x-"))):
        single.add(item)
    single.add(lm.PointForce("pull", plate.marker("tip", 1.2, 0.45), (0.0, 0.0, -1.5 * gravity)))
    bent = lm.equilibrium(single, newton=TIGHT)
    np.testing.assert_allclose(result["tip.position"].values, bent["tip.position"].values, atol=1e-9)


def test_contradicting_constraints_are_refused():
    system, plate = loaded()
    corner = plate.corner("x+y+")
    system.add(lm.PointSupport("pin", corner, "z"))
    system.add(lm.LinearConstraint("hold", (lm.Component(corner, "z", 2.0),), lm.Constant(0.01)))
    with pytest.raises(
        lm.errors.LamellaError, match=r"the linear constraint 'hold' contradicts z of the position at plate\.x\+y\+"
    ):
        lm.equilibrium(system)


def test_oblique_axis_is_a_unit_vector():
    axis = tuple(3.0 * matrix_from_vector(np.array(TURN))[:, 2])
    result = solved(lambda p: lm.LinearConstraint("hold", (lm.Component(p.corner("x+y+"), axis),), lm.Constant(0.03)))
    rows = result.model.plates[0].locate(SIZE)
    moved = rows.at(result.final.q.reshape(-1, 3)) - rows.at(result.model.q0.reshape(-1, 3))
    assert moved @ axis / 3.0 == pytest.approx(0.03, abs=1e-14)
