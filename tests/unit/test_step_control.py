"""Step control: where it pays, and how it goes on after Newton's method has failed."""

from __future__ import annotations

import numpy as np
import pytest
from test_bdf import on_a_spring

import lamella as lm
from lamella.integrate.base import StepOutcome
from lamella.integrate.change import LARGEST_TURN
from lamella.integrate.generalized_alpha import GeneralizedAlphaStepper
from lamella.motion import WAIT
from lamella.result import Cause
from lamella.solve.newton import NewtonReport

SECTION = lm.Laminate(lm.Isotropic(E=2e9, nu=0.3, rho=1200.0), thickness=0.02)


def test_motion_that_comes_to_rest_takes_several_times_fewer_steps():
    """A strip swings after a push and then rests: with fixed steps those of the swing go on to the end."""
    system, plate = lm.System(), lm.Plate("plate", (1.0, 0.3), (2, 1), SECTION, mass_damping=6.0)
    system.add(plate)
    system.add(lm.Clamp("root", plate.edge("x-")))
    system.add(lm.PointForce("load", plate.marker("tip", 1.0, 0.15), (0, 0, 5.0), lm.SmoothStep(t_start=0.0, t_end=0.05)))
    model, every = system.compile(), 0.05

    def course(**options):
        result = lm.simulate(model, 6.0, lm.GeneralizedAlpha(rho_inf=0.5, **options), every=every, stride=10**6)
        return result["tip.position"].values[:, 2], result.statistics

    exact, _ = course(dt=2e-3)

    def error(z):
        return np.sqrt(np.mean((z - exact) ** 2))

    z, controlled = course(dt=1e-2, tolerance=1e-5)
    steps = {dt: error(course(dt=dt)[0]) for dt in (4e-3, 8e-3, 16e-3)}
    needed = min((6.0 / dt for dt, found in steps.items() if found <= error(z)), default=np.inf)
    assert error(z) > steps[4e-3]  # so that the number needed is known
    assert needed > 3.0 * (controlled.steps + controlled.rejected)


def test_a_step_that_failed_is_not_tried_again_at_once(monkeypatch):
    """Steps above 10 ms fail, while the error would allow longer ones: each failure is followed by steps that do not grow."""
    plain = GeneralizedAlphaStepper.step

    def step(self, dt):
        if dt > 0.01:
            return StepOutcome(NewtonReport(Cause.NOT_CONVERGED, 50, 1.0, "made to fail"), None)
        return plain(self, dt)

    monkeypatch.setattr(GeneralizedAlphaStepper, "step", step)
    done = lm.simulate(on_a_spring(), 1.0, lm.GeneralizedAlpha(dt=1e-3, tolerance=1e-3)).statistics
    assert done.rejected >= 2
    assert done.steps >= WAIT * (done.rejected - 1)
    assert done.steps == pytest.approx(1.0 / 0.008, rel=0.2)  # 1, 2, 4, 8 ms, then 16 ms is tried now and then


def test_no_step_turns_a_slope_by_more_than_a_radian():
    """A body that spins by 2 rad a step moves the components of its axes by more than 1 at once: such steps are cut."""
    system = lm.System()
    system.add(lm.RigidBody("top", mass=1.0, inertia=(1.0, 1.0, 1.0), angular_velocity=(0.0, 0.0, 20.0)))
    whole, half = (lm.simulate(system, 0.4, lm.GeneralizedAlpha(dt=dt)) for dt in (0.1, 0.04))
    assert whole.statistics.rejected > 0
    assert half.statistics.rejected == 0
    assert np.abs(np.diff(whole.samples("top.rotation"), axis=0)).max() <= LARGEST_TURN
