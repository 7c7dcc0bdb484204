"""Constraints in motion: what index 3 holds, what the stabilised form adds, and what a small step does to both."""

from __future__ import annotations

import numpy as np
import pytest

import lamella as lm
from lamella.assembly.equations import Equations
from lamella.result import Statistics
from lamella.solve.initial import make_consistent
from lamella.solve.linear import linear_solver

TIGHT = lm.Newton(tolerance=1e-12)
TILT, ARM, SPIN = 0.4, 0.3, 40.0


def double_pendulum():
    """Two rods whose hinges are not parallel, released from the horizontal."""
    system, ground = lm.System(), lm.Ground()
    system.add(ground)
    upper = system.add(lm.RigidBody("upper", mass=1.0, inertia=(0.1, 0.1, 0.02), position=(0.5, 0, 0)))
    lower = system.add(lm.RigidBody("lower", mass=0.7, inertia=(0.05, 0.05, 0.02), position=(1.3, 0, 0)))
    system.add(lm.RevoluteJoint("top", ground.marker("o", 0, 0, 0), upper.marker("in", -0.5, 0, 0), axis=(0, 1, 0)))
    system.add(lm.RevoluteJoint("knee", upper.marker("out", 0.5, 0, 0), lower.marker("at", -0.3, 0, 0), axis=(0, 1, 0.3)))
    system.add(lm.Gravity("weight", (0, 0, -9.81)))
    return system


def spinning_top():
    """A top with its tip in a ball joint."""
    system, ground = lm.System(), lm.Ground()
    system.add(ground)
    axis = np.array([0.0, np.sin(TILT), np.cos(TILT)])
    top = lm.RigidBody(
        "top",
        mass=1.0,
        inertia=(0.01, 0.01, 0.02),
        position=tuple(ARM * axis),
        rotation=(-TILT, 0, 0),
        angular_velocity=tuple(SPIN * axis),
    )
    system.add(top)
    system.add(lm.SphericalJoint("tip", ground.marker("o", 0, 0, 0), top.marker("in", 0, 0, -ARM)))
    system.add(lm.Gravity("weight", (0, 0, -9.81)))
    return system


every_system = pytest.mark.parametrize(
    "make", [double_pendulum, pytest.param(spinning_top, marks=pytest.mark.slow)], ids=["double pendulum", "spinning top"]
)


def walk(system, steps, dt, start=None, **options):
    """Take steps without recording; gives the equations, the last point, the largest violations and the work done."""
    equations, statistics = Equations(system.compile()), Statistics()
    stepper = lm.GeneralizedAlpha(dt=dt, **options).stepper(equations, statistics)
    point = equations.start() if start is None else start.copy()
    make_consistent(equations, point, linear_solver(equations.matrix.pattern, "auto"))
    stepper.restart(point)
    position = velocity = 0.0
    for _ in range(steps):
        outcome = stepper.step(dt)
        assert outcome.point is not None, outcome.report
        point = stepper.accept()
        statistics.steps += 1
        position = max(position, equations.violation(point))
        velocity = max(velocity, equations.relative(equations.velocity_violation(point)))
    return equations, point, (position, velocity), statistics


@every_system
def test_stabilised_form_holds_positions_and_velocities_to_rounding(make):
    _, _, (position, velocity), _ = walk(make(), 2000, 1e-3, rho_inf=0.8, stabilised=True)
    assert position < 1e-12
    assert velocity < 1e-12 * SPIN  # relative to 1 rad/s; the top turns at 40 rad/s


@every_system
def test_index_3_holds_positions_within_its_tolerance(make):
    """The default is meant to hold 1e-10 m for bodies of metres, whatever Newton's tolerance of corrections."""
    options = {"rho_inf": 0.8, "newton": lm.Newton(tolerance=0.1, keep=0.5)}
    equations, point, (position, velocity), _ = walk(make(), 100, 1e-3, **options)
    assert position <= 1e-11
    assert np.abs(equations.position_violation(point)).max() < 1e-10
    assert velocity > 1e-7  # these are not held
    loose = {"rho_inf": 0.8, "newton": lm.Newton(tolerance=0.1, keep=0.5, constraint_tolerance=1.0)}
    assert walk(make(), 100, 1e-3, **loose)[2][0] > 1e-11


@every_system
@pytest.mark.parametrize("stabilised", [False, True])
def test_order_of_positions_velocities_and_multipliers(make, stabilised):
    """With Newton's method proper: a kept factorisation leaves 1e-13 of a constraint in the finest steps, which is 3e-4 in the
    multipliers of index 3, the more the longer it is kept."""
    proper = lm.Newton(tolerance=1e-12, keep=0.0)
    end, options = 0.25, {"rho_inf": 0.8, "newton": proper, "stabilised": stabilised}
    points = [walk(make(), n, end / n, **options)[1] for n in (60, 120, 960)]
    for name in ("u", "ud", "lam"):
        errors = [np.abs(getattr(point, name) - getattr(points[-1], name)).max() for point in points[:-1]]
        assert np.log2(errors[0] / errors[1]) > 1.8, name


def test_stabilised_form_keeps_the_energy_as_well_as_index_3():
    changes = {}
    for stabilised in (False, True):
        result = lm.simulate(double_pendulum(), 0.6, lm.GeneralizedAlpha(dt=5e-3, rho_inf=0.9, stabilised=stabilised))
        changes[stabilised] = np.abs(result["energy.balance"].values).max() / result["energy.kinetic"].values.max()
    assert changes[True] < 1.1 * changes[False]
    assert changes[False] < 1e-3


@every_system
def test_small_steps_degrade_neither_iterations_nor_accuracy(make):
    """Multipliers against those that follow from the position and velocity reached; ten steps from the middle of the motion."""
    system = make()
    middle = walk(system, 200, 1e-3, newton=TIGHT, stabilised=True)[1]
    iterations, errors = {}, {}
    for stabilised in (False, True):
        for dt in (1e-4, 1e-5, 1e-6):
            equations, point, _, statistics = walk(system, 10, dt, middle, rho_inf=0.9, stabilised=stabilised)
            exact = point.copy()
            make_consistent(equations, exact, linear_solver(equations.matrix.pattern, "auto"))
            iterations[stabilised, dt] = statistics.newton_iterations
            errors[stabilised, dt] = np.abs(point.lam - exact.lam).max() / np.abs(exact.lam).max()
        assert iterations[stabilised, 1e-6] <= iterations[stabilised, 1e-5] <= iterations[stabilised, 1e-4]
    assert errors[False, 1e-6] < 2e-2  # some 1e-16 of position divided by dt^2 = 1e-12, against 10 m/s^2
    assert errors[True, 1e-6] < 1e-6  # 1e-16 of velocity divided by dt
    assert errors[True, 1e-6] < 0.2 * errors[True, 1e-5] < 0.04 * errors[True, 1e-4]


def test_stabilised_form_carries_plates_and_rods():
    """An arm on a hinge carries a plate, whose corner hangs on a rod."""
    system, ground = lm.System(), lm.Ground()
    system.add(ground)
    section = lm.Laminate(lm.Isotropic(E=2e9, nu=0.3, rho=1200.0), thickness=0.02)
    arm = system.add(lm.RigidBody("arm", mass=1.0, inertia=(0.1, 0.1, 0.02), position=(0.2, 0, 0)))
    plate = system.add(lm.Plate("plate", (0.5, 0.3), (1, 1), section, position=(0.4, -0.15, 0)))
    system.add(lm.RevoluteJoint("hinge", ground.marker("o", 0, 0, 0), arm.marker("in", -0.2, 0, 0), axis=(0, 1, 0)))
    system.add(lm.FixedJoint("weld", arm.marker("out", 0.2, 0, 0), plate.marker("at", 0.0, 0.15)))
    system.add(lm.DistanceJoint("rod", ground.marker("p", 0.9, 0.5, 0.5), plate.marker("end", 0.5, 0.3)))
    system.add(lm.Gravity("weight", (0, 0, -9.81), lm.SmoothStep(t_end=0.05)))
    _, _, (position, velocity), statistics = walk(system, 40, 2e-3, rho_inf=0.7, stabilised=True)
    assert position < 1e-12
    assert velocity < 1e-12
    assert statistics.newton_iterations < 15 * statistics.steps


def test_without_multipliers_the_option_changes_nothing():
    section = lm.Laminate(lm.Isotropic(E=2e9, nu=0.3, rho=1200.0), thickness=0.02)
    finals = []
    for stabilised in (False, True):
        system, plate = lm.System(), lm.Plate("plate", (1.0, 0.3), (2, 1), section)
        system.add(plate)
        system.add(lm.Clamp("root", plate.edge("x-")))
        system.add(lm.PointForce("load", plate.corner("x+y+"), (0, 0, 20.0)))
        finals.append(lm.simulate(system, 0.01, lm.GeneralizedAlpha(dt=1e-3, stabilised=stabilised)).final.q)
    np.testing.assert_array_equal(*finals)
