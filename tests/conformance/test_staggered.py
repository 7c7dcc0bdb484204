"""Temperatures and motion solved one after the other: the parts of the equations, and what it changes in a motion."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

import lamella as lm
from lamella.assembly.equations import Equations
from lamella.assembly.point import Weights
from lamella.integrate.staggered import PartialEquations

FOIL = lm.Laminate(lm.Isotropic(E=2e9, nu=0.3, rho=37.0, alpha=2.3e-5, k=1.5, c=921.0), thickness=0.01)
TIGHT = lm.Newton(tolerance=1e-10, max_iterations=50)


def panel_in_the_sun(damping=0.0, light=1350.0):
    """A panel on a hub that turns in the sun: the flux follows the shape, the shape the temperature."""
    system, ground = lm.System(), lm.Ground()
    hub = lm.RigidBody("hub", mass=100.0, inertia=(200.0, 200.0, 200.0))
    panel = lm.Plate("panel", (4.0, 0.5), (3, 1), FOIL, position=(0.0, -0.25, 0.0), damping=damping)
    for item in (ground, hub, panel):
        system.add(item)
    pin = system.add(lm.RevoluteJoint("pin", ground.origin, hub.origin, axis=(0, 1, 0)))
    system.add(lm.FixedJoint("mount", hub.origin, panel.edge("x-"), kind="restrained"))
    system.add(lm.AngleDrive("motor", pin, angle=lm.SmoothStep(t_end=5.0, end=1.0)))
    panel.marker("tip", 4.0, 0.25)
    system.add(lm.TemperatureField("warmth", panel))
    system.add(lm.SolarFlux("sun", panel, direction=(-0.9, 0.0, -0.42), absorptivity=0.8, constant=light))
    return system


def moving(dt, coupling, end=1.0, **options):
    integrator = lm.GeneralizedAlpha(dt=dt, rho_inf=0.8, coupling=coupling, newton=TIGHT, **options)
    return lm.simulate(panel_in_the_sun(), end, integrator)


@pytest.mark.parametrize("damping", [0.0, 2e-3])
def test_the_parts_are_those_of_the_whole_matrix(damping):
    whole, rng = Equations(panel_in_the_sun(damping).compile()), np.random.default_rng(5)
    point = whole.start()
    point.u = point.u + 0.02 * whole.magnitude * rng.uniform(-1, 1, whole.n_u)
    point.ud = whole.magnitude * rng.uniform(-1, 1, whole.n_u)
    point.lam = rng.standard_normal(whole.n_lam)
    weights, n = Weights(1.0, 30.0, 900.0, 40.0), whole.n_motion
    r, phi, k, j = whole.linearise(point, weights)
    A, J = whole.matrix.pattern.matrix(k).toarray(), whole.matrix.pattern.jacobian(j).toarray()
    assert np.abs(A[:n, n:]).max() > 0  # thermal strain
    assert np.abs(A[n:, :n]).max() > 0  # the sun's flux by the shape
    for first, last, multipliers in ((0, n, True), (n, whole.n_u, False)):
        part = PartialEquations(whole, whole, first, last, multipliers=multipliers)
        own = part.begin(point)
        r_own, phi_own, k_own, j_own = part.linearise(own, weights)
        expected = A[first:last, first:last]
        assert part.pattern.symmetric
        np.testing.assert_allclose(
            part.pattern.matrix(k_own).toarray(), 0.5 * (expected + expected.T), atol=1e-12 * np.abs(expected).max()
        )
        np.testing.assert_array_equal(r_own, r[first:last])
        np.testing.assert_array_equal(part.residual(own)[0], whole.residual(point)[0][first:last])
        np.testing.assert_array_equal(phi_own, phi if multipliers else [])
        np.testing.assert_array_equal(
            part.pattern.jacobian(j_own).toarray(), J[:, first:last] if multipliers else J[:0, first:last]
        )
        assert part.free(0) == whole.free(first)
        if multipliers:
            assert part.free(last) == whole.free(whole.n_u)
        changed = own.u + 1.0
        found = part.completed(type(own)(own.t, changed, own.ud, own.udd, own.lam))
        np.testing.assert_array_equal(found.u[first:last], changed)
        np.testing.assert_array_equal(np.delete(found.u, np.s_[first:last]), np.delete(point.u, np.s_[first:last]))


@pytest.mark.parametrize("stabilised", [False, True])
def test_staggered_steps_differ_by_the_square_of_the_step(stabilised):
    """The predicted motion is off by dt^2, and so is its flux: less than what the step itself leaves out."""
    apart, mean = [], []
    for dt in (0.05, 0.025, 0.0125):
        one, two = (moving(dt, coupling, stabilised=stabilised) for coupling in ("monolithic", "staggered"))
        apart.append(np.abs(one["tip.position"].values - two["tip.position"].values).max())
        mean.append(abs(one["warmth.mean"].values[-1] - two["warmth.mean"].values[-1]))
    bent = np.abs(one["tip.T_M"].values).max() * 2.3e-5 * 4.0**2 / 2  # alpha T_M L^2 / 2
    assert bent > 0.01
    assert apart[0] < 1e-2 * bent
    for differences in (apart, mean):
        for coarse, fine in pairwise(differences):
            assert coarse / fine > 3.0


def test_staggered_steps_with_error_control():
    one, two = (moving(0.02, coupling, tolerance=1e-5) for coupling in ("monolithic", "staggered"))
    ends = one["tip.position"].values[-1], two["tip.position"].values[-1]
    np.testing.assert_allclose(*ends, atol=100 * 1e-5 * 4.0)  # each step is allowed 1e-5 of the size
    assert two.statistics.steps == pytest.approx(one.statistics.steps, rel=0.2)


def test_without_temperatures_there_is_nothing_to_stagger():
    def swing(coupling):
        system = lm.System()
        body = system.add(lm.Plate("plate", (0.4, 0.3), (1, 1), FOIL))
        body.marker("end", 0.4, 0.3)
        system.add(lm.PointSupport("pin", body.marker("held", 0.0, 0.0)))
        system.add(lm.Gravity("gravity"))
        return lm.simulate(system, 0.05, lm.GeneralizedAlpha(dt=0.01, coupling=coupling))["end.position"].values

    np.testing.assert_array_equal(swing("monolithic"), swing("staggered"))
